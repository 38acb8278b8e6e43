//! The planner, which finds the fastest run.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

use crate::lattice::Direction;
use crate::naive::dijkstra;
use crate::run::FastRun;
use crate::vehicle::Vehicle;

/// Finds the fastest runs of one vehicle. A planner keeps its tables and its memory, so further
/// plans allocate nothing.
#[derive(Clone, Debug)]
pub struct Planner {
    vehicle: Vehicle,
    run: FastRun,
}

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
    /// Walls separate the goal from the start.
    #[error("goal unreachable from {start}: walls cut off every goal cell")]
    GoalCutOff {
        /// The start cell.
        start: Cell,
    },
}

/// Finds the fastest run from rest in the start cell to rest in a goal cell. If the start is a goal,
/// the run is empty. To plan several runs, use a [`Planner`].
///
/// # Errors
/// Returns an error if no goal can be reached.
pub fn fastest(
    walls: &Walls,
    start: Cell,
    goals: &CellSet,
    vehicle: &Vehicle,
) -> Result<FastRun, NoRun> {
    Planner::new(vehicle.clone()).plan(walls, start, goals).cloned()
}

impl Planner {
    /// Creates a planner for a vehicle.
    pub fn new(vehicle: Vehicle) -> Self {
        let run = FastRun::new(Cell::new(0, 0), Direction::North, alloc::vec::Vec::new(), 0);
        Self { vehicle, run }
    }

    /// Returns the vehicle.
    pub const fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Finds the fastest run from rest in the start cell to rest in a goal cell.
    ///
    /// # Errors
    /// Returns an error if no goal can be reached.
    pub fn plan(&mut self, walls: &Walls, start: Cell, goals: &CellSet) -> Result<&FastRun, NoRun> {
        let size = walls.size();
        if !size.contains(start) {
            return Err(NoRun::StartOutside { start, size });
        }
        if !goals.iter().any(|goal| size.contains(goal)) {
            return Err(NoRun::NoGoal { size });
        }
        let found = dijkstra(walls, start, goals, &self.vehicle);
        let (run, _) = found.ok_or_else(|| no_run(walls, start))?;
        self.run = run;
        Ok(&self.run)
    }
}

fn no_run(walls: &Walls, start: Cell) -> NoRun {
    if walls.open_neighbours(start).next().is_none() {
        NoRun::StartEnclosed { start }
    } else {
        NoRun::GoalCutOff { start }
    }
}
