//! The result of reading a maze file.

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Sides, Walls};

use crate::error::{Location, ParseError, ParseErrorKind};

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

/// A cell as recorded in a file.
pub(crate) struct CellRecord {
    /// The sides of the cell that have a wall.
    pub(crate) sides: Sides,
    pub(crate) location: Location,
    /// The record as written in the file, for error messages.
    pub(crate) found: String,
}

/// Returns all cells by column. The columns are listed from west to east, and the cells of a column
/// from south to north.
pub(crate) fn by_columns(size: MazeSize) -> impl Iterator<Item = Cell> {
    (0..size.width()).flat_map(move |x| (0..size.height()).map(move |y| Cell { x, y }))
}

/// Combines the records of all cells into the walls of a maze.
///
/// # Errors
/// Returns an error for each contradiction between adjacent cells and for each gap in the outer
/// wall.
pub(crate) fn walls_of_cells<'a>(
    size: MazeSize,
    record: impl Fn(Cell) -> &'a CellRecord,
) -> Result<Walls, Vec<ParseError>> {
    let (mut walls, mut errors) = (Walls::open(size), Vec::new());
    for cell in by_columns(size) {
        let here = record(cell);
        for heading in Heading::ALL {
            let is_wall = here.sides.has(heading);
            let Some(neighbour) = size.neighbour(cell, heading) else {
                if !is_wall {
                    let expected = format!("an outer wall to the {heading} of {cell}");
                    let error = ParseError::at(here.location, expected, &here.found);
                    errors.push(error.with_kind(ParseErrorKind::OpenPerimeter).with_cell(cell));
                }
                continue;
            };
            // This side was compared when the loop visited the neighbour.
            if matches!(heading, Heading::South | Heading::West) {
                continue;
            }
            let (there, back) = (record(neighbour), heading.back());
            if is_wall != there.sides.has(back) {
                let wall = if is_wall { "a wall" } else { "no wall" };
                let location = here.location;
                let expected = format!("{wall} between {cell} and {neighbour} to match {location}");
                let error = ParseError::at(there.location, expected, &there.found);
                errors.push(error.with_kind(ParseErrorKind::Contradiction).with_cell(neighbour));
            }
            walls.set(cell, heading, is_wall);
        }
    }
    if errors.is_empty() { Ok(walls) } else { Err(errors) }
}
