//! Mazes that a file states cell by cell, each wall twice: what the number formats have in common.

use super::{ParseError, ParseErrorKind, Place};
use crate::{Cell, Heading, MazeSize, Sides, Walls};

/// What a file states of a cell, and where.
pub(super) struct Stated {
    /// The sides with a wall.
    pub(super) sides: Sides,
    pub(super) place: Place,
    /// The file's own words for it.
    pub(super) found: String,
}

/// The walls that all cells agree on.
///
/// # Errors
/// Every contradiction and every gap in the outer wall, by the cells column by column from the
/// south.
pub(super) fn walls<'a>(
    size: MazeSize,
    stated: impl Fn(Cell) -> &'a Stated,
) -> Result<Walls, Vec<ParseError>> {
    let (mut walls, mut errors) = (Walls::open(size), Vec::new());
    for here in (0..size.width()).flat_map(|x| (0..size.height()).map(move |y| Cell { x, y })) {
        let said = stated(here);
        for heading in Heading::ALL {
            let closed = said.sides.has(heading);
            let Some(there) = size.neighbour(here, heading) else {
                if !closed {
                    let expected = format!("{here} closed to the {heading}, an outer wall");
                    let error = ParseError::at(said.place, expected, &said.found);
                    errors.push(error.with_kind(ParseErrorKind::OpenPerimeter).with_cell(here));
                }
                continue;
            };
            // The walls to the south and west were looked at from there.
            if matches!(heading, Heading::South | Heading::West) {
                continue;
            }
            let (other, back) = (stated(there), heading.back());
            if closed != other.sides.has(back) {
                let state = if closed { "closed" } else { "open" };
                let expected = format!(
                    "{there} {state} to the {back}, as {here} is to the {heading} at {}",
                    said.place
                );
                let error = ParseError::at(other.place, expected, &other.found);
                errors.push(error.with_kind(ParseErrorKind::Contradiction).with_cell(there));
            }
            walls.set(here, heading, closed);
        }
    }
    if errors.is_empty() { Ok(walls) } else { Err(errors) }
}
