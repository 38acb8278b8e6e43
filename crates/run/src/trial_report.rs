//! The figures of a two-run trial up to a state.

use std::borrow::Borrow;

use mmsim_recording::{Notes, States, Times};
use mmsim_trial::{TrialProgress, TrialStatus};
use serde::Serialize;

use crate::movement::Transition;
use crate::phase_report::RunReport;
use crate::phases::Phases;
use crate::run_index::RunIndex;

/// The figures of a two-run trial up to a state. The field names are JSON keys. Steps are time
/// steps: the robot reports one state before the first step and one after each step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialReport {
    /// The name of the robot.
    pub robot: Option<String>,
    /// `run 1`, `run 2`, `scored`, `out of time`, `gave up` or `failed`.
    pub status: String,
    /// The first run.
    pub run_1: RunReport,
    /// The second run, or `None` if it has not begun.
    pub run_2: Option<RunReport>,
    /// The score with three decimals, if the trial has ended with a score.
    pub score: Option<String>,
}

impl TrialReport {
    /// Returns the figures up to the state `index`, or `None` if the state does not belong to a
    /// trial. `block` returns the block that contains a state.
    pub fn new<B: Borrow<States>>(
        run: &RunIndex,
        index: usize,
        times: &Times,
        block: impl Fn(usize) -> Option<B>,
    ) -> Option<Self> {
        let context = block(index)?.borrow().context(index)?;
        let status = trial_status(context.notes())?;
        let status_at = |index: u32| {
            let index = index as usize;
            trial_status(block(index)?.borrow().context(index)?.notes())
        };
        let progress = TrialProgress::at(u32::try_from(index).ok()?, status_at)?;
        let reset = progress.steps.explore_steps as usize;
        let phases = |index| run.phases(index, |index| block(index).ok_or(())).ok();
        let (at_reset, here) = (phases(reset)?, phases(index)?);
        let report = |steps: u32, turns, from, to| RunReport {
            steps: steps.into(),
            turns,
            ms: times.milliseconds(from, to),
        };
        let has_raced = status == TrialStatus::Race || progress.steps.race_steps > 0;
        let turns = at_reset.total.turns - if has_raced { reset_turns(&at_reset) } else { 0 };
        let run_2 = has_raced.then(|| {
            let turns = here.total.turns - at_reset.total.turns;
            report(progress.steps.race_steps, turns, reset, index)
        });
        Some(Self {
            robot: context.notes().mouse().map(String::from),
            status: status.to_string(),
            run_1: report(progress.steps.explore_steps, turns, 0, reset),
            run_2,
            score: progress.score().map(|score| score.to_string()),
        })
    }
}

/// Returns the status of a trial, or `None` if the notes do not belong to a trial.
pub fn trial_status(notes: &Notes) -> Option<TrialStatus> {
    TrialStatus::from_strategy(notes.strategy()?)
}

/// Returns the quarter turns of a reset in the start cell, which are not turns of the robot. `phases`
/// are those of the first state of the second run.
pub(crate) fn reset_turns(phases: &Phases) -> u64 {
    match phases.transition {
        Some(Transition::Move { turns, .. }) => turns.into(),
        _ => 0,
    }
}
