//! The JSON report of a trial.

use mmsim_trial::{Score, TrialOutcome};
use serde::Serialize;

use super::contender::Contender;
use super::outcome::TrialResult;
use crate::selection::Selected;

/// The result of a trial. The field names are JSON keys.
#[derive(Serialize)]
pub(crate) struct TrialReport {
    maze: String,
    robot: String,
    ending: &'static str,
    /// The step in which the robot failed, and the reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    explore_steps: u32,
    race_steps: u32,
    /// The score, rounded to three decimals, or null if the robot did not score.
    score: Option<f64>,
    /// The minimum number of race steps, or null if the goal is unreachable.
    race_optimum: Option<u16>,
    seed: u64,
    noise: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) path: Option<String>,
}

impl TrialReport {
    pub(crate) fn new(selected: &Selected, contender: &Contender, outcome: &TrialResult) -> Self {
        let TrialResult { ending, explore_steps, race_steps, race_optimum, .. } = *outcome;
        Self {
            maze: selected.path.display().to_string(),
            robot: contender.name().into(),
            ending: match ending {
                TrialOutcome::Scored(_) => "scored",
                TrialOutcome::OutOfTime => "out of time",
                TrialOutcome::GaveUp => "gave up",
                TrialOutcome::Failed => "failed",
            },
            error: outcome.failure.clone(),
            explore_steps,
            race_steps,
            score: outcome.score().map(three_decimals),
            race_optimum,
            seed: contender.settings.seed,
            noise: contender.settings.noise,
            path: None,
        }
    }
}

/// Rounds a score to three decimals.
fn three_decimals(score: Score) -> f64 {
    (score.value() * 1000.).round() / 1000.
}
