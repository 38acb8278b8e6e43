//! A flood computes the distance from each cell to the nearest target.
//!
//! The code in `wide` stores one bit per cell and runs on processors with 64-bit registers, with the
//! vector instructions that the processor has. The code in `bytes` stores one byte per cell and runs
//! on microcontrollers. `dispatch.rs` chooses between them.

// The operations of a wave must be inlined into the loop that is compiled for each instruction set.
#![allow(clippy::inline_always)]

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Unknown, Walls};

mod bytes;
mod dispatch;
mod downhill;
mod exploration;
mod steps;
mod steps_between;
mod update;
mod wide;

pub(crate) use bytes::FloodMemory;
use bytes::waves::{self as byte_waves, OpenSides};
pub use dispatch::Instructions;
use dispatch::{Task, run, run_with};
pub use downhill::Downhill;
pub(crate) use exploration::{KEEPS_DISTANCES, exploration_target};
pub(crate) use steps::UNREACHABLE;
use steps::{LARGE_AREA, SmallSteps, Steps, is_small};
pub use steps_between::steps_between;
pub(crate) use steps_between::steps_between_in;
use wide::bitboard::{Bitboard, CellPlanes};
use wide::plane::ParityPlane;
use wide::waves::{self, Flooded};

/// The distances in steps from each cell of a maze to the nearest target cell.
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

/// Returns the set that contains only `cell`.
pub(crate) fn only(cell: Cell) -> CellSet {
    [cell].into_iter().collect()
}

impl Distances {
    /// Creates the distances of a maze in which no cell can reach a target.
    #[must_use]
    pub const fn unreachable(size: MazeSize) -> Self {
        Self { size, steps: Steps::unreachable(size) }
    }

    /// Computes the distances by a breadth-first search from the targets. Targets outside the maze
    /// are ignored.
    #[must_use]
    pub fn flood(walls: &Walls, targets: &CellSet) -> Self {
        run(FloodTask { walls, targets }, walls.size())
    }

    /// Returns the optimistic distances, which treat unknown walls as open, and the pessimistic
    /// distances, which treat them as closed.
    ///
    /// ```
    /// use mmsim_maze::{Cell, KnownMaze, MazeSize};
    /// use mmsim_solvers::Distances;
    /// let (start, goals) = (Cell::new(0, 0), MazeSize::CLASSIC.central_cells());
    /// let map = KnownMaze::new(MazeSize::CLASSIC, start, goals);
    /// let [optimistic, pessimistic] = Distances::flood_both(&map, map.goals());
    /// assert_eq!((optimistic.at(start), pessimistic.at(start)), (Some(14), None));
    /// ```
    #[must_use]
    pub fn flood_both(map: &KnownMaze, targets: &CellSet) -> [Self; 2] {
        // Two separate floods are fast, because the pessimistic flood ends early.
        [Unknown::Open, Unknown::Closed].map(|unknown| Self::flood(map.walls(unknown), targets))
    }

    /// Does the same as [`flood`](Self::flood), but uses the given instruction set. Falls back to a
    /// slower instruction set if the given one is not available.
    #[must_use]
    pub fn flood_with(instructions: Instructions, walls: &Walls, targets: &CellSet) -> Self {
        run_with(instructions, FloodTask { walls, targets }, walls.size())
    }

    /// Replaces the distances by those of a new flood, in the same memory. This method is faster than
    /// assigning new `Distances`, which may copy 2 KiB, and needs less of the stack.
    ///
    /// ```
    /// use mmsim_maze::{Cell, MazeSize, Walls};
    /// use mmsim_solvers::Distances;
    /// let walls = Walls::open(MazeSize::CLASSIC);
    /// let mut distances = Distances::unreachable(MazeSize::CLASSIC);
    /// distances.reflood(&walls, &MazeSize::CLASSIC.central_cells());
    /// assert_eq!(distances.at(Cell::new(0, 0)), Some(14));
    /// ```
    pub fn reflood(&mut self, walls: &Walls, targets: &CellSet) {
        self.reflood_in(None, walls, targets);
    }

    /// Does the same as [`reflood`](Self::reflood), but may use the given memory instead of the
    /// stack.
    pub(crate) fn reflood_in(
        &mut self,
        sides: Option<&mut OpenSides>,
        walls: &Walls,
        targets: &CellSet,
    ) {
        let size = walls.size();
        if self.size == size || is_small(self.size) && is_small(size) {
            self.size = size;
            run(
                RefloodTask { flood: FloodTask { walls, targets }, steps: &mut self.steps, sides },
                self.size,
            );
        } else {
            *self = Self::flood(walls, targets);
        }
    }

    /// Returns the number of steps from `cell` to the nearest target, or `None` if no target is
    /// reachable or the cell is outside the maze. To read all cells, use [`rows`](Self::rows),
    /// which is faster.
    #[inline]
    pub fn at(&self, cell: Cell) -> Option<u16> {
        Some(self.raw(cell)).filter(|&steps| steps != UNREACHABLE)
    }

    /// Returns the distances of all cells. The rows are ordered from south to north, and the cells
    /// of each row from west to east.
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
        // With an index instead of a slice, the compiler moves the check of the variant out of a
        // loop over the row.
        let steps = move |y, x| Some(self.steps.at(x, y)).filter(|&steps| steps != UNREACHABLE);
        (0..self.size.height())
            .map(move |y| (0..self.size.width()).map(move |x| steps(y.into(), x.into())))
    }

    /// Does the same as [`at`](Self::at), but returns [`UNREACHABLE`] instead of `None`.
    #[inline]
    pub(crate) fn raw(&self, cell: Cell) -> u16 {
        if self.size.contains(cell) {
            self.steps.at(cell.x.into(), cell.y.into())
        } else {
            UNREACHABLE
        }
    }

    /// Returns the distances of a cell's neighbours, in the order of
    /// [`Heading::ALL`](mmsim_maze::Heading::ALL). This method does not check bounds: the values
    /// for neighbours outside the maze are arbitrary.
    pub(crate) fn raw_around(&self, cell: Cell) -> [u16; 4] {
        self.steps.around(cell)
    }

    /// Returns the number of cells that can reach a target, including the targets.
    pub fn reachable_cells(&self) -> usize {
        self.rows().map(|row| row.flatten().count()).sum()
    }
}

struct FloodTask<'a> {
    walls: &'a Walls,
    targets: &'a CellSet,
}

impl FloodTask<'_> {
    #[inline(always)]
    fn waves<H: ParityPlane>(&self) -> Flooded<H> {
        let targets = CellPlanes::from_cells_inside(self.targets, self.walls.size());
        waves::flood(&Bitboard::from_walls(self.walls), targets)
    }
}

impl Task for FloodTask<'_> {
    type Output = Distances;

    #[inline(always)]
    fn run<H: ParityPlane>(self) -> Distances {
        let flooded = self.waves::<H>();
        let steps = if H::IS_SMALL {
            Steps::Small(small_steps(&flooded))
        } else {
            Steps::Large(large_steps(&flooded))
        };
        Distances { size: self.walls.size(), steps }
    }

    #[inline(always)]
    fn run_on_bytes(self) -> Distances {
        let mut distances = Distances::unreachable(self.walls.size());
        RefloodTask { flood: self, steps: &mut distances.steps, sides: None }.run_on_bytes();
        distances
    }
}

struct RefloodTask<'a> {
    flood: FloodTask<'a>,
    /// The distances to overwrite: `Small` if the maze is small, `Large` otherwise.
    steps: &'a mut Steps,
    /// Memory for [`run_on_bytes`](Task::run_on_bytes) instead of the stack.
    sides: Option<&'a mut OpenSides>,
}

impl Task for RefloodTask<'_> {
    type Output = ();

    #[inline(always)]
    fn run<H: ParityPlane>(self) {
        let flooded = self.flood.waves::<H>();
        match self.steps {
            Steps::Small(steps) => *steps = small_steps(&flooded),
            Steps::Large(steps) => *steps = large_steps(&flooded),
        }
    }

    #[inline(always)]
    fn run_on_bytes(self) {
        let FloodTask { walls, targets } = self.flood;
        let Steps::Small(steps) = self.steps else { return };
        let Some(bytes) = steps.bytes() else { return };
        steps.all_reached = match self.sides {
            Some(sides) => byte_waves::flood(walls, targets, sides, bytes),
            None => byte_waves::flood(walls, targets, &mut { OpenSides::NONE }, bytes),
        };
    }
}

#[inline(always)]
fn small_steps<H: ParityPlane>(flooded: &Flooded<H>) -> SmallSteps {
    let mut rows = [[[0; 16]; 8]; 2];
    flooded.write_bytes(0, &mut rows);
    SmallSteps { rows, all_reached: flooded.is_full() }
}

#[inline(always)]
fn large_steps<H: ParityPlane>(flooded: &Flooded<H>) -> [u16; LARGE_AREA] {
    let rows = [[[0; 16]; 8]; MazeSize::MAX_AREA / 128];
    let (mut low, mut high) = (rows, rows);
    flooded.write_bytes(0, &mut low);
    flooded.write_bytes(8, &mut high);
    let (low, high) = (low.as_flattened().as_flattened(), high.as_flattened().as_flattened());
    let mut steps = [0; LARGE_AREA];
    for (steps, (&low, &high)) in steps.iter_mut().zip(low.iter().zip(high)) {
        *steps = u16::from_le_bytes([low, high]);
    }
    steps
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, Maze, Pose};
    use proptest::prelude::*;

    use super::*;

    /// Returns the available instruction sets.
    pub(super) fn available() -> impl Iterator<Item = Instructions> {
        Instructions::ALL.iter().copied().filter(|instructions| instructions.is_available())
    }

    #[test]
    fn distances_go_around_walls() {
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
    fn the_longest_paths_are_measured() {
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
                for instructions in available() {
                    let distances = Distances::flood_with(instructions, &walls, &targets);
                    assert_eq!(distances.at(from), Some(expected));
                    assert_eq!(distances.reachable_cells(), size.area());
                }
            }
        }
    }

    #[test]
    fn targets_outside_the_maze_are_ignored() {
        let walls = Walls::open(MazeSize::new(2, 2).unwrap());
        let targets = [Cell::new(2, 0)].into_iter().collect();
        assert_eq!(Distances::flood(&walls, &targets).reachable_cells(), 0);
    }

    /// Computes the distances naively, by relaxing every step until no distance changes.
    fn naive(walls: &Walls, targets: &CellSet) -> Vec<Option<u16>> {
        let size = walls.size();
        let mut steps: Vec<Option<u16>> =
            size.cells().map(|cell| targets.contains(cell).then_some(0)).collect();
        let index = |cell: Cell| size.index(cell).unwrap();
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

    /// Generates the walls of a maze of any size, with one of three densities.
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

    /// Generates a few targets, some of them adjacent to each other or outside the maze.
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
        fn a_flood_equals_a_naive_one(
            walls in any_walls(),
            targets in any_targets(),
            seen in prop::collection::vec((0u8..32, 0u8..32), 0..60),
        ) {
            let (size, expected) = (walls.size(), naive(&walls, &targets));
            let all_of = |distances: &Distances| -> Vec<_> {
                let cells: Vec<_> = size.cells().map(|cell| distances.at(cell)).collect();
                let width = usize::from(size.width());
                assert!(distances.rows().map(Vec::from_iter).eq(cells.chunks(width)));
                let backwards = distances.rows().rev().flat_map(Iterator::rev);
                assert!(backwards.eq(cells.iter().rev().copied()));
                assert_eq!(distances.reachable_cells(), cells.iter().flatten().count());
                cells
            };
            prop_assert_eq!(all_of(&Distances::flood(&walls, &targets)), expected.clone());
            for instructions in available() {
                let distances = Distances::flood_with(instructions, &walls, &targets);
                prop_assert_eq!(all_of(&distances), expected.clone());
            }
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
            prop_assert_eq!([all_of(&both[0]), all_of(&both[1])], alone);
            let inside = targets.iter().filter(|&cell| size.contains(cell)).collect();
            prop_assert_eq!(Distances::flood(&walls, &targets), Distances::flood(&walls, &inside));
        }
    }
}
