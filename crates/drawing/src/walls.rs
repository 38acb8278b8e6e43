//! The walls of a drawing and their classes.

use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, Wall, WallState};

/// Returns all walls that a maze can have, each once: [`MazeSize::walls`], then the outer walls in the
/// south, then those in the west.
pub(crate) fn all(size: MazeSize) -> impl Iterator<Item = Wall> {
    let south = (0..size.width()).map(|x| Wall::new(Cell::new(x, 0), Heading::South));
    let west = (0..size.height()).map(|y| Wall::new(Cell::new(0, y), Heading::West));
    size.walls().chain(south).chain(west)
}

/// The class of a wall that is neither in the true maze nor on the client's map.
pub(crate) const INVISIBLE: &str = "wall";

/// Returns the class attribute of a wall.
pub(crate) fn class(
    Wall { cell, heading, .. }: Wall,
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
    fn each_wall_occurs_once() {
        for (width, height) in [(1, 1), (3, 2), (32, 5)] {
            let size = MazeSize::new(width, height).unwrap();
            // Identify a wall by its midpoint in half cells, so that both adjacent cells agree.
            let middle = |Wall { cell, heading, .. }: Wall| {
                let (x, y) = (2 * u16::from(cell.x) + 1, 2 * u16::from(cell.y) + 1);
                match heading {
                    Heading::North => (x, y + 1),
                    Heading::East => (x + 1, y),
                    Heading::South => (x, y - 1),
                    Heading::West => (x - 1, y),
                }
            };
            let distinct: BTreeSet<_> = all(size).map(middle).collect();
            assert_eq!(all(size).count(), distinct.len());
            assert_eq!(distinct.len(), width * (height + 1) + height * (width + 1));
        }
    }
}
