//! How far it is from one cell to the nearest target.

use mmsim_maze::{Cell, CellSet, Walls};

use super::board::{Board, Chequered};
use super::half::Half;
use super::processor::{Task, run};
use super::waves;

/// Steps from a cell to the nearest target, `None` where there is no way and where the cell lies
/// outside of the maze. This is a flood that ends as soon as it comes to a target, and writes nothing
/// down on its way.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::steps_between;
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let goals = MazeSize::CLASSIC.central_cells();
/// assert_eq!(steps_between(&walls, Cell::new(0, 0), &goals), Some(14));
/// ```
pub fn steps_between(walls: &Walls, from: Cell, targets: &CellSet) -> Option<u16> {
    let size = walls.size();
    let is_inside = size.contains(from);
    is_inside.then(|| run(StepsBetween { walls, from, targets }, size)).flatten()
}

struct StepsBetween<'a> {
    walls: &'a Walls,
    from: Cell,
    targets: &'a CellSet,
}

impl Task for StepsBetween<'_> {
    type Output = Option<u16>;

    #[inline(always)]
    fn run<const N: usize, H: Half<N>>(self) -> Option<u16> {
        let Self { walls, from, targets } = self;
        let board = Board::<H>::of(walls);
        let (from, targets) = (Chequered::<H>::from_cell(from), Chequered::<H>::of(targets));
        let (ways, from, targets) = if from.light.is_empty() {
            ([&board.into_light, &board.into_dark], from.dark, [targets.dark, targets.light])
        } else {
            ([&board.into_dark, &board.into_light], from.light, [targets.light, targets.dark])
        };
        waves::first_targets(ways, from, targets).map(|(_, steps)| steps)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Distances;
    use crate::flood::processor::with_each;
    use crate::flood::tests::{any_targets, any_walls};

    proptest! {
        #[test]
        fn a_cell_is_as_far_as_the_flood_says(
            walls in any_walls(),
            targets in any_targets(),
            (x, y) in (0u8..33, 0u8..33),
        ) {
            let from = Cell::new(x, y);
            let expected = Distances::flood(&walls, &targets).at(from);
            prop_assert_eq!(steps_between(&walls, from, &targets), expected);
            if walls.size().contains(from) {
                let task = || StepsBetween { walls: &walls, from, targets: &targets };
                with_each(task, walls.size(), |steps| assert_eq!(steps, expected));
            }
        }
    }
}
