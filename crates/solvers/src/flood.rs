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
use bytes::Line;
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
    lines: [[Line; 8]; 2],
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
        let lines = [[[UNREACHABLE_BYTE; SMALL_SIDE]; 8]; 2];
        let steps = if is_small(size) {
            Steps::Small(SmallSteps { lines, all_reached: false })
        } else {
            Steps::Large([UNREACHABLE; MazeSize::MAX_AREA])
        };
        Self { size, steps }
    }

    /// Floods the maze from its targets outwards, a breadth-first search. Targets outside of the
    /// maze do not count.
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        let mut distances = Self::unreachable(walls.size());
        run(Flood { walls, targets, distances: &mut distances }, walls.size());
        distances
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
        let mut both = [Self::unreachable(map.size()), Self::unreachable(map.size())];
        for (distances, unknown) in both.iter_mut().zip([Unknown::Open, Unknown::Closed]) {
            distances.refill(map.walls(unknown), targets);
        }
        both
    }

    /// Floods anew, in the same place.
    pub(crate) fn refill(&mut self, walls: &Walls, targets: &CellSet) {
        if self.size != walls.size() {
            *self = Self::unreachable(walls.size());
        }
        run(Flood { walls, targets, distances: self }, walls.size());
    }

    /// Steps from `cell` to the nearest target, `None` where there is no way and outside of the
    /// maze.
    pub fn at(&self, cell: Cell) -> Option<u16> {
        Some(self.raw(cell)).filter(|&steps| steps != UNREACHABLE)
    }

    /// The same, but [`UNREACHABLE`] for `None`.
    pub(crate) fn raw(&self, cell: Cell) -> u16 {
        if !self.size.contains(cell) {
            return UNREACHABLE;
        }
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
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
        self.size.cells().filter(|&cell| self.at(cell).is_some()).count()
    }
}

impl SmallSteps {
    /// Of the cell at this place, counted row by row: steps, or [`UNREACHABLE`].
    fn raw(&self, place: usize) -> u16 {
        let steps = self.lines.as_flattened().as_flattened();
        let steps = steps[place % steps.len()];
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
    /// Of the same size.
    distances: &'a mut Distances,
}

impl Task for Flood<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) {
        let Self { walls, targets, distances } = self;
        let targets = Chequered::of(targets).inside(walls.size());
        distances.write(&waves::flood(&Board::<H>::of(walls), targets));
    }
}

impl Distances {
    /// Takes over what waves have left behind in a maze of this size.
    #[inline(always)]
    fn write<const N: usize, H: Half<N>>(&mut self, flooded: &Flooded<H>) {
        match &mut self.steps {
            Steps::Small(steps) => {
                bytes::write(flooded, 0, &mut steps.lines);
                steps.all_reached = flooded.is_full();
            }
            Steps::Large(steps) => {
                let mut low = [[[0; 16]; 8]; 8];
                let mut high = low;
                bytes::write(flooded, 0, &mut low);
                bytes::write(flooded, 8, &mut high);
                let low = low.as_flattened().as_flattened();
                let high = high.as_flattened().as_flattened();
                for (steps, (&low, &high)) in steps.iter_mut().zip(low.iter().zip(high)) {
                    *steps = u16::from_le_bytes([low, high]);
                }
            }
        }
    }
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
        insta::assert_snapshot!(maze.drawing().with_numbers(&numbers), @"
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
                let flood = || FloodAnew { walls: &walls, targets: &targets };
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
            Walls::of_rows(MazeSize::new(width, height).unwrap(), rows(north), rows(east))
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
                size.cells().map(|cell| distances.at(cell)).collect()
            };
            prop_assert_eq!(of(&Distances::flood(&walls, &targets)), expected.clone());
            let flood = || FloodAnew { walls: &walls, targets: &targets };
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
                map.note(pose, walls.around(pose)).unwrap();
            }
            let both = Distances::flood_both(&map, &targets);
            let alone = [Unknown::Open, Unknown::Closed]
                .map(|unknown| naive(map.walls(unknown), &targets));
            prop_assert_eq!([of(&both[0]), of(&both[1])], alone);
            let inside = targets.iter().filter(|&cell| size.contains(cell)).collect();
            prop_assert_eq!(Distances::flood(&walls, &targets), Distances::flood(&walls, &inside));
        }
    }

    /// A flood into distances of its own.
    struct FloodAnew<'a> {
        walls: &'a Walls,
        targets: &'a CellSet,
    }

    impl Task for FloodAnew<'_> {
        type Output = Distances;

        fn run<const N: usize, H: Half<N>>(self) -> Distances {
            let Self { walls, targets } = self;
            let mut distances = Distances::unreachable(walls.size());
            Flood { walls, targets, distances: &mut distances }.run::<N, H>();
            distances
        }
    }
}
