//! The two-run trial "plot and navigate a virtual maze": a robot explores an unknown maze, is reset
//! to the start, and races to the goal.
//!
//! ```text
//!              a step: sensors, then a turn and up to 3 cells
//!   ┌───────┐  [left, front, right]: open cells    ┌───────┐
//!   │       │ ───────────────────────────────────► │       │
//!   │ Trial │                                      │ Robot │      score = race steps
//!   │       │ ◄─────────────────────────────────── │       │              + exploration steps / 30
//!   └───────┘  rotation and movement, or a reset   └───────┘
//! ```
//!
//! [`Trial`] is the environment and follows the rules of the published tester exactly. A [`Robot`]
//! takes part in a trial. The crate uses no clock, sockets or threads, and all randomness comes
//! from seeds, so a trial gives the same result on every machine.
#![forbid(unsafe_code)]

mod bundled;
mod champion;
mod count_expansion;
mod one_sided_walls;
mod progress;
mod race;
mod random_walk;
mod robot;
mod survey;
mod swing;
mod swing_as_published;
mod trial;

pub use bundled::{BundledRobot, Settings, UnknownRobot};
pub use champion::{Champion, StoppingRule, WallPrior};
pub use count_expansion::CountExpansion;
pub use progress::{TrialProgress, TrialStatus};
pub use race::{RaceSteps, race_optimum};
pub use random_walk::RandomWalk;
pub use robot::{Action, Robot, Rotation};
pub use survey::Survey;
pub use swing::{KeyPoints, KeyPointsError, SwingRobot, UnknownVariant, Variant};
pub use swing_as_published::SwingAsPublished;
pub use trial::{
    Score, SensorNoise, Trial, TrialOutcome, TrialPhase, run_observed_trial, run_trial,
};

/// Runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::{Robot, SensorNoise, run_observed_trial};

    /// Returns the actions of a robot in a trial with noise-free sensors.
    pub(crate) fn actions(maze: &Maze, robot: &mut impl Robot) -> Vec<String> {
        let mut actions = Vec::new();
        run_observed_trial(maze, robot, &mut SensorNoise::none(), |_, _, action| {
            actions.push(action.to_string());
        });
        actions
    }

    /// Checks that a robot with noisy sensors neither panics nor leaves the maze.
    pub(crate) fn check_noisy_trials<R: Robot>(new_robot: impl Fn(&Maze) -> R) {
        let text = "o---o---o---o\n|         G |\no   o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for seed in 0..50 {
            let mut noise = SensorNoise::new(0.3, seed);
            run_observed_trial(&maze, &mut new_robot(&maze), &mut noise, |trial, _, _| {
                assert!(maze.size().contains(trial.pose().cell));
            });
        }
    }
}
