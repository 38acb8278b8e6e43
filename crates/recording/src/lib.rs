//! Stores the states of a micromouse's search in memory and in files.
//!
//! A recording is an [MCAP](https://mcap.dev) file with the states of one simulation, from reset to
//! reset. No state is lost if the process crashes. The file format is described in
//! docs/recordings.md. Other MCAP tools can also read the files.
//!
//! [`RecordingWriter`] writes one file, [`Recorder`] writes one file for each simulation, and
//! [`save`] writes states that are already in memory. [`Recording`] reads a file. A [`History`]
//! compresses millions of states in memory and reads any of them in microseconds. [`Times`] holds
//! the time of each state.
//!
//! ```text
//! recording/  files with states: written, compressed, read; the names and errors of the format
//! mcap/       the MCAP format: records, chunks, checksums
//! history/    states in memory: compressed blocks, their contexts, logs and times
//! context/    what a client has read and displays at a state, and the updates between states
//! memory      fallible allocation and the budget of open recordings
//! ```
#![forbid(unsafe_code)]

mod context;
mod history;
mod mcap;
mod memory;
mod recording;

pub use context::notes::Notes;
pub use context::update::{
    AnnotationList, Readings, TooManyAnnotations, TrailingAnnotations, Update, UpdateTracker,
};
pub use context::{Context, UpdateEncoder};
pub use history::block::{Block, ScannedState, StateScan, States};
pub use history::log::{LogBlock, LogEnd, LogLine, read_log};
pub use history::times::{Clock, Times};
pub use history::{History, HistoryReader, PushError};
pub use memory::{MemoryBudget, OutOfMemory, free_within_limits};
pub use recording::Recording;
pub use recording::format::{MESSAGE_TOPICS, OpenError, ReadError, RecordError};
pub use recording::reader::{IgnoredRecords, Integrity};
pub use recording::recorder::Recorder;
pub use recording::save::{MessageChannel, NewMessages, PutMessage, StateMessages, save};
pub use recording::sink::is_being_written;
pub use recording::writer::RecordingWriter;

/// Compiles and runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
