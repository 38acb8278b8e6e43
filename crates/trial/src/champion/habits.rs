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
            let (walls, rows) = (maze.walls(), Rows::of(maze.walls()));
            for cell in maze.size().cells() {
                for heading in [Heading::North, Heading::East] {
                    let Some(next) = maze.size().neighbour(cell, heading) else { continue };
                    if maze.goals().contains(cell) || maze.goals().contains(next) {
                        continue;
                    }
                    let place = Place { north: heading == Heading::North, x: cell.x, y: cell.y };
                    let around = rows.around(place);
                    for alike in mirrored(around) {
                        counts[alike][usize::from(walls.has(cell, heading))] += 1;
                    }
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

    pub(super) fn wall(&self, around: usize) -> u8 {
        self.wall[around]
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
    pub(super) const fn cell(self) -> Cell {
        Cell::new(self.x, self.y)
    }

    pub(super) const fn heading(self) -> Heading {
        if self.north { Heading::North } else { Heading::East }
    }
}

/// Walls with the outer ones, as bits: the one north of (x, y) is bit x + 1 of `north[y + 1]`, the
/// one to its east the same bit of `east[y + 1]`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Rows {
    size: MazeSize,
    north: [u64; SIDE + 2],
    east: [u64; SIDE + 2],
}

impl Rows {
    pub(super) fn of(walls: &Walls) -> Self {
        let size = walls.size();
        let (width, height) = (size.width(), usize::from(size.height()));
        let all = ((1 << width) - 1) << 1;
        let (mut north, mut east) = ([0; SIDE + 2], [0; SIDE + 2]);
        for y in 0..height {
            north[y + 1] = u64::from(walls.north_rows()[y]) << 1;
            east[y + 1] = u64::from(walls.east_rows()[y]) << 1 | 1 | 1 << width;
        }
        (north[0], north[height]) = (all, all);
        Self { size, north, east }
    }

    pub(super) fn walls(&self) -> Walls {
        let rows = |rows: &[u64; SIDE + 2]| {
            // Only the 32 columns are kept.
            #[allow(clippy::cast_possible_truncation)]
            std::array::from_fn(|y| (rows[y + 1] >> 1) as u32)
        };
        Walls::of_rows(self.size, rows(&self.north), rows(&self.east))
    }

    /// Which of the eight places around this one are walls, as an index into [`Habits`].
    pub(super) fn around(&self, Place { north, x, y }: Place) -> usize {
        let (x, y) = (usize::from(x), usize::from(y) + 1);
        let bits = if north {
            let [straight, below, above] =
                [self.north[y], self.east[y], self.east[y + 1]].map(|row| row >> x);
            let [near, far] = [self.north[y - 1], self.north[y + 1]].map(|row| row >> (x + 1) & 1);
            straight & 1
                | (below & 1) << 1
                | (above & 1) << 2
                | (straight >> 2 & 1) << 3
                | (below >> 1 & 1) << 4
                | (above >> 1 & 1) << 5
                | near << 6
                | far << 7
        } else {
            let [before, after] =
                [self.east[y - 1], self.east[y + 1]].map(|row| row >> (x + 1) & 1);
            let [south, north] = [self.north[y - 1], self.north[y]].map(|row| row >> (x + 1));
            let here = self.east[y] >> x;
            before
                | (south & 1) << 1
                | (south >> 1 & 1) << 2
                | after << 3
                | (north & 1) << 4
                | (north >> 1 & 1) << 5
                | (here & 1) << 6
                | (here >> 2 & 1) << 7
        };
        usize::from(bits.to_le_bytes()[0])
    }

    pub(super) fn set(&mut self, Place { north, x, y }: Place, wall: bool) {
        let rows = if north { &mut self.north } else { &mut self.east };
        let row = &mut rows[usize::from(y) + 1];
        *row = *row & !(1 << (x + 1)) | u64::from(wall) << (x + 1);
    }

    /// Takes over what is known: the walls that stand for certain, and those that may stand.
    pub(super) fn learn(&mut self, certain: &Walls, possible: &Walls) {
        let (certain, possible) = (Self::of(certain), Self::of(possible));
        let known = |rows: &mut [u64; SIDE + 2],
                     certain: &[u64; SIDE + 2],
                     possible: &[u64; SIDE + 2]| {
            for (row, (certain, possible)) in rows.iter_mut().zip(certain.iter().zip(possible)) {
                *row = *row & possible | certain;
            }
        };
        known(&mut self.north, &certain.north, &possible.north);
        known(&mut self.east, &certain.east, &possible.east);
    }
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
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let walls = walls(size, &present);
            let rows = Rows::of(&walls);
            prop_assert_eq!(&rows.walls(), &walls);
            for cell in size.cells() {
                for north in [false, true] {
                    let heading = if north { Heading::North } else { Heading::East };
                    let place = Place { north, x: cell.x, y: cell.y };
                    if size.neighbour(cell, heading).is_some() {
                        prop_assert_eq!(rows.around(place), naive(&walls, place));
                        let mut changed = rows.clone();
                        changed.set(place, !walls.has(cell, heading));
                        prop_assert_eq!(changed.walls().has(cell, heading), !walls.has(cell, heading));
                    }
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
        let rows = Rows::of(maze.walls());
        let chance = |north| habits.wall(rows.around(Place { north, x: 3, y: 1 }));
        assert!(chance(true) > 240 && chance(false) < 16, "{} {}", chance(true), chance(false));
        for around in 0..256 {
            for alike in mirrored(around) {
                assert_eq!(Habits::CONTEST.wall(alike), Habits::CONTEST.wall(around));
            }
        }
    }
}
