//! The vehicle and the tolerance of strategies that explore for the fastest run.

use mmsim_fastrun::{Planner, Planners, Vehicle};
use mmsim_maze::MazeSize;
use mmsim_solvers::{BundledStrategy, Strategy, Tolerance};

/// The vehicle whose fastest run a mouse explores for, and the accepted tolerance.
pub struct Exploration {
    planners: Planners,
    tolerance: Tolerance,
}

impl Exploration {
    /// Creates an exploration for a vehicle, or for the [default vehicle](Vehicle::default_for) of each
    /// maze.
    pub fn new(vehicle: Option<Vehicle>, tolerance: Tolerance) -> Self {
        Self { planners: Planners::new(vehicle), tolerance }
    }

    /// Creates a strategy in its initial state, for mazes of this size.
    pub fn strategy(&self, strategy: BundledStrategy, size: MazeSize) -> Box<dyn Strategy + Send> {
        strategy.strategy_for(self.planners.for_size(size), self.tolerance)
    }

    /// Returns the planner for mazes of this size.
    pub fn planner(&self, size: MazeSize) -> &Planner {
        self.planners.for_size(size)
    }
}
