//! Formats that record each cell by itself, and so each inner wall twice.

use mmsim_maze::{Cell, Heading, MazeSize, Sides, Walls};

use crate::error::{Location, ParseError, ParseErrorKind};

/// The record of one cell in a file.
pub(crate) struct CellRecord {
    /// The sides with a wall.
    pub(crate) sides: Sides,
    pub(crate) location: Location,
    /// The record as written, for error messages.
    pub(crate) found: String,
}

/// Returns the cells column by column from the west, each from the south.
pub(crate) fn by_columns(size: MazeSize) -> impl Iterator<Item = Cell> {
    (0..size.width()).flat_map(move |x| (0..size.height()).map(move |y| Cell { x, y }))
}

/// Returns the walls that all records agree on.
///
/// # Errors
/// Returns every contradiction and every gap in the outer wall, in the order of [`by_columns`].
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
                    let expected = format!("{cell} closed to the {heading}, an outer wall");
                    let error = ParseError::at(here.location, expected, &here.found);
                    errors.push(error.with_kind(ParseErrorKind::OpenPerimeter).with_cell(cell));
                }
                continue;
            };
            // Already compared from the neighbour.
            if matches!(heading, Heading::South | Heading::West) {
                continue;
            }
            let (there, back) = (record(neighbour), heading.back());
            if is_wall != there.sides.has(back) {
                let state = if is_wall { "closed" } else { "open" };
                let expected = format!(
                    "{neighbour} {state} to the {back}, as {cell} is to the {heading} at {}",
                    here.location
                );
                let error = ParseError::at(there.location, expected, &there.found);
                errors.push(error.with_kind(ParseErrorKind::Contradiction).with_cell(neighbour));
            }
            walls.set(cell, heading, is_wall);
        }
    }
    if errors.is_empty() { Ok(walls) } else { Err(errors) }
}
