//! Reads and writes micromouse maze files, detects their formats, and lists collections of mazes.
//!
//! The format of a file is detected from its content, not from its name:
//!
//! ```
//! use mmsim_formats::{Format, parse_maze};
//!
//! let trial = b"2\n1,6\n1,12\n";
//! assert_eq!(Format::detect(trial), Format::Trial);
//! let maze = parse_maze(trial)?;
//! assert_eq!(maze.to_string(), "\
//! o---o---o
//! | G   G |
//! o   o   o
//! |SG | G |
//! o---o---o
//! ");
//! assert_eq!(Format::Num.write(&maze)?, b"0 0 0 1 1 1\n0 1 1 0 0 1\n1 0 0 1 1 1\n1 1 1 1 0 0\n");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`read_maze`] reads a maze file, and [`Catalogue`] lists a folder of maze files or the bundled
//! mazes. Errors report the location, what was expected, and what was found.
#![forbid(unsafe_code)]

mod catalogue;
mod csv;
mod detect;
mod error;
mod format;
mod grid;
mod hex;
mod maz;
mod num;
mod parsed_maze;
mod read;
mod rows;
mod text;
mod trial;
mod write;

pub use catalogue::{Catalogue, Entry};
pub use error::{Location, ParseError, ParseErrorKind};
pub use format::{Format, FormatNameError};
pub use parsed_maze::ParsedMaze;
pub use read::{MAX_FILE_BYTES, ReadError, parse_maze, read_content, read_content_from, read_maze};
pub use write::WriteError;

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
