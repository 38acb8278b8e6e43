//! What came of a trial, as JSON.

use mmsim_trial::{Score, TrialOutcome};
use serde::Serialize;

use super::tried::{Contender, Tried};
use crate::selection::Selected;

/// A trial. The names are those of the JSON.
#[derive(Serialize)]
pub(crate) struct Report {
    maze: String,
    robot: &'static str,
    ending: &'static str,
    explore_steps: u32,
    race_steps: u32,
    /// With three decimals, null without a score.
    score: Option<f64>,
    /// Null if the goal cannot be reached.
    race_optimum: Option<u16>,
    seed: u64,
    noise: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<String>,
}

impl Report {
    pub(crate) fn of(given: &Selected, contender: &Contender, tried: &Tried) -> Self {
        let Tried { ending, explore_steps, race_steps, race_optimum, .. } = *tried;
        Self {
            maze: given.path.display().to_string(),
            robot: contender.robot.name(),
            ending: match ending {
                TrialOutcome::Scored(_) => "scored",
                TrialOutcome::OutOfTime => "out of time",
                TrialOutcome::GaveUp => "gave up",
            },
            explore_steps,
            race_steps,
            score: tried.score().map(three_decimals),
            race_optimum,
            seed: contender.settings.seed,
            noise: contender.settings.noise,
            path: None,
        }
    }

    /// With the drawing of the race.
    pub(crate) fn with_path(self, tried: &Tried) -> Self {
        let [path, _] = tried.drawings();
        Self { path: Some(path), ..self }
    }
}

/// The score as it is printed.
fn three_decimals(score: Score) -> f64 {
    (score.value() * 1000.).round() / 1000.
}
