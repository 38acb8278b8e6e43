//! Errors in requests.

use mmsim_maze::{Cell, Excerpt, MazeSize};

use crate::layout::{MAX_ANNOTATIONS_BYTES, WALLS_REQUEST_BYTES, state_bytes};

/// The reason why a simulator cannot serve a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// The message is not a known request.
    #[error("expected ping, reset, info, W, S or A, found {0}")]
    Unknown(Excerpt<16>),
    /// The length of the walls request is not 4 bytes.
    #[error("expected W, x, y and heading ({WALLS_REQUEST_BYTES} bytes), found {found} bytes")]
    WallsLength {
        /// The length of the message in bytes.
        found: usize,
    },
    /// The length of the state does not match the size of the maze.
    #[error(
        "expected a state of {} bytes for a maze of {size} cells, found {found} bytes",
        state_bytes(*size)
    )]
    StateLength {
        /// The size of the simulator's maze.
        size: MazeSize,
        /// The length of the message in bytes.
        found: usize,
    },
    /// The heading is not `N`, `E`, `S` or `W`.
    #[error("expected N, E, S or W as the heading, found {}", Excerpt::<1>::new(&[*found]))]
    Heading {
        /// The byte.
        found: u8,
    },
    /// The order of a matrix is neither `C` nor `F`.
    #[error("expected C or F as the order of the {matrix}, found {}", Excerpt::<1>::new(&[*found]))]
    Order {
        /// `weights` or `walls`.
        matrix: &'static str,
        /// The byte.
        found: u8,
    },
    /// The annotations request has no annotations or is too long.
    #[error("expected A and annotations (2 to {MAX_ANNOTATIONS_BYTES} bytes), found {found} bytes")]
    AnnotationsLength {
        /// The length of the message in bytes.
        found: usize,
    },
    /// An annotation is invalid.
    #[error("expected {expected}, found {found} at byte {offset}")]
    Annotation {
        /// The position in the message, counted from 0.
        offset: usize,
        /// The valid values.
        expected: &'static str,
        /// The rest of the message.
        found: Excerpt<16>,
    },
    /// The message ends within an annotation.
    #[error("expected {expected}, found the end of the message")]
    AnnotationEnd {
        /// The valid values.
        expected: &'static str,
    },
    /// The message ends within the text of an annotation.
    #[error("expected {length} bytes of text at byte {offset}, found {found}")]
    TextEnd {
        /// The position of the text in the message, counted from 0.
        offset: usize,
        /// The length of the text in bytes, according to the message.
        length: usize,
        /// The number of bytes up to the end of the message.
        found: usize,
    },
    /// The cell is outside the maze.
    #[error("expected a cell in a maze of {size} cells, found {cell}")]
    Outside {
        /// The cell.
        cell: Cell,
        /// The size of the simulator's maze.
        size: MazeSize,
    },
    /// The message has several frames.
    #[error("expected one frame, found {found}")]
    Frames {
        /// The number of frames.
        found: usize,
    },
}
