//! Micromouse mazes: cells, walls, the true maze, what a mouse knows of it, and the files they
//! are kept in.
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
//! Cell (0, 0) is the south-west corner, x grows east, y grows north, and the mouse starts heading
//! north. Sizes are run-time values from 1×1 to 32×32, square or not.
//!
//! Two types hold walls for two kinds of people: [`Maze`] is the truth, which only a simulator
//! has; [`KnownMaze`] is what a mouse has seen, where each wall is present, absent or unknown.
//! Both store a wall once ([`Walls`]), so two cells cannot disagree about the one between them,
//! and both count everything outside of the maze as a wall, so nobody checks bounds.
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
//! # Ok::<(), mmsim_maze::ParseError>(())
//! ```
//!
//! The crate is `no_std` and allocates nothing unless its feature `std` (on by default) is there,
//! which adds the formats, the files and the folders of them.
#![forbid(unsafe_code)]
#![cfg_attr(not(any(test, feature = "std")), no_std)]

#[cfg(feature = "std")]
mod catalogue;
mod cell;
mod cell_set;
mod escaped;
mod excerpt;
#[cfg(feature = "std")]
mod file;
#[cfg(feature = "std")]
mod format;
mod heading;
mod known;
mod maze;
mod picture;
mod walls;

#[cfg(feature = "std")]
pub use catalogue::{Catalogue, CatalogueError, Entry};
pub use cell::{Cell, MazeSize, SizeError};
pub use cell_set::CellSet;
pub use escaped::{Escaped, needs_escape};
pub use excerpt::Excerpt;
#[cfg(feature = "std")]
pub use file::{MAX_FILE_BYTES, ReadError, maze_content, maze_content_of};
#[cfg(feature = "std")]
pub use format::{Format, FormatNameError, ParseError, ParseErrorKind, Place, Reading, WriteError};
pub use heading::{Heading, Pose, Step};
pub use known::{Contradiction, KnownMaze, Unknown, WallState};
pub use maze::{Maze, MazeError};
pub use picture::TextPicture;
pub use walls::{Sides, Walls, WallsAround};

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
