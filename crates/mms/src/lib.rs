//! What the micromouse simulator [mms](https://github.com/mackorone/mms) is to a mouse: the commands
//! it understands, where they take the mouse, and how they are scored.
//!
//! ```text
//!    stdout of the mouse       ┌─────────┐  is there a wall?   ┌──────────────┐
//!   ─────────────────────────► │         │ ──────────────────► │              │
//!    one line, one Command     │  Mouse  │                     │ Surroundings │
//!   ◄───────────────────────── │         │ ──────────────────► │              │
//!    a Reply, or none          └─────────┘  the mouse moved    └──────────────┘
//! ```
//!
//! [`Command::parse`] reads a line, [`Mouse::obey`] does what it says and gives the [`Reply`] to
//! write. Walls come from whatever is asked for them, [`Surroundings`]; the walls of a maze are one.
//! Nothing here knows a process, a pipe or a clock.
//!
//! ```
//! use mmsim_maze::Maze;
//! use mmsim_mms::{Command, Mouse, Reply};
//!
//! let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
//! let (size, mut walls) = (maze.size(), maze.walls().clone());
//! let mut mouse = Mouse::new(size, maze.start().cell, *maze.goals());
//! for (line, reply) in [("wallFront", "true"), ("turnRight", "ack"), ("moveForward 9", "crash")] {
//!     let Ok(replied) = mouse.obey(Command::parse(line.as_bytes(), size)?, &mut walls);
//!     assert_eq!(replied.map(|replied| replied.to_string()).as_deref(), Some(reply));
//! }
//! assert!(maze.goals().contains(mouse.pose().cell), "it went as far as it could");
//! assert_eq!(mouse.scores().total().distance(), 1.);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod command;
mod grid_point;
mod mouse;
mod reply;
mod scores;

pub use command::{Command, CommandError, excerpt};
pub use grid_point::{Bearing, GridPoint, Place};
pub use mouse::{Mouse, Surroundings};
pub use reply::{Decimal, Reply};
pub use scores::{Run, Scores, Stat};

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
