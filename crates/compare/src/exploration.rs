//! The vehicle and the tolerance of strategies that explore for the fastest run.

use mmsim_fastrun::{Planners, Vehicle};
use mmsim_maze::{Escaped, KnownMaze, MazeSize};
use mmsim_solvers::{BundledStrategy, Strategy, TimeBounds, Tolerance};

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

    /// Returns the vehicle in mazes of this size.
    pub fn vehicle(&self, size: MazeSize) -> &Vehicle {
        self.planners.for_size(size).vehicle()
    }

    /// Returns the bounds on the time of the fastest run after a search.
    pub fn bounds(&self, map: &KnownMaze) -> TimeBounds {
        TimeBounds::new(map, &mut self.planners.for_size(map.size()).clone())
    }

    /// Describes what a search in a maze of this size has proven, in one line. Returns `None` if no run
    /// is known.
    pub fn summary(&self, bounds: TimeBounds, size: MazeSize) -> Option<String> {
        let (time, loss) = (bounds.pessimistic?, bounds.loss()?);
        let vehicle = Escaped(self.vehicle(size).name());
        let proof = if loss > 0.0 {
            // Rounded up, so that the statement stays true.
            let percent = (loss * 1e4).ceil() / 1e2;
            format!("at most {percent}% slower than the fastest run")
        } else {
            "proven to be the fastest run".into()
        };
        Some(format!("fast run: {time:.3} s with the vehicle {vehicle}, {proof}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_state_the_loss_or_the_proof() {
        let exploration = Exploration::new(Some(Vehicle::ares()), Tolerance::ZERO);
        let summary = |optimistic, pessimistic| {
            let bounds = TimeBounds { optimistic, pessimistic };
            exploration.summary(bounds, MazeSize::CLASSIC).unwrap_or_default()
        };
        insta::assert_snapshot!(summary(Some(3.5), Some(3.5)), @"fast run: 3.500 s with the vehicle ares, proven to be the fastest run");
        insta::assert_snapshot!(summary(Some(3.5), Some(3.6)), @"fast run: 3.600 s with the vehicle ares, at most 2.86% slower than the fastest run");
        assert_eq!(summary(Some(3.5), None), "");
        assert_eq!(summary(None, None), "");
    }
}
