//! The probability of a wall, given its neighbouring walls.

use mmsim_maze::Maze;

use super::contest;
use super::maze_batch::MazeBatch;

/// The probability of a wall at a site, given the walls at the eight neighbouring sites. Six of the
/// neighbouring sites share a post with the central site. Two are parallel to it, on the far sides
/// of the two adjacent cells.
///
/// ```text
///        o---8---o         1, 4  in line, beyond a post
///        |       |         2, 3, 5, 6  at a right angle at a post
///        3       6         7, 8  parallel, across a cell
///        |       |
///    o-1-o---?---o-4-o
///        |       |
///        2       5
///        |       |
///        o---7---o
/// ```
///
/// The prior captures typical properties of contest mazes. For example, each post touches at least
/// one wall, crossings are rare, and corridors are more frequent than open areas. In statistical
/// terms, the prior is a Markov random field over the walls, fitted by pseudo-likelihood (Besag,
/// 1975).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct WallPrior {
    /// The probabilities in units of 1/256. Bit i - 1 of the index is set if site i in the drawing
    /// above has a wall.
    wall: [u8; 256],
}

impl WallPrior {
    /// The prior learnt from 248 classic contest mazes.
    pub const CONTEST: Self = Self { wall: contest::WALL };

    /// Learns the prior from mazes. Sites next to goal cells are ignored, because the walls of a
    /// goal room follow a different pattern.
    pub fn learn<'m>(mazes: impl IntoIterator<Item = &'m Maze>) -> Self {
        let mut counts = [[1_u32; 2]; 256];
        for maze in mazes {
            let batch = MazeBatch::repeat(maze.walls());
            for wall in maze.size().inner_walls() {
                if wall.cells().any(|cell| maze.goals().contains(cell)) {
                    continue;
                }
                let is_wall = maze.walls().has(wall.cell, wall.heading);
                for neighbours in mirrored(batch.neighbours(wall)[0].into()) {
                    counts[neighbours][usize::from(is_wall)] += 1;
                }
            }
        }
        let share = |[open, wall]: [u32; 2]| 256 * wall / (open + wall);
        Self { wall: counts.map(|counts| u8::try_from(share(counts).clamp(1, 255)).unwrap_or(1)) }
    }

    /// Returns the probability of a wall in units of 1/256 for each of the 256 combinations of
    /// neighbouring walls.
    pub const fn probabilities(&self) -> &[u8; 256] {
        &self.wall
    }

    pub(super) fn probability(&self, neighbours: u8) -> u8 {
        self.wall[usize::from(neighbours)]
    }
}

/// Returns the index `neighbours`, and the indices that result from mirroring the neighbouring
/// walls horizontally, vertically and both ways.
fn mirrored(neighbours: usize) -> [usize; 4] {
    let permuted =
        |from: [usize; 8]| (0..8).fold(0, |index, to| index | (neighbours >> from[to] & 1) << to);
    [
        neighbours,
        permuted([3, 4, 5, 0, 1, 2, 6, 7]),
        permuted([0, 2, 1, 3, 5, 4, 7, 6]),
        permuted([3, 5, 4, 0, 2, 1, 7, 6]),
    ]
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Wall, Walls};

    use super::*;

    #[test]
    fn a_prior_reflects_its_mazes() {
        let size = MazeSize::new(8, 8).unwrap();
        // Corridors from west to east.
        let mut walls = Walls::open(size);
        for cell in size.cells() {
            walls.set(cell, Heading::North, true);
        }
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        let prior = WallPrior::learn([&maze]);
        let batch = MazeBatch::repeat(maze.walls());
        let [north, east] = [Heading::North, Heading::East].map(|heading| {
            prior.probability(batch.neighbours(Wall::new(Cell::new(3, 1), heading))[0])
        });
        assert!(north > 240 && east < 16, "{north} {east}");
    }

    #[test]
    fn the_contest_prior_is_symmetric() {
        let probabilities = WallPrior::CONTEST.probabilities();
        for neighbours in 0..256 {
            for mirrored in mirrored(neighbours) {
                assert_eq!(probabilities[mirrored], probabilities[neighbours]);
            }
        }
    }
}
