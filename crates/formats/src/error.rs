//! Errors in the content of a maze file.

use std::fmt;

use mmsim_maze::Cell;

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
}

/// The kind of error in a maze file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ParseErrorKind {
    /// The content violates the format.
    Unreadable,
    /// Two parts of the file contradict each other.
    Contradiction,
    /// An outer wall is missing.
    OpenPerimeter,
}

/// A location in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

impl ParseError {
    /// Creates an error at a line and column of a text file.
    pub(crate) fn new(
        line: usize,
        column: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::at(Location::Text { line, column }, expected, found)
    }

    pub(crate) fn at(at: Location, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (kind, expected, found) = (ParseErrorKind::Unreadable, expected.into(), found.into());
        Self { kind, location: at, cell: None, expected, found }
    }

    pub(crate) fn with_kind(self, kind: ParseErrorKind) -> Self {
        Self { kind, ..self }
    }

    pub(crate) fn with_cell(self, cell: Cell) -> Self {
        Self { cell: Some(cell), ..self }
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
