//! Errors of reading and writing recordings.

use std::io;
use std::path::{Path, PathBuf};

/// A file that could not be opened as a recording.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// Why it could not be read.
    pub source: ReadError,
}

/// Bytes that could not be read as a recording.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The source failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The bytes do not begin like an MCAP file.
    #[error("expected a recording, which is an MCAP file, found something else at byte 0")]
    NotMcap,
    /// The file ends or is damaged before its description of the maze.
    #[error("expected a recording's description of its maze, found {found} at byte {at}")]
    MissingDescription {
        /// Number of intact bytes.
        at: u64,
        /// What follows them.
        found: String,
    },
    /// The description is invalid.
    #[error("expected a recording's description of its maze, found one in which {0}")]
    InvalidDescription(String),
    /// The states need more memory than the budget has left.
    #[error(
        "cannot be opened: only its first {states} states fit into the {} MiB that open recordings \
         share ({}raise --history-limit)",
        limit >> 20,
        if *others > 0 { "close another recording, or " } else { "" }
    )]
    TooLarge {
        /// Number of states that did fit.
        states: usize,
        /// Memory for all open recordings, in bytes.
        limit: usize,
        /// Memory that other recordings use, in bytes.
        others: usize,
    },
    /// The system is out of memory.
    #[error("cannot be opened: out of memory")]
    OutOfMemory,
}

/// A state that could not be recorded, or a recording that could not be closed.
///
/// States written before remain readable.
#[derive(Debug, thiserror::Error)]
#[error("cannot record in {}: {source}", path.display())]
pub struct RecordError {
    /// The file or folder.
    pub path: PathBuf,
    /// The error of the operating system, or what happened to the file.
    pub source: io::Error,
}

impl RecordError {
    pub(crate) fn new(path: &Path, error: impl Into<io::Error>) -> Self {
        Self { path: path.into(), source: error.into() }
    }
}
