//! A micromouse's search run against a maze simulator.
//!
//! [`search_run`] runs a [`Mouse`](mmsim_solvers::Mouse) with any strategy. A [`Transport`]
//! connects the mouse to a simulator. [`Zmq`] connects to a server, with the client of `mmsim-zmtp`
//! or, with the feature `libzmq`, with libzmq. [`InMemory`] passes requests to a function in the same
//! process. [`check_server`] checks that a server follows the protocol.
//!
//! ```
//! use std::ops::ControlFlow;
//! use mmsim_client::{InMemory, search_run};
//! use mmsim_maze::{KnownMaze, Maze};
//! use mmsim_server::Simulation;
//! use mmsim_solvers::{FloodFill, Mouse};
//!
//! let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
//! let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(&maze), maze.start());
//! let mut simulation = Simulation::new("small", maze);
//! let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
//! let run = search_run(&mut transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(()))?;
//! assert!(run.stats.goal_reached());
//! assert_eq!((run.stats.steps(), run.requests), (1, 5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod check_server;
mod exchange;
#[cfg(feature = "libzmq")]
mod libzmq;
mod run;
mod transport;
mod zmq_transport;

pub use check_server::{ServerCheck, check_server};
pub use exchange::{Exchange, decode_reply};
pub use run::{BrokenRun, RunError, SearchRun, search_run, search_run_with};
pub use transport::{BUNDLED_MOUSE_NAME, InMemory, Named, Transport, TransportError};
pub use zmq_transport::{Timeout, Waiting, Zmq};

/// Runs the code in the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
