//! Errors in the content of a maze file, and notes about it.

use std::fmt;

use mmsim_maze::Cell;

use crate::parsed_maze::ParsedMaze;

/// An error in a maze file: its location, what was expected, and what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{location}: expected {expected}, found {found}")]
#[non_exhaustive]
pub struct ParseError {
    /// The kind of error.
    pub kind: ParseErrorKind,
    /// The location of the error.
    pub location: Location,
    /// The affected cell, if known.
    pub cell: Option<Cell>,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
    /// The mazes that an [ambiguous](ParseErrorKind::Ambiguous) file could mean. Each has at least
    /// one encoding.
    pub readings: Vec<ParsedMaze>,
}

/// The kind of error in a maze file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ParseErrorKind {
    /// The content looks like no maze at all.
    NotAMaze,
    /// The content violates its notation.
    Unreadable,
    /// The numbers of the file could mean several mazes.
    Ambiguous,
    /// Two parts of the file contradict each other.
    Contradiction,
    /// An outer wall is missing.
    OpenPerimeter,
}

/// A remark about a maze file that is unusual but readable.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Note {
    /// The kind of remark.
    pub kind: NoteKind,
    /// The location that the remark is about.
    pub location: Location,
    /// What was found there, and how it was read.
    pub message: String,
}

/// The kind of a [`Note`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NoteKind {
    /// A wall that the file marks as unknown. It is read as open.
    UnknownWall,
    /// Something that has no meaning for the maze, such as a number in a cell.
    Ignored,
    /// The path in the file does not lead from the start to the goal.
    Path,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.message)
    }
}

impl Note {
    pub(crate) fn new(kind: NoteKind, location: Location, message: impl Into<String>) -> Self {
        Self { kind, location, message: message.into() }
    }

    pub(crate) fn ignored(location: Location, found: &str) -> Self {
        Self::new(NoteKind::Ignored, location, format!("ignored {}", quoted(found)))
    }
}

/// A location in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Location {
    /// A location in a text file.
    Text {
        /// The line number, starting at 1.
        line: usize,
        /// The column number in characters, starting at 1.
        column: usize,
    },
    /// The position of a byte in a binary file, starting at 1.
    Byte(usize),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text { line, column } => write!(f, "line {line}, column {column}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

impl Location {
    /// The location of the first character of a text file.
    pub(crate) const FIRST: Self = Self::Text { line: 1, column: 1 };
}

impl ParseError {
    pub(crate) fn new(at: Location, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (kind, expected, found) = (ParseErrorKind::Unreadable, expected.into(), found.into());
        Self { kind, location: at, cell: None, expected, found, readings: Vec::new() }
    }
}

impl From<ParseError> for Vec<ParseError> {
    fn from(error: ParseError) -> Self {
        vec![error]
    }
}

/// Quotes text from a file for an error message. Escapes the text and shortens it to at most 24
/// characters.
pub(crate) fn quoted(found: &str) -> String {
    const MAX_CHARACTERS: usize = 24;
    if found.is_empty() {
        return "the end of the line".to_string();
    }
    match found.char_indices().nth(MAX_CHARACTERS) {
        Some((end, _)) => format!("{:?}…", &found[..end]),
        None => format!("{found:?}"),
    }
}
