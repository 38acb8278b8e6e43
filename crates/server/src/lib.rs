//! A micromouse maze simulator. The simulator holds the true maze, reveals to a search client only
//! the walls around the mouse, and keeps every state that the client reports.
//!
//! [`Simulation`] turns the bytes of any request into the bytes of its reply. A simulation does no
//! input or output and never panics. [`Server`] serves a simulation over ZeroMQ. The crate
//! `mmsim-recording` stores the states, in memory and in files.
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
//! # Ok::<(), mmsim_maze::ParseMazeError>(())
//! ```
#![forbid(unsafe_code)]

mod control;
mod monitor;
mod server;
mod service;
mod simulation;

pub use control::{Status, StopHandle};
pub use mmsim_zmtp::{BindError, listen, network};
pub use monitor::{Monitor, MonitorError, Served};
pub use server::{Background, LIMITS, ServeError, Server};
pub use simulation::{Change, ReplyBuffer, Simulation};

/// Compiles the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
