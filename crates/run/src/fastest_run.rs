//! What known walls prove about the fastest run.

use std::fmt;

use mmsim_fastrun::Planner;
use mmsim_maze::{Escaped, KnownMaze};
use mmsim_solvers::TimeBounds;
use serde::Serialize;

use crate::times::tenth_of_ms;

/// The bounds on the time of the fastest run of a vehicle, and whether the known walls prove that the best
/// known run is the fastest. The field names are JSON keys.
///
/// ```
/// use mmsim_fastrun::{Planner, Vehicle};
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_run::FastestRun;
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let mut map = KnownMaze::unexplored(&maze);
/// let mut planner = Planner::new(Vehicle::ukmars());
/// assert_eq!(FastestRun::new(&map, &mut planner).known_run_time_s, None);
/// map.observe(maze.start(), maze.walls().around(maze.start()))?;
/// let known = FastestRun::new(&map, &mut planner);
/// // 270 mm at 3 m/s²: twice the root of 0.27 / 3.
/// assert_eq!((known.known_run_time_s, known.fastest_run_proven), (Some(0.6), true));
/// assert_eq!(
///     known.to_string(),
///     "fastest known run: 0.600 s with the vehicle ukmars, proven to be the fastest run"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FastestRun {
    /// The name of the vehicle.
    pub vehicle: String,
    /// The time in s of the fastest run through the known walls, or `None` if no run is known.
    pub known_run_time_s: Option<f64>,
    /// The time in s of the fastest run if all unknown walls were open, or `None` if known walls block
    /// every run.
    pub fastest_run_lower_bound_s: Option<f64>,
    /// True if both times are equal, which proves that the best known run is the fastest.
    pub fastest_run_proven: bool,
    /// The share of the fastest run's time by which the known run may be slower.
    #[serde(skip)]
    loss: Option<f64>,
}

impl FastestRun {
    /// Computes the bounds from the walls of a map, for the vehicle of a planner.
    pub fn new(map: &KnownMaze, planner: &mut Planner) -> Self {
        let bounds = TimeBounds::new(map, planner);
        let loss = bounds.loss();
        let fastest_run_proven = loss == Some(0.0);
        // Times that differ by a rounding error count as equal.
        let bound = if fastest_run_proven { bounds.pessimistic } else { bounds.optimistic };
        Self {
            vehicle: planner.vehicle().name().into(),
            known_run_time_s: bounds.pessimistic.map(tenth_of_ms),
            fastest_run_lower_bound_s: bound.map(tenth_of_ms),
            fastest_run_proven,
            loss,
        }
    }
}

/// Writes the time and what is proven in one line.
impl fmt::Display for FastestRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Some(time), Some(loss)) = (self.known_run_time_s, self.loss) else {
            return f.write_str("fastest known run: none");
        };
        let vehicle = Escaped(&self.vehicle);
        write!(f, "fastest known run: {time:.3} s with the vehicle {vehicle}, ")?;
        if self.fastest_run_proven {
            return f.write_str("proven to be the fastest run");
        }
        // Rounded up, so that the statement stays true.
        write!(f, "at most {}% slower than the fastest run", (loss * 1e4).ceil() / 1e2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_states_the_loss_or_the_proof() {
        let text = |known_run_time_s, loss| {
            let fastest_run_proven = loss == Some(0.0);
            let vehicle = "ares".into();
            let run = FastestRun {
                vehicle,
                known_run_time_s,
                fastest_run_proven,
                loss,
                ..FastestRun::default()
            };
            run.to_string()
        };
        insta::assert_snapshot!(text(Some(3.5), Some(0.0)), @"fastest known run: 3.500 s with the vehicle ares, proven to be the fastest run");
        insta::assert_snapshot!(text(Some(3.6), Some(0.02857)), @"fastest known run: 3.600 s with the vehicle ares, at most 2.86% slower than the fastest run");
        insta::assert_snapshot!(text(None, None), @"fastest known run: none");
    }
}
