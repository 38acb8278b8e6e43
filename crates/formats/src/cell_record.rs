//! Records of single cells, for formats that store each inner wall twice: once for each adjacent
//! cell.

use mmsim_maze::{Cell, Heading, MazeSize, Sides, Walls};

use crate::error::{Location, ParseError, ParseErrorKind};

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
pub(crate) fn walls<'a>(
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
