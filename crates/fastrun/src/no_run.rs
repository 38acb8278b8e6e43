//! The reasons why there is no run.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

/// The reason why there is no run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoRun {
    /// The start is outside the maze.
    #[error("the start at {start} is outside the maze of {size} cells")]
    StartOutside {
        /// The start cell.
        start: Cell,
        /// The size of the maze.
        size: MazeSize,
    },
    /// No goal cell is inside the maze.
    #[error("no goal cell is inside the maze of {size} cells")]
    NoGoal {
        /// The size of the maze.
        size: MazeSize,
    },
    /// The start has walls on all sides.
    #[error("goal unreachable: the start at {start} has walls on all sides")]
    StartEnclosed {
        /// The start cell.
        start: Cell,
    },
    /// The goal has walls on all sides.
    #[error("goal unreachable: walls enclose every goal cell")]
    GoalEnclosed,
    /// Walls separate the goal from the start.
    #[error("goal unreachable from {start}: walls cut off every goal cell")]
    GoalCutOff {
        /// The start cell.
        start: Cell,
    },
}

impl NoRun {
    /// Returns the goals that are inside the maze.
    ///
    /// # Errors
    /// Returns an error if the start or all goals are outside.
    pub(crate) fn check(size: MazeSize, start: Cell, goals: &CellSet) -> Result<CellSet, Self> {
        if !size.contains(start) {
            return Err(Self::StartOutside { start, size });
        }
        let columns = u32::MAX >> (u32::BITS - u32::from(size.width()));
        let mut rows = *goals.rows();
        for (y, row) in rows.iter_mut().enumerate() {
            *row &= if y < size.height().into() { columns } else { 0 };
        }
        let goals = CellSet::from_rows(rows);
        if goals.is_empty() { Err(Self::NoGoal { size }) } else { Ok(goals) }
    }

    /// Returns the reason why no goal can be reached from a start that is no goal.
    pub(crate) fn find(walls: &Walls, start: Cell, goals: &CellSet) -> Self {
        let mut exits = goals.iter().flat_map(|goal| walls.open_neighbours(goal));
        if walls.open_neighbours(start).next().is_none() {
            Self::StartEnclosed { start }
        } else if exits.all(|cell| goals.contains(cell)) {
            Self::GoalEnclosed
        } else {
            Self::GoalCutOff { start }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::Planner;
    use crate::vehicle::Vehicle;

    #[test]
    fn reasons_name_what_is_wrong() {
        let size = MazeSize::new(3, 2).unwrap();
        let (open, closed) = (Walls::open(size), Walls::closed(size));
        let mut planner = Planner::new(Vehicle::ukmars());
        let goals = |x, y| [Cell::new(x, y)].into_iter().collect::<CellSet>();
        let mut reason = |walls: &Walls, start, goals| {
            planner.plan(walls, start, &goals).unwrap_err().to_string()
        };
        let start = Cell::new(0, 0);
        insta::assert_snapshot!(reason(&open, Cell::new(3, 0), goals(0, 1)), @"the start at (3, 0) is outside the maze of 3x2 cells");
        insta::assert_snapshot!(reason(&open, start, goals(0, 2)), @"no goal cell is inside the maze of 3x2 cells");
        insta::assert_snapshot!(reason(&closed, start, goals(2, 1)), @"goal unreachable: the start at (0, 0) has walls on all sides");
        let mut halves = open.clone();
        for (x, y) in [(1, 0), (1, 1)] {
            halves.set(Cell::new(x, y), mmsim_maze::Heading::East, true);
        }
        insta::assert_snapshot!(reason(&halves, start, goals(2, 1)), @"goal unreachable from (0, 0): walls cut off every goal cell");
        halves.set(Cell::new(2, 1), mmsim_maze::Heading::South, true);
        insta::assert_snapshot!(reason(&halves, start, goals(2, 1)), @"goal unreachable: walls enclose every goal cell");
    }
}
