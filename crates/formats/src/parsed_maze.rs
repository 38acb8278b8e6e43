//! The result of reading a maze file.

use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};

use crate::error::{Location, ParseError};

/// A maze read from a file, and the assumptions that were made to read it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ParsedMaze {
    /// The maze.
    pub maze: Maze,
    /// The locations of walls that the file marks as unknown. Unknown walls are read as open.
    pub unknown_walls: Vec<Location>,
    /// A description of the inferred encoding of hex digits, if the digits could also be read as a
    /// different maze.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// let encoding =
    ///     |digits: &[u8]| Format::Hex.read(digits).map(|parsed| parsed.ambiguous_encoding);
    /// assert_eq!(encoding(b"9113\nec46\n"), Ok(None));
    /// let first = "rows from the north, each starting in the west; \
    ///     bits 1, 2, 4 and 8 are walls to the north, east, south and west";
    /// assert_eq!(encoding(b"bf\nab\nee\n"), Ok(Some(first.into())));
    /// ```
    pub ambiguous_encoding: Option<String>,
}

/// Wraps a maze that was read without any assumptions.
impl From<Maze> for ParsedMaze {
    fn from(maze: Maze) -> Self {
        Self { maze, unknown_walls: Vec::new(), ambiguous_encoding: None }
    }
}

/// Returns the cell at these coordinates, which must be below 32.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn cell(x: usize, y: usize) -> Cell {
    Cell::new(x as u8, y as u8)
}

/// Creates a maze size. Callers check `width` and `height` beforehand in order to report errors
/// with an exact location.
pub(crate) fn size(width: usize, height: usize) -> Result<MazeSize, ParseError> {
    MazeSize::new(width, height).map_err(|error| {
        let found = format!("{}x{}", error.width, error.height);
        ParseError::new(1, 1, "a maze of 1x1 to 32x32 cells", found)
    })
}

/// Builds a maze. The start and the goals must be inside the maze. The default start is (0, 0).
pub(crate) fn maze(walls: Walls, start: Option<Cell>, goals: CellSet) -> Result<Maze, ParseError> {
    Maze::new(walls, start.unwrap_or(Cell::new(0, 0)), goals).map_err(|error| {
        ParseError::new(1, 1, "a start and goals inside the maze", error.cell.to_string())
    })
}

/// Builds a maze with the default start and goal.
pub(crate) fn unmarked_maze(walls: Walls) -> Result<Maze, Vec<ParseError>> {
    Ok(maze(walls, None, CellSet::EMPTY)?)
}
