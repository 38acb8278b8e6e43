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
#![forbid(unsafe_code)]

mod block;
mod changes;
mod chunk;
mod compressor;
mod context;
mod context_block;
mod context_log;
mod description;
mod error;
mod history;
mod layer;
mod layout;
mod log;
mod mcap_reader;
mod mcap_record;
mod mcap_writer;
mod memory;
mod messages;
mod notes;
mod pack;
mod reader;
mod recorder;
mod recording;
mod save;
mod scan;
mod sink;
mod slabs;
mod times;
mod update;
mod update_tracker;
mod writer;

pub use block::{Block, States};
pub use context::{Context, UpdateEncoder};
pub use error::{OpenError, ReadError, RecordError};
pub use history::{History, HistoryReader, PushError};
pub use log::{LogBlock, LogEnd, LogLine, read_log};
pub use memory::{MemoryBudget, OutOfMemory, free_within_limits};
pub use messages::{MessageChannel, NewMessages, PutMessage, StateMessages};
pub use notes::Notes;
pub use reader::Integrity;
pub use recorder::Recorder;
pub use recording::Recording;
pub use save::save;
pub use scan::{ScannedState, StateScan};
pub use times::{Clock, Times};
pub use update::{AnnotationList, Readings, Update};
pub use update_tracker::{TooManyAnnotations, UpdateTracker};
pub use writer::RecordingWriter;

/// Compiles and runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
