//! The JSON report of a trial.

use mmsim_trial::{Ending, Score};
use serde::Serialize;

use super::outcome::{Contender, TrialOutcome};
use crate::selection::Selected;

/// A trial. The field names are JSON keys.
#[derive(Serialize)]
pub(crate) struct TrialReport {
    maze: String,
    robot: &'static str,
    ending: &'static str,
    explore_steps: u32,
    race_steps: u32,
    /// Rounded to three decimals; null if the robot did not score.
    score: Option<f64>,
    /// Null if the goal is unreachable.
    race_optimum: Option<u16>,
    seed: u64,
    noise: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
}

impl TrialReport {
    pub(crate) fn new(selected: &Selected, contender: &Contender, outcome: &TrialOutcome) -> Self {
        let TrialOutcome { ending, explore_steps, race_steps, race_optimum, .. } = *outcome;
        Self {
            maze: selected.path.display().to_string(),
            robot: contender.robot.name(),
            ending: match ending {
                Ending::Scored(_) => "scored",
                Ending::OutOfTime => "out of time",
                Ending::GaveUp => "gave up",
            },
            explore_steps,
            race_steps,
            score: outcome.score().map(three_decimals),
            race_optimum,
            seed: contender.settings.seed,
            noise: contender.settings.noise,
            path: None,
        }
    }

    /// Adds the drawing of the race.
    pub(crate) fn with_path(self, outcome: &TrialOutcome) -> Self {
        let [path, _] = outcome.drawings();
        Self { path: Some(path), ..self }
    }
}

/// Rounds a score to three decimals.
fn three_decimals(score: Score) -> f64 {
    (score.value() * 1000.).round() / 1000.
}
