//! Batches of mazes, stored as one bit per maze and wall.

use mmsim_maze::{Heading, MazeSize, Wall, Walls};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The number of walls in a row, including an extra wall at each end. Even rows hold the walls
/// north of cells, and odd rows hold the walls east of cells.
const ROW: usize = SIDE + 2;

const fn index(is_north: bool, column: usize, row: usize) -> usize {
    (2 * row + !is_north as usize) * ROW + column
}

fn index_of(Wall { cell, heading, .. }: Wall) -> usize {
    index(heading == Heading::North, usize::from(cell.x) + 1, usize::from(cell.y) + 1)
}

/// A bit-sliced batch of 64 mazes: bit i of a wall's word is set if maze i has that wall.
/// All mazes have outer walls, and no walls beyond them.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct MazeBatch {
    size: MazeSize,
    words: Vec<u64>,
}

impl MazeBatch {
    pub(super) const LEN: usize = 64;

    /// Creates a batch of 64 copies of a maze.
    pub(super) fn repeat(walls: &Walls) -> Self {
        let size = walls.size();
        let mut words = vec![0; index(true, 0, SIDE + 2)];
        let (width, height) = (usize::from(size.width()), usize::from(size.height()));
        for column in 1..=width {
            words[index(true, column, 0)] = u64::MAX;
            words[index(true, column, height)] = u64::MAX;
        }
        for row in 1..=height {
            words[index(false, 0, row)] = u64::MAX;
            words[index(false, width, row)] = u64::MAX;
        }
        let mut batch = Self { size, words };
        for wall in size.inner_walls() {
            batch.set(wall, if walls.has(wall.cell, wall.heading) { u64::MAX } else { 0 });
        }
        batch
    }

    /// Returns a word in which bit i is set if maze i has the wall.
    pub(super) fn at(&self, wall: Wall) -> u64 {
        self.words[index_of(wall)]
    }

    pub(super) fn set(&mut self, wall: Wall, present: u64) {
        self.words[index_of(wall)] = present;
    }

    /// Returns the walls of the maze with this index.
    pub(super) fn walls(&self, maze: usize) -> Walls {
        let (width, height) = (usize::from(self.size.width()), usize::from(self.size.height()));
        let rows = |is_north: bool| {
            let mut rows = [0; SIDE];
            for (y, row) in rows[..height].iter_mut().enumerate() {
                let first = index(is_north, 1, y + 1);
                // One bit per column.
                #[allow(clippy::cast_possible_truncation)]
                for word in self.words[first..first + width].iter().rev() {
                    *row = *row << 1 | (word >> maze) as u32 & 1;
                }
            }
            rows
        };
        Walls::from_rows(self.size, rows(true), rows(false))
    }

    /// Returns the walls around `wall` as one byte per maze. Each bit of the byte stands for one of
    /// the eight neighbouring walls and is set if that wall is present. The byte is an index into
    /// the table of [`WallPrior`](super::wall_prior::WallPrior).
    pub(super) fn neighbours(&self, wall: Wall) -> [u8; Self::LEN] {
        let here = index_of(wall);
        let words: [u64; 8] = if wall.heading == Heading::North {
            let (south_east, north_east) = (here + ROW, here + 3 * ROW);
            [
                here - 1,
                south_east - 1,
                north_east - 1,
                here + 1,
                south_east,
                north_east,
                here - 2 * ROW,
                here + 2 * ROW,
            ]
        } else {
            let (south, north) = (here - 3 * ROW, here - ROW);
            [here - 2 * ROW, south, south + 1, here + 2 * ROW, north, north + 1, here - 1, here + 1]
        }
        .map(|index| self.words[index]);
        let mut neighbours = [0; Self::LEN];
        for (byte, eight) in neighbours.chunks_exact_mut(8).enumerate() {
            let square = u64::from_le_bytes(words.map(|word| word.to_le_bytes()[byte]));
            eight.copy_from_slice(&transposed(square).to_le_bytes());
        }
        neighbours
    }
}

/// Transposes a square of 8×8 bits: bit x of byte y becomes bit y of byte x.
const fn transposed(mut square: u64) -> u64 {
    // Swap single bits, then squares of 2×2 and of 4×4 bits (H. S. Warren, "Hacker's Delight",
    // 7-3).
    let swap = (square ^ square >> 7) & 0x00aa_00aa_00aa_00aa;
    square ^= swap ^ swap << 7;
    let swap = (square ^ square >> 14) & 0x0000_cccc_0000_cccc;
    square ^= swap ^ swap << 14;
    let swap = (square ^ square >> 28) & 0x0000_0000_f0f0_f0f0;
    square ^ swap ^ swap << 28
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Cell;
    use proptest::prelude::*;

    use super::*;

    fn walls(size: MazeSize, present: &[bool]) -> Walls {
        let mut walls = Walls::open(size);
        for (wall, &present) in size.walls().zip(present) {
            walls.set(wall.cell, wall.heading, present);
        }
        walls
    }

    /// The reference implementation looks up the neighbouring walls one by one.
    fn reference(walls: &Walls, wall: Wall) -> usize {
        let (x, y) = (i32::from(wall.cell.x), i32::from(wall.cell.y));
        let has_wall = |x: i32, y: i32, heading| {
            let inside = |x: i32, y: i32| {
                let cell = u8::try_from(x).ok().zip(u8::try_from(y).ok());
                cell.map(|(x, y)| Cell::new(x, y)).filter(|&cell| walls.size().contains(cell))
            };
            let beyond =
                if heading == Heading::North { inside(x, y + 1) } else { inside(x + 1, y) };
            match (inside(x, y), beyond) {
                (None, None) => false,
                (Some(cell), _) => walls.has(cell, heading),
                (None, Some(_)) => true,
            }
        };
        let sites = if wall.heading == Heading::North {
            let (n, e) = (Heading::North, Heading::East);
            [
                (x - 1, y, n),
                (x - 1, y, e),
                (x - 1, y + 1, e),
                (x + 1, y, n),
                (x, y, e),
                (x, y + 1, e),
                (x, y - 1, n),
                (x, y + 1, n),
            ]
        } else {
            let (n, e) = (Heading::North, Heading::East);
            [
                (x, y - 1, e),
                (x, y - 1, n),
                (x + 1, y - 1, n),
                (x, y + 1, e),
                (x, y, n),
                (x + 1, y, n),
                (x - 1, y, e),
                (x + 1, y, e),
            ]
        };
        sites
            .iter()
            .rev()
            .fold(0, |index, &(x, y, heading)| index << 1 | usize::from(has_wall(x, y, heading)))
    }

    proptest! {
        #[test]
        fn neighbours_equal_the_reference(
            (width, height) in (1usize..=32, 1usize..=32),
            present in prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
            other in prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
            maze in 0..MazeBatch::LEN,
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let walls = walls(size, &present);
            let others = self::walls(size, &other);
            let mut batch = MazeBatch::repeat(&walls);
            for wall in size.inner_walls() {
                let is_other = others.has(wall.cell, wall.heading);
                let word = batch.at(wall) & !(1 << maze);
                batch.set(wall, word | u64::from(is_other) << maze);
            }
            for (maze, walls) in [(maze, &others), ((maze + 1) % MazeBatch::LEN, &walls)] {
                prop_assert_eq!(&batch.walls(maze), walls);
                for wall in size.inner_walls() {
                    prop_assert_eq!(usize::from(batch.neighbours(wall)[maze]), reference(walls, wall));
                }
            }
        }
    }
}
