//! Batches of mazes, stored as one bit per maze and wall.

use mmsim_maze::{Cell, Heading, MazeSize, Walls};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The site of a possible inner wall, north or east of a cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct WallSite {
    pub(super) cell: Cell,
    pub(super) heading: Heading,
}

impl WallSite {
    /// Returns all wall sites of a maze of this size.
    pub(super) fn all(size: MazeSize) -> impl Iterator<Item = Self> {
        let at = |cell| [Heading::North, Heading::East].map(|heading| Self { cell, heading });
        let is_inside = move |site: &Self| size.neighbour(site.cell, site.heading).is_some();
        size.cells().flat_map(at).filter(is_inside)
    }

    /// Returns the two cells that the wall site separates.
    pub(super) fn cells(self) -> impl Iterator<Item = Cell> {
        [Some(self.cell), self.cell.neighbour(self.heading)].into_iter().flatten()
    }

    fn is_north(self) -> bool {
        self.heading == Heading::North
    }

    fn index(self) -> usize {
        let Cell { x, y } = self.cell;
        index(self.is_north(), usize::from(x) + 1, usize::from(y) + 1)
    }
}

/// The number of sites in a row, including an extra site at each end. Even rows hold the sites
/// north of cells, and odd rows hold the sites east of cells.
const ROW: usize = SIDE + 2;

const fn index(is_north: bool, column: usize, row: usize) -> usize {
    (2 * row + !is_north as usize) * ROW + column
}

/// A bit-sliced batch of 64 mazes: bit i of a site's word is set if maze i has a wall at that site.
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
        for site in WallSite::all(size) {
            batch.set(site, if walls.has(site.cell, site.heading) { u64::MAX } else { 0 });
        }
        batch
    }

    /// Returns a word in which bit i is set if maze i has a wall at the site.
    pub(super) fn at(&self, site: WallSite) -> u64 {
        self.words[site.index()]
    }

    pub(super) fn set(&mut self, site: WallSite, walls: u64) {
        self.words[site.index()] = walls;
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

    /// Returns the walls around `site` as one byte per maze. Each bit of the byte stands for one of
    /// the eight neighbouring sites and is set if that site has a wall. The byte is an index into
    /// the table of [`WallPrior`](super::wall_prior::WallPrior).
    pub(super) fn neighbours(&self, site: WallSite) -> [u8; Self::LEN] {
        let here = site.index();
        let words: [u64; 8] = if site.is_north() {
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
    use proptest::prelude::*;

    use super::*;

    fn walls(size: MazeSize, present: &[bool]) -> Walls {
        let mut walls = Walls::open(size);
        for (cell, present) in size.cells().zip(present.chunks(2)) {
            walls.set(cell, Heading::North, present[0]);
            walls.set(cell, Heading::East, present[1]);
        }
        walls
    }

    /// The reference implementation looks up the neighbouring walls one by one.
    fn reference(walls: &Walls, site: WallSite) -> usize {
        let (x, y) = (i32::from(site.cell.x), i32::from(site.cell.y));
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
        let sites = if site.is_north() {
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
            for site in WallSite::all(size) {
                let is_other = others.has(site.cell, site.heading);
                let word = batch.at(site) & !(1 << maze);
                batch.set(site, word | u64::from(is_other) << maze);
            }
            for (maze, walls) in [(maze, &others), ((maze + 1) % MazeBatch::LEN, &walls)] {
                prop_assert_eq!(&batch.walls(maze), walls);
                for site in WallSite::all(size) {
                    prop_assert_eq!(usize::from(batch.neighbours(site)[maze]), reference(walls, site));
                }
            }
        }
    }
}
