//! The progress of a trial, as a viewer sees it in the states that a robot reports.

use std::fmt;

use crate::trial::{Score, Trial, TrialOutcome, TrialPhase};

/// The beginning of the name of the strategy that a robot in a trial reports.
const PREFIX: &str = "two-run trial: ";

/// The status of a trial: one of the two runs, or how the trial has ended.
///
/// A robot that reports its states to a simulator reports the status as the name of its strategy,
/// so that viewers and recordings can tell a trial from a search.
///
/// ```
/// use mmsim_trial::TrialStatus;
/// assert_eq!(TrialStatus::Race.strategy(), "two-run trial: run 2");
/// assert_eq!(TrialStatus::from_strategy("two-run trial: run 2"), Some(TrialStatus::Race));
/// assert_eq!(TrialStatus::from_strategy("flood-fill"), None);
/// ```
// Recordings contain the numbers of these variants, so their order must not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TrialStatus {
    /// The robot explores the maze in the first run.
    Explore,
    /// The robot races to the goal in the second run.
    Race,
    /// The robot has finished both runs.
    Scored,
    /// The robot has reached the limit of [`Trial::MAX_STEPS`] steps.
    OutOfTime,
    /// The robot has reported that the goal is unreachable.
    GaveUp,
    /// The robot's program has failed.
    Failed,
}

impl TrialStatus {
    const ALL: [Self; 6] =
        [Self::Explore, Self::Race, Self::Scored, Self::OutOfTime, Self::GaveUp, Self::Failed];

    /// Returns the status of a trial.
    pub const fn new(trial: &Trial<'_>) -> Self {
        match (trial.outcome(), trial.phase()) {
            (Some(outcome), _) => Self::from_outcome(outcome),
            (None, TrialPhase::Explore) => Self::Explore,
            (None, TrialPhase::Race) => Self::Race,
        }
    }

    /// Returns the status of a trial that has ended.
    pub const fn from_outcome(outcome: TrialOutcome) -> Self {
        match outcome {
            TrialOutcome::Scored(_) => Self::Scored,
            TrialOutcome::OutOfTime => Self::OutOfTime,
            TrialOutcome::GaveUp => Self::GaveUp,
            TrialOutcome::Failed => Self::Failed,
        }
    }

    /// Returns the status as the name of a strategy.
    pub fn strategy(self) -> String {
        format!("{PREFIX}{self}")
    }

    /// Parses the name of a strategy. Returns `None` if the name does not belong to a trial.
    pub fn from_strategy(name: &str) -> Option<Self> {
        let status = name.strip_prefix(PREFIX)?;
        Self::ALL.into_iter().find(|one| one.key().split('_').eq(status.split(' ')))
    }

    /// Returns the status as a value in JSON.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Explore => "run_1",
            Self::Race => "run_2",
            Self::Scored => "scored",
            Self::OutOfTime => "out_of_time",
            Self::GaveUp => "gave_up",
            Self::Failed => "failed",
        }
    }
}

impl fmt::Display for TrialStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.key().replace('_', " "))
    }
}

/// The number of steps of each run up to a state of a trial. The robot reports one state before the
/// first step and one after each step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrialProgress {
    /// The status in this state.
    pub status: TrialStatus,
    /// The number of steps of each run.
    pub steps: Score,
}

impl TrialProgress {
    /// Returns the progress in the state `index`, or `None` if the states do not belong to a trial.
    /// `status_at` returns the status in a state up to `index` and is called only for a few states.
    pub fn at(index: u32, status_at: impl Fn(u32) -> Option<TrialStatus>) -> Option<Self> {
        let status = status_at(index)?;
        let is_explore = |index| status_at(index).map(|status| status == TrialStatus::Explore);
        // The first run ends with the first state that has another status.
        let (mut explore, mut end) = (0, index);
        while explore < end {
            let middle = explore + (end - explore) / 2;
            if is_explore(middle)? { explore = middle + 1 } else { end = middle }
        }
        let steps = Score { explore_steps: explore, race_steps: index - explore };
        Some(Self { status, steps })
    }

    /// Returns the score if the trial has ended with a score.
    pub fn score(self) -> Option<Score> {
        (self.status == TrialStatus::Scored).then_some(self.steps)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze};

    use super::*;
    use crate::bundled::{BundledRobot, Settings};

    #[test]
    fn the_name_of_a_strategy_contains_the_status() {
        for status in TrialStatus::ALL {
            assert_eq!(TrialStatus::from_strategy(&status.strategy()), Some(status));
        }
        for name in ["", "two-run trial: ", "two-run trial: run 3", "run 1", "swing"] {
            assert_eq!(TrialStatus::from_strategy(name), None, "{name}");
        }
    }

    /// Runs a robot and checks the progress in each state, in each later state.
    fn check(maze: &str, robot: BundledRobot) -> TrialStatus {
        let maze: Maze = maze.parse().unwrap();
        let mut robot = robot.robot(KnownMaze::unexplored(&maze), &Settings::default());
        let mut trial = Trial::new(&maze);
        let mut expected = vec![];
        loop {
            let steps =
                Score { explore_steps: trial.explore_steps(), race_steps: trial.race_steps() };
            expected.push(TrialProgress { status: TrialStatus::new(&trial), steps });
            if trial.outcome().is_some() {
                break;
            }
            trial.act(robot.next_move(trial.readings()));
        }
        let status_at = |index: u32| expected.get(index as usize).map(|it| it.status);
        for (index, expected) in (0..).zip(&expected) {
            assert_eq!(TrialProgress::at(index, status_at), Some(*expected), "state {index}");
        }
        let last = expected[expected.len() - 1];
        let score = match trial.outcome() {
            Some(TrialOutcome::Scored(score)) => Some(score),
            _ => None,
        };
        assert_eq!(last.score(), score);
        assert_eq!(TrialProgress::at(u32::MAX, status_at), None);
        last.status
    }

    #[test]
    fn each_state_has_the_steps_of_both_runs() {
        let open = "o---o---o---o\n|         G |\no   o---o   o\n| S         |\no---o---o---o\n";
        let closed = "o---o---o\n| S | G |\no---o---o\n";
        for (maze, robot, expected) in [
            (open, BundledRobot::Champion, TrialStatus::Scored),
            (open, BundledRobot::Swing, TrialStatus::Scored),
            (closed, BundledRobot::Champion, TrialStatus::GaveUp),
            (closed, BundledRobot::Random, TrialStatus::OutOfTime),
        ] {
            assert_eq!(check(maze, robot), expected, "{robot}");
        }
    }
}
