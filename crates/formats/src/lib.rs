//! Reads and writes micromouse maze files, detects their formats, and lists collections of mazes.
//!
//! What a file contains is recognized by its content, not by its name: posts and walls drawn as
//! text, a number for each cell, or a line for each cell.
//!
//! ```
//! use mmsim_formats::{Choice, Format, Notation, NoteKind};
//!
//! let parsed = Choice::default().read(b"2\n1,6\n1,12\n").unwrap();
//! assert_eq!(parsed.notation, Notation::Numbers);
//! assert_eq!(parsed.maze.to_string(), "\
//! o---o---o
//! | G   G |
//! o   o   o
//! |SG | G |
//! o---o---o
//! ");
//! assert_eq!(Format::Num.write(&parsed.maze)?, b"0 0 0 1 1 1\n0 1 1 0 0 1\n1 0 0 1 1 1\n1 1 1 1 0 0\n");
//!
//! let decorated = Choice::default().read(b"A maze\n+--+--+\n|s   g|\n.--+--+\n").unwrap();
//! assert!(decorated.notes.iter().all(|note| note.kind == NoteKind::Ignored));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`read_maze`] reads a maze file, and [`Catalogue`] lists a folder of maze files or the bundled
//! mazes. Errors report the location, what was expected, and what was found.
#![forbid(unsafe_code)]

mod catalogue;
mod cells;
mod drawing;
mod encoding;
mod error;
mod format;
mod numbers;
mod parsed_maze;
mod read;
mod rows;

pub use catalogue::{Catalogue, Entry};
pub use encoding::{Bits, Encoding, EncodingError, Rows};
pub use error::{Location, Note, NoteKind, ParseError, ParseErrorKind};
pub use format::{Format, WriteError};
pub use parsed_maze::{Notation, ParsedMaze};
pub use read::{
    Choice, MAX_FILE_BYTES, ReadError, parse_maze, read_content, read_content_from, read_maze,
};

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
