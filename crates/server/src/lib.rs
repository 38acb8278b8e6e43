//! A micromouse maze simulator. It holds the true maze, reveals only the walls around the mouse to a
//! search client, and keeps every state that the client reports.
//!
//! [`Simulation`] does no I/O: it turns the bytes of any request into the bytes of its reply and never
//! panics. [`Server`] is the ZeroMQ server around it. A [`History`] holds millions of states; a
//! [`Recorder`] writes them to files, which [`Recording`] reads.
//!
//! ```
//! use mmsim_maze::Maze;
//! use mmsim_server::{ReplyBuffer, Simulation};
//!
//! let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
//! let mut simulation = Simulation::new("small", maze);
//! let mut reply = ReplyBuffer::new();
//! simulation.handle(b"W\x00\x00N", &mut reply);
//! assert_eq!(reply, [1, 1, 0]);
//! simulation.handle(b"what?", &mut reply);
//! assert!(reply.starts_with(b"error: expected "));
//! # Ok::<(), mmsim_maze::ParseError>(())
//! ```
#![forbid(unsafe_code)]

mod background;
mod block;
mod budget;
mod clock;
mod control;
mod history;
mod memory;
mod monitor;
mod motion_count;
mod recording;
mod server;
mod service;
mod simulation;
mod slabs;
mod status;
mod times;

pub use background::Background;
pub use block::{Block, States};
pub use budget::MemoryBudget;
pub use control::StopHandle;
pub use history::{Full as HistoryFull, History, PushError, Reader as HistoryReader};
pub use mmsim_zmtp::{BindError, limits, listen};
pub use monitor::{Monitor, MonitorError, Served};
pub use motion_count::MotionCount;
pub use recording::{
    Ending, NoRecording, RecordError, Recorder, Recording, RecordingError, RecordingWriter,
    save as save_recording,
};
pub use server::{ServeError, Server};
pub use simulation::{Change, ReplyBuffer, Simulation};
pub use status::Status;
pub use times::Times;

/// Compiles the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
