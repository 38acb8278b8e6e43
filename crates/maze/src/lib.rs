//! Micromouse mazes: cells, walls, the true maze, and a mouse's map of it.
//!
//! ```text
//!        north, y                 posts and walls of a 2×2 maze:
//!          ▲                          o---o---o
//!          │                          |     G |     cell (1, 1), the goal
//!  west ◄──┼──► east, x               o   o---o
//!          │                          | S     |     cell (0, 0), the start
//!          ▼                          o---o---o
//!        south
//! ```
//!
//! Cell (0, 0) is in the south-west corner; x grows to the east and y to the north. The mouse
//! starts facing north. A maze has 1×1 to 32×32 cells and need not be square. The size of a maze is
//! chosen at run time. Without the feature `half-size` (enabled by default), mazes have at most 16×16
//! cells and take a quarter of the memory.
//!
//! [`Maze`] is the true maze, which only a simulator knows. [`KnownMaze`] is the map that a mouse
//! builds: each wall is known to be present, known to be absent, or unknown. [`Maze`] and
//! [`KnownMaze`] store each wall once (in [`Walls`]), so two cells cannot disagree about the wall
//! between them. Each wall has one name ([`Wall`]) and one number. Everything outside the maze counts
//! as a wall, so callers need no bounds checks.
//!
//! ```
//! use mmsim_maze::{Heading, Maze, Step};
//!
//! let maze: Maze = "\
//! o---o---o
//! |     G |
//! o   o---o
//! | S     |
//! o---o---o
//! ".parse()?;
//! let start = maze.start();
//! let ahead = start.after(Step::Front).unwrap();
//! assert_eq!(start.heading, Heading::North);
//! assert!(!maze.walls().around(start).front);
//! assert!(maze.goals().contains(ahead.after(Step::Right).unwrap().cell));
//! # Ok::<(), mmsim_maze::ParseMazeError>(())
//! ```
//!
//! The crate is `no_std` and does not allocate. The `mmsim-formats` crate reads maze files.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), no_std)]
// Marks the items of optional features on docs.rs.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod cell;
mod cell_set;
mod colour;
mod escaped;
mod heading;
mod known;
mod lattice;
mod maze;
mod misreadings;
mod parse;
mod picture;
mod symmetry;
mod walls;
mod wy_rand;

pub use cell::{Cell, MazeSize, Pose, SizeError};
pub use cell_set::{CellMap, CellSet, CellSetIter, Row};
pub use colour::Colour;
pub use escaped::{Counted, Escaped, Excerpt, counted, needs_escape};
pub use heading::{Heading, Step};
pub use known::{Contradiction, KnownMaze, Unknown, WallState};
pub use lattice::{Direction, Point};
pub use maze::{Maze, MazeError};
pub use misreadings::{Misreadings, WallSensor};
pub use parse::ParseMazeError;
pub use picture::TextPicture;
pub use symmetry::Symmetry;
pub use walls::{Sides, Wall, Walls, WallsAround};
pub use wy_rand::WyRand;

/// Runs the README examples as doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
