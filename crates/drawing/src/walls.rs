//! The places where a maze can have walls, and the classes of walls in a drawing.

use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, WallState};

/// A place where a wall can be, given as a cell and one of its sides.
pub(crate) type WallPlace = (Cell, Heading);

/// Returns all places where a maze can have a wall. No place is returned twice. First come the
/// north and east sides of each cell in the order of [`MazeSize::cells`], then the south sides of
/// the southernmost row, then the west sides of the westernmost column.
pub(crate) fn places(size: MazeSize) -> impl Iterator<Item = WallPlace> {
    let inner = size.cells().flat_map(|cell| [(cell, Heading::North), (cell, Heading::East)]);
    let south = (0..size.width()).map(|x| (Cell::new(x, 0), Heading::South));
    let west = (0..size.height()).map(|y| (Cell::new(0, y), Heading::West));
    inner.chain(south).chain(west)
}

/// Returns the places where a maze can have a wall between two cells, in the order of [`places`].
pub(crate) fn inner_places(size: MazeSize) -> impl Iterator<Item = WallPlace> {
    places(size).filter(move |&(cell, heading)| size.neighbour(cell, heading).is_some())
}

/// The class of a wall that is neither in the true maze nor on the client's map.
pub(crate) const INVISIBLE: &str = "wall";

/// Returns the class attribute of the wall at `place`.
pub(crate) fn class(
    (cell, heading): WallPlace,
    truth: Option<&Maze>,
    map: Option<&KnownMaze>,
) -> &'static str {
    let stands = truth.is_some_and(|maze| maze.walls().has(cell, heading));
    let reported = map.map_or(WallState::Unknown, |map| map.wall(cell, heading));
    match (stands, reported) {
        (false, WallState::Absent | WallState::Unknown) => INVISIBLE,
        (true, WallState::Unknown) => "wall true",
        (true, WallState::Absent) => "wall true missed",
        (true, WallState::Present) => "wall true known",
        (false, WallState::Present) if truth.is_none() => "wall known",
        (false, WallState::Present) => "wall mistaken",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_place_occurs_once() {
        for (width, height) in [(1, 1), (3, 2), (32, 5)] {
            let size = MazeSize::new(width, height).unwrap();
            // Identify a place by its midpoint in half cells, so that both adjacent cells agree.
            let middle = |(cell, heading): WallPlace| {
                let (x, y) = (2 * u16::from(cell.x) + 1, 2 * u16::from(cell.y) + 1);
                match heading {
                    Heading::North => (x, y + 1),
                    Heading::East => (x + 1, y),
                    Heading::South => (x, y - 1),
                    Heading::West => (x - 1, y),
                }
            };
            let distinct: BTreeSet<_> = places(size).map(middle).collect();
            assert_eq!(places(size).count(), distinct.len());
            assert_eq!(distinct.len(), width * (height + 1) + height * (width + 1));
        }
    }
}
