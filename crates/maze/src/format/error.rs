//! What is wrong with a maze file, and why one cannot be written.

use std::fmt;

use super::Format;
use crate::{Cell, MazeSize};

/// A maze file that cannot be understood: where, what was expected there, what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: expected {expected}, found {found}")]
pub struct ParseError {
    /// What kind of fault it is.
    pub kind: ParseErrorKind,
    /// Where in the file.
    pub place: Place,
    /// The cell that it is about, where the format says so.
    pub cell: Option<Cell>,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
}

/// What kind of fault a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ParseErrorKind {
    /// The content is not what the format asks for.
    Unreadable,
    /// Two places of the file disagree.
    Contradiction,
    /// An outer wall is missing.
    OpenPerimeter,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Place {
    /// Of a text.
    Text {
        /// The line, counted from 1.
        line: usize,
        /// The column in characters, counted from 1.
        column: usize,
    },
    /// The byte of a file that is no text, counted from 1.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text { line, column } => write!(f, "line {line}, column {column}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// A maze that a [`Format`] cannot hold: what it can hold, and what the maze has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The format is one that is only read.
    #[error("expected a format that can be written, {}, found {format}", writable())]
    ReadOnly {
        /// The format.
        format: Format,
    },
    /// Mazes of this size have no place in it.
    #[error("{format} holds mazes of {expected}, found one of {found}")]
    Size {
        /// The format.
        format: Format,
        /// The sizes that it can hold.
        expected: &'static str,
        /// The size of the maze.
        found: MazeSize,
    },
    /// It marks no start, and its readers would start elsewhere.
    #[error("{format} marks no start: expected it at (0, 0), found it at {found}")]
    Start {
        /// The format.
        format: Format,
        /// The start of the maze.
        found: Cell,
    },
    /// It marks no goal, and its readers would go elsewhere.
    #[error("{format} marks no goal: expected the central cells {expected}, found {found}")]
    Goal {
        /// The format.
        format: Format,
        /// The central cells.
        expected: String,
        /// The goal cells of the maze.
        found: String,
    },
}

/// A name that no [`Format`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {}, found {found:?}", Format::ALL.map(Format::name).join(", "))]
pub struct FormatNameError {
    /// The name.
    pub found: String,
}

/// The names of the formats that can be written.
fn writable() -> String {
    let names: Vec<&str> =
        Format::ALL.into_iter().filter(|format| format.is_writable()).map(Format::name).collect();
    names.join(", ")
}

impl ParseError {
    pub(super) fn new(
        line: usize,
        column: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::at(Place::Text { line, column }, expected, found)
    }

    pub(super) fn at(place: Place, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (kind, expected, found) = (ParseErrorKind::Unreadable, expected.into(), found.into());
        Self { kind, place, cell: None, expected, found }
    }

    /// The same as a fault of this kind.
    pub(super) fn with_kind(self, kind: ParseErrorKind) -> Self {
        Self { kind, ..self }
    }

    /// The same as a fault of this cell.
    pub(super) fn with_cell(self, cell: Cell) -> Self {
        Self { cell: Some(cell), ..self }
    }

    /// The error for a file that goes on after this content, the most that is read.
    pub(crate) fn too_large(content: &[u8]) -> Self {
        let lines = content.split(|&byte| byte == b'\n');
        let column = lines.clone().next_back().map_or(0, <[u8]>::len) + 1;
        let line = lines.count();
        let expected = format!("the end of the file before byte {}", content.len());
        Self::new(line, column, expected, "more")
    }
}

impl From<ParseError> for Vec<ParseError> {
    fn from(error: ParseError) -> Self {
        vec![error]
    }
}

/// Some of the file's own text for an error message: in quotes, escaped, not too long.
pub(super) fn quoted(found: &str) -> String {
    const LONGEST: usize = 24;
    if found.is_empty() {
        return "the end of the line".to_string();
    }
    match found.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &found[..end]),
        None => format!("{found:?}"),
    }
}
