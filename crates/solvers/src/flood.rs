//! Flood: the distance of every cell to the nearest target.

// What a wave does is compiled anew for each kind of processor, and for that into its loop.
#![allow(clippy::inline_always)]

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Unknown, Walls};

mod between;
mod board;
mod bytes;
mod downhill;
mod half;
mod processor;
mod to_see;
mod update;
mod waves;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86;

pub use between::steps_between;
use board::{Board, Chequered};
pub use downhill::Downhill;
use half::Half;
pub use processor::Instructions;
use processor::{Task, run};
pub(crate) use to_see::{ToSee, cell_to_see};
use waves::Flooded;

/// Distances in steps from each cell to the nearest of some target cells, along ways without a
/// wall.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::Distances;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let distances = Distances::flood(&walls, &MazeSize::CLASSIC.central_cells());
/// assert_eq!(distances.at(Cell::new(0, 0)), Some(14));
/// assert_eq!(distances.at(Cell::new(8, 7)), Some(0));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Distances {
    size: MazeSize,
    steps: Steps,
}

// Both in place, since there may be no allocator.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, PartialEq, Eq, Debug)]
enum Steps {
    /// Of a maze of up to 16×16 cells: row by row from the south, 16 to a row.
    Small(SmallSteps),
    /// Of a larger one, 32 to a row.
    Large([u16; MazeSize::MAX_AREA]),
}

#[derive(Clone, PartialEq, Eq, Debug)]
struct SmallSteps {
    bytes: [u8; SMALL_SIDE * SMALL_SIDE],
    /// Whether `UNREACHABLE_BYTE` is a distance: where one is so long, the way passes through all
    /// cells.
    all_reached: bool,
}

const SMALL_SIDE: usize = 16;
const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The distance of a cell from which no target can be reached.
pub(crate) const UNREACHABLE: u16 = u16::MAX;
const UNREACHABLE_BYTE: u8 = u8::MAX;

impl Distances {
    /// Distances nowhere known: no target can be reached from any cell.
    pub const fn unreachable(size: MazeSize) -> Self {
        let steps = if is_small(size) {
            let bytes = [UNREACHABLE_BYTE; SMALL_SIDE * SMALL_SIDE];
            Steps::Small(SmallSteps { bytes, all_reached: false })
        } else {
            Steps::Large([UNREACHABLE; MazeSize::MAX_AREA])
        };
        Self { size, steps }
    }

    /// Floods the maze from its targets outwards, a breadth-first search. Targets outside of the
    /// maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        run(Flood { walls, targets }, walls.size())
    }

    /// Floods what a mouse knows from some targets outwards, with unknown walls taken as open and as
    /// closed, in this order. These are two floods one after the other: the closed one soon ends, so
    /// that a wave of both together would only cost more.
    ///
    /// ```
    /// use mmsim_maze::{Cell, KnownMaze, MazeSize};
    /// use mmsim_solvers::Distances;
    /// let (start, goals) = (Cell::new(0, 0), MazeSize::CLASSIC.central_cells());
    /// let map = KnownMaze::new(MazeSize::CLASSIC, start, goals);
    /// let [open, closed] = Distances::flood_both(&map, map.goals());
    /// assert_eq!((open.at(start), closed.at(start)), (Some(14), None));
    /// ```
    pub fn flood_both(map: &KnownMaze, targets: &CellSet) -> [Self; 2] {
        [Unknown::Open, Unknown::Closed].map(|unknown| Self::flood(map.walls(unknown), targets))
    }

    /// Floods anew, in the same place: an assignment would copy 2 KiB.
    pub(crate) fn refill(&mut self, walls: &Walls, targets: &CellSet) {
        if self.size == walls.size() {
            run(Refill { flood: Flood { walls, targets }, steps: &mut self.steps }, self.size);
        } else {
            *self = Self::flood(walls, targets);
        }
    }

    /// Steps from `cell` to the nearest target, `None` where there is no way and outside of the
    /// maze. To read all cells, [`rows`](Self::rows) is faster.
    #[inline]
    pub fn at(&self, cell: Cell) -> Option<u16> {
        Some(self.raw(cell)).filter(|&steps| steps != UNREACHABLE)
    }

    /// Returns the distances of all cells: rows from the south, the cells of each row from the west.
    ///
    /// ```
    /// use mmsim_maze::{MazeSize, Walls};
    /// use mmsim_solvers::Distances;
    /// let walls = Walls::open(MazeSize::CLASSIC);
    /// let distances = Distances::flood(&walls, &MazeSize::CLASSIC.central_cells());
    /// let mut farthest = None;
    /// for row in distances.rows() {
    ///     for steps in row {
    ///         farthest = farthest.max(steps);
    ///     }
    /// }
    /// assert_eq!(farthest, Some(14));
    /// ```
    #[inline]
    pub fn rows(
        &self,
    ) -> impl DoubleEndedIterator<Item = impl DoubleEndedIterator<Item = Option<u16>>> {
        // An index in place of a slice of either kind: the compiler moves the question which kind it
        // is out of a loop over the row.
        let steps = move |y, x| Some(self.raw_inside(x, y)).filter(|&steps| steps != UNREACHABLE);
        (0..self.size.height())
            .map(move |y| (0..self.size.width()).map(move |x| steps(y.into(), x.into())))
    }

    /// The same as [`at`](Self::at), but [`UNREACHABLE`] for `None`.
    #[inline]
    pub(crate) fn raw(&self, cell: Cell) -> u16 {
        if self.size.contains(cell) {
            self.raw_inside(cell.x.into(), cell.y.into())
        } else {
            UNREACHABLE
        }
    }

    /// The same for a cell inside the maze.
    #[inline]
    fn raw_inside(&self, x: usize, y: usize) -> u16 {
        match &self.steps {
            Steps::Small(steps) => steps.raw(y * SMALL_SIDE + x),
            Steps::Large(steps) => steps[(y * SIDE + x) % steps.len()],
        }
    }

    /// The same of a cell's neighbours, in the order of [`Heading::ALL`](mmsim_maze::Heading::ALL).
    /// Beyond the edge of the maze, where nobody can go, it may be anything.
    // Without asking for each whether it is there.
    pub(crate) fn raw_around(&self, cell: Cell) -> [u16; 4] {
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
        match &self.steps {
            Steps::Small(steps) => {
                around(y * SMALL_SIDE + x, SMALL_SIDE).map(|place| steps.raw(place))
            }
            Steps::Large(steps) => {
                around(y * SIDE + x, SIDE).map(|place| steps[place % steps.len()])
            }
        }
    }

    /// How many cells have a way to a target.
    pub fn reachable_cells(&self) -> usize {
        self.rows().map(|row| row.flatten().count()).sum()
    }
}

impl SmallSteps {
    #[inline(always)]
    fn of<const N: usize, H: Half<N>>(flooded: &Flooded<H>) -> Self {
        let mut bytes = [0; SMALL_SIDE * SMALL_SIDE];
        bytes::write(flooded, 0, &mut bytes);
        Self { bytes, all_reached: flooded.is_full() }
    }

    /// Of the cell at this place, counted row by row: steps, or [`UNREACHABLE`].
    #[inline]
    fn raw(&self, place: usize) -> u16 {
        let steps = self.bytes[place % self.bytes.len()];
        let is_reached = steps != UNREACHABLE_BYTE || self.all_reached;
        if is_reached { steps.into() } else { UNREACHABLE }
    }
}

/// The places of a cell's neighbours where a row takes so many.
fn around(place: usize, row: usize) -> [usize; 4] {
    [place + row, place + 1, place.wrapping_sub(row), place.wrapping_sub(1)]
}

const fn is_small(size: MazeSize) -> bool {
    size.width() as usize <= SMALL_SIDE && size.height() as usize <= SMALL_SIDE
}

struct Flood<'a> {
    walls: &'a Walls,
    targets: &'a CellSet,
}

impl Flood<'_> {
    #[inline(always)]
    fn waves<const N: usize, H: Half<N>>(&self) -> Flooded<H> {
        let targets = Chequered::of(self.targets).inside(self.walls.size());
        waves::flood(&Board::of(self.walls), targets)
    }
}

impl Task for Flood<'_> {
    type Output = Distances;

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) -> Distances {
        let flooded = self.waves::<N, H>();
        let steps = if N == 2 {
            Steps::Small(SmallSteps::of(&flooded))
        } else {
            Steps::Large(large_steps(&flooded))
        };
        Distances { size: self.walls.size(), steps }
    }
}

struct Refill<'a> {
    flood: Flood<'a>,
    /// Those of a maze of the same size.
    steps: &'a mut Steps,
}

impl Task for Refill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) {
        let flooded = self.flood.waves::<N, H>();
        match self.steps {
            Steps::Small(steps) => *steps = SmallSteps::of(&flooded),
            Steps::Large(steps) => *steps = large_steps(&flooded),
        }
    }
}

#[inline(always)]
fn large_steps<const N: usize, H: Half<N>>(flooded: &Flooded<H>) -> [u16; MazeSize::MAX_AREA] {
    let (mut low, mut high) = ([0; MazeSize::MAX_AREA], [0; MazeSize::MAX_AREA]);
    bytes::write(flooded, 0, &mut low);
    bytes::write(flooded, 8, &mut high);
    let mut steps = [0; MazeSize::MAX_AREA];
    for (steps, (&low, &high)) in steps.iter_mut().zip(low.iter().zip(&high)) {
        *steps = u16::from_le_bytes([low, high]);
    }
    steps
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, Maze, Pose};
    use proptest::prelude::*;

    use super::processor::with_each;
    use super::*;

    #[test]
    fn distances_go_round_walls() {
        let maze: Maze = "\
o---o---o---o
|     G |   |
o   o---o---o
| S |       |
o---o---o---o
"
        .parse()
        .unwrap();
        let distances = Distances::flood(maze.walls(), maze.goals());
        let numbers = |cell| distances.at(cell);
        insta::assert_snapshot!(maze.picture().with_numbers(&numbers), @"
        o---o---o---o
        | 1   0 |   |
        o   o---o---o
        | 2 |       |
        o---o---o---o
        ");
        assert_eq!(distances.reachable_cells(), 3);
        assert_eq!(distances.at(Cell::new(3, 0)), None);
    }

    #[test]
    fn the_longest_ways_are_counted() {
        for side in [15, 16, 31, 32] {
            let size = MazeSize::new(side.into(), side.into()).unwrap();
            let mut walls = Walls::open(size);
            for y in 0..side - 1 {
                let gap = if y % 2 == 0 { side - 1 } else { 0 };
                for x in (0..side).filter(|&x| x != gap) {
                    walls.set(Cell::new(x, y), Heading::North, true);
                }
            }
            let begin = Cell::new(0, 0);
            let end = Cell::new(if side % 2 == 0 { 0 } else { side - 1 }, side - 1);
            let before_end =
                end.neighbour(if side % 2 == 0 { Heading::East } else { Heading::West });
            let longest = u16::from(side) * u16::from(side) - 1;
            for (targets, from, expected) in [
                (vec![end], begin, longest),
                (vec![begin], end, longest),
                (vec![end, before_end.unwrap()], begin, longest - 1),
            ] {
                let targets = targets.into_iter().collect();
                let flood = || Flood { walls: &walls, targets: &targets };
                with_each(flood, size, |distances| {
                    assert_eq!(distances.at(from), Some(expected));
                    assert_eq!(distances.reachable_cells(), size.area());
                });
            }
        }
    }

    #[test]
    fn targets_outside_do_not_count() {
        let walls = Walls::open(MazeSize::new(2, 2).unwrap());
        let targets = [Cell::new(2, 0)].into_iter().collect();
        assert_eq!(Distances::flood(&walls, &targets).reachable_cells(), 0);
    }

    /// The naive twin: relax every way until nothing changes.
    fn naive(walls: &Walls, targets: &CellSet) -> Vec<Option<u16>> {
        let size = walls.size();
        let mut steps: Vec<Option<u16>> =
            size.cells().map(|cell| targets.contains(cell).then_some(0)).collect();
        let index =
            |cell: Cell| usize::from(cell.y) * usize::from(size.width()) + usize::from(cell.x);
        loop {
            let before = steps.clone();
            for cell in size.cells() {
                for heading in Heading::ALL.into_iter().filter(|&heading| !walls.has(cell, heading))
                {
                    let next = cell.neighbour(heading).and_then(|next| steps[index(next)]);
                    let through = next.map(|steps| steps + 1);
                    let here = &mut steps[index(cell)];
                    *here = [*here, through].into_iter().flatten().min();
                }
            }
            if steps == before {
                return steps;
            }
        }
    }

    /// Walls of a maze of any size; how probable they are differs from maze to maze.
    pub(super) fn any_walls() -> impl Strategy<Value = Walls> {
        let bits = || prop::collection::vec(any::<[u32; 3]>(), 32);
        let size = prop_oneof![(1usize..=16, 1usize..=16), (1usize..=32, 1usize..=32)];
        (size, bits(), bits(), 0..3).prop_map(|((width, height), north, east, density)| {
            let rows = |rows: Vec<[u32; 3]>| {
                let row = |[a, b, c]: &[u32; 3]| match density {
                    0 => a & b & c,
                    1 => a & b,
                    _ => a & (b | c),
                };
                std::array::from_fn(|y| row(&rows[y]))
            };
            Walls::from_rows(MazeSize::new(width, height).unwrap(), rows(north), rows(east))
        })
    }

    /// A few targets, some of them next to each other, some outside.
    pub(super) fn any_targets() -> impl Strategy<Value = CellSet> {
        let block = (0u8..32, 0u8..32, 0u8..3, 0u8..3);
        prop::collection::vec(block, 0..4).prop_map(|blocks| {
            let cells = blocks.into_iter().flat_map(|(x, y, width, height)| {
                let row = move |y| (x..=x + width).map(move |x| Cell::new(x, y));
                (y..=y + height).flat_map(row)
            });
            cells.collect()
        })
    }

    proptest! {
        #[test]
        fn a_flood_equals_its_naive_twin(
            walls in any_walls(),
            targets in any_targets(),
            seen in prop::collection::vec((0u8..32, 0u8..32), 0..60),
        ) {
            let (size, expected) = (walls.size(), naive(&walls, &targets));
            let of = |distances: &Distances| -> Vec<_> {
                let cells: Vec<_> = size.cells().map(|cell| distances.at(cell)).collect();
                let width = usize::from(size.width());
                assert!(distances.rows().map(Vec::from_iter).eq(cells.chunks(width)));
                let backwards = distances.rows().rev().flat_map(Iterator::rev);
                assert!(backwards.eq(cells.iter().rev().copied()));
                assert_eq!(distances.reachable_cells(), cells.iter().flatten().count());
                cells
            };
            prop_assert_eq!(of(&Distances::flood(&walls, &targets)), expected.clone());
            let flood = || Flood { walls: &walls, targets: &targets };
            with_each(flood, size, |distances| assert_eq!(of(&distances), expected));
            let distances = Distances::flood(&walls, &targets);
            for cell in size.cells() {
                for (heading, steps) in Heading::ALL.into_iter().zip(distances.raw_around(cell)) {
                    let next = size.neighbour(cell, heading);
                    prop_assert!(next.is_none_or(|next| distances.raw(next) == steps));
                }
            }
            let mut map = KnownMaze::new(size, Cell::new(0, 0), targets);
            for (x, y) in seen {
                let cell = Cell::new(x % size.width(), y % size.height());
                let pose = Pose::new(cell, Heading::North);
                map.observe(pose, walls.around(pose)).unwrap();
            }
            let both = Distances::flood_both(&map, &targets);
            let alone = [Unknown::Open, Unknown::Closed]
                .map(|unknown| naive(map.walls(unknown), &targets));
            prop_assert_eq!([of(&both[0]), of(&both[1])], alone);
            let inside = targets.iter().filter(|&cell| size.contains(cell)).collect();
            prop_assert_eq!(Distances::flood(&walls, &targets), Distances::flood(&walls, &inside));
        }
    }
}
