//! The distance from one cell to the nearest target.

use mmsim_maze::{Cell, CellSet, Walls};

use super::bytes::{self, FloodMemory};
use super::dispatch::{Task, run};
use super::wide::bitboard::{Bitboard, CellPlanes};
use super::wide::plane::ParityPlane;
use super::wide::waves;

/// Returns the number of steps from a cell to the nearest target, or `None` if no target is
/// reachable or the cell is outside the maze. This function is faster than a flood, because it
/// stops at the first target and stores no distances.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::steps_between;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let goals = MazeSize::CLASSIC.central_cells();
/// assert_eq!(steps_between(&walls, Cell::new(0, 0), &goals), Some(14));
/// ```
#[must_use]
pub fn steps_between(walls: &Walls, from: Cell, targets: &CellSet) -> Option<u16> {
    steps_between_in(None, walls, from, targets)
}

/// Does the same as [`steps_between`], but may use the given memory instead of the stack.
pub(crate) fn steps_between_in(
    memory: Option<&mut FloodMemory>,
    walls: &Walls,
    from: Cell,
    targets: &CellSet,
) -> Option<u16> {
    let task = StepsBetweenTask { walls, from, targets, memory };
    walls.size().contains(from).then(|| run(task, walls.size())).flatten()
}

struct StepsBetweenTask<'a> {
    walls: &'a Walls,
    from: Cell,
    targets: &'a CellSet,
    memory: Option<&'a mut FloodMemory>,
}

impl Task for StepsBetweenTask<'_> {
    type Output = Option<u16>;

    #[inline(always)]
    fn run<H: ParityPlane>(self) -> Option<u16> {
        let Self { walls, from, targets, .. } = self;
        let board = Bitboard::<H>::from_walls(walls);
        let (from, targets) =
            (CellPlanes::<H>::from_cell(from), CellPlanes::<H>::from_cells(targets));
        let (into, from, targets) = if from.light.is_empty() {
            ([&board.light, &board.dark], from.dark, [targets.dark, targets.light])
        } else {
            ([&board.dark, &board.light], from.light, [targets.light, targets.dark])
        };
        waves::first_targets(into, from, targets).map(|(_, steps)| steps)
    }

    fn run_on_bytes(self) -> Option<u16> {
        let Self { walls, from, targets, memory } = self;
        let steps = |FloodMemory { sides, from_start, .. }: &mut _| {
            let nearest = bytes::waves::nearest(walls, from, targets, sides, from_start);
            Some(from_start[bytes::waves::index(nearest.iter().next()?)].into())
        };
        match memory {
            Some(memory) => steps(memory),
            None => steps(&mut { FloodMemory::NEW }),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::flood::Distances;
    use crate::flood::dispatch::run_with;
    use crate::flood::tests::{any_targets, any_walls, available};

    proptest! {
        #[test]
        fn steps_between_equals_the_flood(
            walls in any_walls(),
            targets in any_targets(),
            (x, y) in (0u8..33, 0u8..33),
        ) {
            let from = Cell::new(x, y);
            let expected = Distances::flood(&walls, &targets).at(from);
            prop_assert_eq!(steps_between(&walls, from, &targets), expected);
            if walls.size().contains(from) {
                for instructions in available() {
                    let task = StepsBetweenTask { walls: &walls, from, targets: &targets, memory: None };
                    prop_assert_eq!(run_with(instructions, task, walls.size()), expected);
                }
            }
        }
    }
}
