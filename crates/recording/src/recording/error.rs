//! Errors from reading and writing recordings.

use std::io;
use std::path::{Path, PathBuf};

/// The error when a file cannot be opened as a recording.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// The reason why the file could not be read.
    pub source: ReadError,
}

/// The reason why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Reading the data failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The data does not begin with the signature of an MCAP file.
    #[error("expected a recording (an MCAP file), found other data at byte 0")]
    NotMcap,
    /// The file ends or is damaged before its description of the maze.
    #[error("expected a description of the maze, found {found} at byte {at}")]
    MissingDescription {
        /// The number of intact bytes at the beginning of the file.
        at: u64,
        /// The reason why the next record is invalid, or `the end of the file`.
        found: String,
    },
    /// The description of the maze is invalid.
    #[error("the description of the maze is invalid: {0}")]
    InvalidDescription(String),
    /// The states need more memory than the budget has left.
    #[error(
        "cannot be opened: only its first {states} states fit into the {} MiB that open recordings \
         share ({}raise --history-limit)",
        limit >> 20,
        if *others > 0 { "close another recording, or " } else { "" }
    )]
    TooLarge {
        /// The number of states of the recording that fit into the remaining memory.
        states: usize,
        /// The memory limit for all open recordings together, in bytes.
        limit: usize,
        /// The memory that other open recordings use, in bytes.
        others: usize,
    },
    /// The system is out of memory.
    #[error("cannot be opened: out of memory")]
    OutOfMemory,
}

/// The error when a state cannot be recorded or a recording cannot be closed.
///
/// States that were written before the error remain readable.
#[derive(Debug, thiserror::Error)]
#[error("cannot record in {}: {source}", path.display())]
pub struct RecordError {
    /// The path of the recording or of its folder.
    pub path: PathBuf,
    /// The operating system's error, or an error that describes how another program changed the
    /// file.
    pub source: io::Error,
}

impl RecordError {
    pub(crate) fn new(path: &Path, error: impl Into<io::Error>) -> Self {
        Self { path: path.into(), source: error.into() }
    }
}
