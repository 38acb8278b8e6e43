//! Where walls can be, and what is said of each.

use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, WallState};

/// A place where a wall can be: a side of a cell.
pub(crate) type Place = (Cell, Heading);

/// Every place of a maze once: of each cell, in the order of [`MazeSize::cells`], the north side and
/// the east side; then the south sides of the south row; then the west sides of the west column.
pub(crate) fn places(size: MazeSize) -> impl Iterator<Item = Place> {
    let inner = size.cells().flat_map(|cell| [(cell, Heading::North), (cell, Heading::East)]);
    let south = (0..size.width()).map(|x| (Cell::new(x, 0), Heading::South));
    let west = (0..size.height()).map(|y| (Cell::new(0, y), Heading::West));
    inner.chain(south).chain(west)
}

/// What is said of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WallClass {
    /// The true maze has it.
    pub(crate) stands: bool,
    /// What the client believes of it.
    pub(crate) belief: Belief,
}

/// What a client believes of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Belief {
    /// It does not believe in the wall.
    None,
    /// It believes in the wall, and rightly so, or nobody knows better.
    Known,
    /// It believes in the wall, and there is none.
    Mistaken,
}

impl WallClass {
    /// What is to be said of the wall at `place`.
    pub(crate) fn of(place: Place, truth: Option<&Maze>, map: Option<&KnownMaze>) -> Self {
        let (cell, heading) = place;
        let stands = truth.is_some_and(|maze| maze.walls().has(cell, heading));
        let is_believed = map.is_some_and(|map| map.wall(cell, heading) == WallState::Present);
        let belief = match (is_believed, stands || truth.is_none()) {
            (false, _) => Belief::None,
            (true, true) => Belief::Known,
            (true, false) => Belief::Mistaken,
        };
        Self { stands, belief }
    }

    /// Its classes in the drawing.
    pub(crate) const fn names(self) -> &'static str {
        match (self.stands, self.belief) {
            (false, Belief::None) => "wall",
            (true, Belief::None) => "wall true",
            (false, Belief::Known) => "wall known",
            (true, Belief::Known) => "wall true known",
            (_, Belief::Mistaken) => "wall mistaken",
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn each_place_comes_once() {
        for (width, height) in [(1, 1), (3, 2), (32, 5)] {
            let size = MazeSize::new(width, height).unwrap();
            // A place as the point in its middle, in half cells, so that both cells agree on it.
            let middle = |(cell, heading): Place| {
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
