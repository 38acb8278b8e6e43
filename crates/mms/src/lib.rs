//! The mouse API of the simulator [mms](https://github.com/mackorone/mms): commands, movement in
//! half steps, and scorekeeping.
//!
//! ```text
//!    stdout of the mouse      ┌────────────────┐  is there a wall?   ┌─────────────┐
//!   ────────────────────────► │                │ ──────────────────► │             │
//!    one Command a line       │ SimulatedMouse │                     │ Environment │
//!   ◄──────────────────────── │                │ ──────────────────► │             │
//!    a Response, or none      └────────────────┘  the pose changed   └─────────────┘
//! ```
//!
//! [`Command::parse`] parses a line, and [`SimulatedMouse::execute`] executes the command and
//! returns the [`Response`]. An [`Environment`] provides the walls; [`Walls`](mmsim_maze::Walls)
//! implements this trait. The crate uses no processes, pipes or clocks.
//!
//! ```
//! use mmsim_maze::Maze;
//! use mmsim_mms::{Command, SimulatedMouse};
//!
//! let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
//! let (size, mut walls) = (maze.size(), maze.walls().clone());
//! let mut mouse = SimulatedMouse::new(size, maze.start().cell, *maze.goals());
//! for (line, expected) in [("wallFront", "true"), ("turnRight", "ack"), ("moveForward 9", "crash")] {
//!     let Ok(response) = mouse.execute(Command::parse(line.as_bytes(), size)?, &mut walls);
//!     assert_eq!(response.map(|response| response.to_string()).as_deref(), Some(expected));
//! }
//! assert!(maze.goals().contains(mouse.pose().cell), "it moved until the wall");
//! assert_eq!(mouse.scores().total().distance(), 18., "mms counts the requested half steps");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod command;
mod display;
mod driven_run;
mod mouse;
mod response;
mod scores;

pub use command::{Command, CommandError, excerpt};
pub use display::{CellText, Display};
pub use mouse::{Environment, SimulatedMouse};
pub use response::{GeneralFormat, Response};
pub use scores::{ScoreRules, Scores, Stat, TravelStats};

/// Runs the README examples as doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
