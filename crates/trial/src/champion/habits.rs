//! What mazes are like: how likely a wall is, given those around it.

use mmsim_maze::{Cell, Heading, Maze, MazeSize, Walls};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// How likely there is a wall in a place, given the eight places around it: those that meet it at
/// its two posts, and the two beyond its cells.
///
/// ```text
///        o---8---o         1, 4  go on straight at a post
///        |       |         2, 3, 5, 6  stand across at a post
///        3       6         7, 8  on the far sides of the two cells
///        |       |
///    o-1-o---?---o-4-o
///        |       |
///        2       5
///        |       |
///        o---7---o
/// ```
///
/// Contest mazes have habits: no post without a wall, few crossings, corridors rather than halls.
/// Which of the eight are walls tells most of that. (In statistics: a Markov random field over
/// walls, fitted by pseudo-likelihood, after J. Besag, 1975.)
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Habits {
    /// Of 256, with place 1 of the drawing as bit 0 of the index and so on.
    wall: [u8; 256],
}

impl Habits {
    /// What contest mazes are like, learnt from 248 classic ones.
    pub const CONTEST: Self = Self { wall: super::contest::WALL };

    /// What these mazes are like. Goal rooms, which have a rule of their own, do not count.
    pub fn learn<'m>(mazes: impl IntoIterator<Item = &'m Maze>) -> Self {
        let mut counts = [[1_u32; 2]; 256];
        for maze in mazes {
            let layers = Layers::of(maze.walls());
            for place in Place::all(maze.size()) {
                let sides = [Some(place.cell()), place.cell().neighbour(place.heading())];
                if sides.into_iter().flatten().any(|cell| maze.goals().contains(cell)) {
                    continue;
                }
                let is_wall = maze.walls().has(place.cell(), place.heading());
                for alike in mirrored(layers.around(place)[0].into()) {
                    counts[alike][usize::from(is_wall)] += 1;
                }
            }
        }
        let share = |[open, wall]: [u32; 2]| 256 * wall / (open + wall);
        Self { wall: counts.map(|counts| u8::try_from(share(counts).clamp(1, 255)).unwrap_or(1)) }
    }

    /// The chance of a wall, of 256, for each of the 256 ways in which the places around can be.
    pub const fn chances(&self) -> &[u8; 256] {
        &self.wall
    }

    pub(super) fn wall(&self, around: u8) -> u8 {
        self.wall[usize::from(around)]
    }
}

/// The same places seen in both mirrors.
fn mirrored(around: usize) -> [usize; 4] {
    let moved =
        |from: [usize; 8]| (0..8).fold(0, |index, to| index | (around >> from[to] & 1) << to);
    [
        around,
        moved([3, 4, 5, 0, 1, 2, 6, 7]),
        moved([0, 2, 1, 3, 5, 4, 7, 6]),
        moved([3, 5, 4, 0, 2, 1, 7, 6]),
    ]
}

/// A place for an inner wall: to the north of a cell or to its east.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Place {
    pub(super) north: bool,
    pub(super) x: u8,
    pub(super) y: u8,
}

impl Place {
    /// All of a maze.
    pub(super) fn all(size: MazeSize) -> impl Iterator<Item = Self> {
        let at = |Cell { x, y }| [true, false].map(|north| Self { north, x, y });
        let is_inside = move |place: &Self| size.neighbour(place.cell(), place.heading()).is_some();
        size.cells().flat_map(at).filter(is_inside)
    }

    pub(super) const fn cell(self) -> Cell {
        Cell::new(self.x, self.y)
    }

    pub(super) const fn heading(self) -> Heading {
        if self.north { Heading::North } else { Heading::East }
    }

    fn index(self) -> usize {
        index(self.north, usize::from(self.x) + 1, usize::from(self.y) + 1)
    }
}

/// Rows of places, in turn to the north of cells and to their east, with a place more at each end.
const ROW: usize = SIDE + 2;

const fn index(north: bool, column: usize, row: usize) -> usize {
    (2 * row + !north as usize) * ROW + column
}

/// 64 mazes on top of one another: bit g of the word of a place tells whether there is a wall in
/// maze g. Of places outside, those on the lines of the outer walls have one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Layers {
    size: MazeSize,
    words: Vec<u64>,
}

impl Layers {
    pub(super) const NUMBER: usize = 64;

    /// All of them the same maze.
    pub(super) fn of(walls: &Walls) -> Self {
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
        let mut layers = Self { size, words };
        for place in Place::all(size) {
            layers.set(place, if walls.has(place.cell(), place.heading()) { u64::MAX } else { 0 });
        }
        layers
    }

    /// In which mazes there is a wall in that place.
    pub(super) fn at(&self, place: Place) -> u64 {
        self.words[place.index()]
    }

    pub(super) fn set(&mut self, place: Place, walls: u64) {
        self.words[place.index()] = walls;
    }

    /// One of the mazes.
    pub(super) fn walls(&self, layer: usize) -> Walls {
        let (width, height) = (usize::from(self.size.width()), usize::from(self.size.height()));
        let rows = |north: bool| {
            let mut rows = [0; SIDE];
            for (y, row) in rows[..height].iter_mut().enumerate() {
                let first = index(north, 1, y + 1);
                // A bit a column.
                #[allow(clippy::cast_possible_truncation)]
                for word in self.words[first..first + width].iter().rev() {
                    *row = *row << 1 | (word >> layer) as u32 & 1;
                }
            }
            rows
        };
        Walls::from_rows(self.size, rows(true), rows(false))
    }

    /// For each maze, which of the eight places around this one are walls, as an index into
    /// [`Habits`].
    pub(super) fn around(&self, place: Place) -> [u8; Self::NUMBER] {
        let here = place.index();
        let words: [u64; 8] = if place.north {
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
        let mut around = [0; Self::NUMBER];
        for (byte, eight) in around.chunks_exact_mut(8).enumerate() {
            let square = u64::from_le_bytes(words.map(|word| word.to_le_bytes()[byte]));
            eight.copy_from_slice(&transposed(square).to_le_bytes());
        }
        around
    }
}

/// Bit x of byte y becomes bit y of byte x.
const fn transposed(mut square: u64) -> u64 {
    // Swaps single bits, then squares of 2 by 2, then those of 4 by 4 (H. S. Warren, "Hacker's
    // Delight", 7-3).
    let swap = (square ^ square >> 7) & 0x00aa_00aa_00aa_00aa;
    square ^= swap ^ swap << 7;
    let swap = (square ^ square >> 14) & 0x0000_cccc_0000_cccc;
    square ^= swap ^ swap << 14;
    let swap = (square ^ square >> 28) & 0x0000_0000_f0f0_f0f0;
    square ^ swap ^ swap << 28
}

#[cfg(test)]
mod tests {
    use mmsim_maze::CellSet;
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

    /// The naive twin: asks the walls one by one. Of places outside of the maze, those on the
    /// lines of the outer walls are asked there and others do not stand.
    fn naive(walls: &Walls, Place { north, x, y }: Place) -> usize {
        let size = walls.size();
        let (x, y) = (i32::from(x), i32::from(y));
        let ask = |x: i32, y: i32, heading| {
            let inside = |x: i32, y: i32| {
                let cell = u8::try_from(x).ok().zip(u8::try_from(y).ok());
                cell.map(|(x, y)| Cell::new(x, y)).filter(|&cell| size.contains(cell))
            };
            let beyond =
                if heading == Heading::North { inside(x, y + 1) } else { inside(x + 1, y) };
            match (inside(x, y), beyond) {
                (None, None) => false,
                (Some(cell), _) => walls.has(cell, heading),
                (None, Some(_)) => true,
            }
        };
        let places = if north {
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
        places
            .iter()
            .rev()
            .fold(0, |index, &(x, y, heading)| index << 1 | usize::from(ask(x, y, heading)))
    }

    proptest! {
        #[test]
        fn the_places_around_equal_their_naive_twin(
            (width, height) in (1usize..=32, 1usize..=32),
            present in prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
            other in prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
            layer in 0..Layers::NUMBER,
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let walls = walls(size, &present);
            let others = self::walls(size, &other);
            let mut layers = Layers::of(&walls);
            for place in Place::all(size) {
                let is_other = others.has(place.cell(), place.heading());
                let word = layers.at(place) & !(1 << layer);
                layers.set(place, word | u64::from(is_other) << layer);
            }
            for (layer, walls) in [(layer, &others), ((layer + 1) % Layers::NUMBER, &walls)] {
                prop_assert_eq!(&layers.walls(layer), walls);
                for place in Place::all(size) {
                    prop_assert_eq!(usize::from(layers.around(place)[layer]), naive(walls, place));
                }
            }
        }
    }

    #[test]
    fn habits_are_those_of_the_mazes() {
        let size = MazeSize::new(8, 8).unwrap();
        // Corridors from west to east.
        let mut walls = Walls::open(size);
        for cell in size.cells() {
            walls.set(cell, Heading::North, true);
        }
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        let habits = Habits::learn([&maze]);
        let layers = Layers::of(maze.walls());
        let chance = |north| habits.wall(layers.around(Place { north, x: 3, y: 1 })[0]);
        assert!(chance(true) > 240 && chance(false) < 16, "{} {}", chance(true), chance(false));
        let chances = Habits::CONTEST.chances();
        for around in 0..256 {
            for alike in mirrored(around) {
                assert_eq!(chances[alike], chances[around]);
            }
        }
    }
}
