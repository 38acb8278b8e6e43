//! The result of a run: why the mouse exited, and its scores.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitStatus;
use std::time::Duration;

use mmsim_client::RunError;
use mmsim_mms::{GeneralFormat, ScoreRules, Scores, SimulatedMouse, Stat, TravelStats};
use mmsim_viewer::{Ending, EndingKind, MouseControl, StopReason};
use serde::Serialize;

use crate::mouse_process::{WaitError, exit_code, exit_text, signal, stop_code};
use crate::output::counted;
use crate::own_mouse::RunEnd;

/// A mouse that is not running.
pub(crate) struct MouseExit {
    pub(crate) mouse: SimulatedMouse,
    pub(crate) cause: ExitCause,
    /// The number of movements that ended in a crash.
    pub(crate) crashes: u64,
    /// The number of invalid commands.
    pub(crate) refused: u64,
}

/// The reason why a mouse is not running.
pub(crate) enum ExitCause {
    Exited(ExitStatus),
    Limit(u32),
    Stopped(StopReason),
    LostSimulator(RunError),
    NotStarted(String),
    Failed(String),
}

impl ExitCause {
    /// Returns an error if the mouse must stop.
    pub(crate) fn check(control: &MouseControl) -> Result<(), Self> {
        control.wait_for_stop(Duration::ZERO).map_or(Ok(()), |reason| Err(Self::Stopped(reason)))
    }
}

impl From<WaitError> for ExitCause {
    fn from(error: WaitError) -> Self {
        match error {
            WaitError::Stopped(reason) => Self::Stopped(reason),
            WaitError::Failed(_) => Self::Failed(error.to_string()),
        }
    }
}

impl MouseExit {
    /// Returns the exit code of this process: the exit code of the mouse, 128 plus the number of
    /// the signal that killed the mouse, 130 after Ctrl-C, or 1 in all other cases.
    pub(crate) fn code(&self) -> i32 {
        match &self.cause {
            ExitCause::Exited(status) => exit_code(*status),
            ExitCause::Stopped(reason) => stop_code(*reason),
            ExitCause::Limit(_)
            | ExitCause::LostSimulator(_)
            | ExitCause::NotStarted(_)
            | ExitCause::Failed(_) => 1,
        }
    }

    /// Returns the outcome of the run in one line.
    pub(crate) fn outcome(&self) -> String {
        let how = match &self.cause {
            ExitCause::Exited(status) => exit_text(*status),
            ExitCause::Limit(limit) => format!("stopped: exceeded --limit {limit}"),
            ExitCause::Stopped(reason) => reason.text().into(),
            ExitCause::NotStarted(error) => return error.clone(),
            ExitCause::LostSimulator(error) => format!("stopped: {error}"),
            ExitCause::Failed(error) => format!("stopped: {error}"),
        };
        let scores = self.mouse.scores();
        let goal = if scores.best_run().is_some() { "goal reached" } else { "goal not reached" };
        let count = |count, thing| match count {
            0 => String::new(),
            count => format!("; {}", counted(count, thing)),
        };
        let crashes = count(self.crashes, "crashed movement");
        let invalid = count(self.refused, "invalid line");
        format!("{how}; {goal}, score {}{crashes}{invalid}", GeneralFormat(scores.score()))
    }

    /// Returns the outcome for the viewer page and the exit code.
    pub(crate) fn end(&self) -> RunEnd {
        let kind = match &self.cause {
            ExitCause::Exited(status) if !status.success() => EndingKind::Failed,
            ExitCause::Exited(_) if self.mouse.scores().best_run().is_some() => EndingKind::Goal,
            ExitCause::Exited(_) => EndingKind::GaveUp,
            ExitCause::Limit(_) | ExitCause::Stopped(_) => EndingKind::Stopped,
            ExitCause::LostSimulator(_) | ExitCause::NotStarted(_) | ExitCause::Failed(_) => {
                EndingKind::Failed
            }
        };
        RunEnd {
            ending: Ending { kind, text: self.outcome() },
            code: self.code(),
            was_started: !matches!(self.cause, ExitCause::NotStarted(_)),
        }
    }

    /// Returns the scores that mms competitions use, one per line.
    pub(crate) fn scores(&self) -> String {
        let scores = self.mouse.scores();
        Stat::COMPETITION.iter().fold(String::new(), |mut text, &stat| {
            let value = scores.stat(stat);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{stat}: {value}");
            text
        })
    }

    /// Returns the output of `mms --json`. `maze` is the name of the maze, if it is known.
    pub(crate) fn report<'m>(&self, maze: Option<&'m str>) -> MouseReport<'m> {
        let scores = self.mouse.scores();
        let (exit_code, signal) = match &self.cause {
            ExitCause::Exited(status) => (status.code(), signal(*status)),
            _ => (None, None),
        };
        let error = match &self.cause {
            ExitCause::LostSimulator(error) => Some(error.to_string()),
            ExitCause::NotStarted(error) | ExitCause::Failed(error) => Some(error.clone()),
            _ => None,
        };
        let by = |rules: ScoreRules| (rules.name(), ScoreReport::new(self.mouse.scores_by(rules)));
        MouseReport {
            maze,
            goal_reached: scores.best_run().is_some(),
            scores: scores.rules().name(),
            chosen: ScoreReport::new(scores),
            scores_by: ScoreRules::ALL.map(by).into(),
            visited_cells: self.mouse.map().visited().len(),
            crashes: self.crashes,
            refused_lines: self.refused,
            limit_reached: matches!(self.cause, ExitCause::Limit(_)),
            time_limit_reached: matches!(self.cause, ExitCause::Stopped(StopReason::TimeLimit)),
            exit_code,
            signal,
            error,
        }
    }
}

/// The output of `mms --json`.
#[derive(Serialize)]
pub(crate) struct MouseReport<'m> {
    maze: Option<&'m str>,
    goal_reached: bool,
    /// The name of the chosen rules.
    scores: &'static str,
    #[serde(flatten)]
    chosen: ScoreReport,
    scores_by: BTreeMap<&'static str, ScoreReport>,
    visited_cells: usize,
    crashes: u64,
    refused_lines: u64,
    limit_reached: bool,
    time_limit_reached: bool,
    exit_code: Option<i32>,
    signal: Option<i32>,
    error: Option<String>,
}

/// The scores by some rules.
#[derive(Serialize)]
struct ScoreReport {
    score: f64,
    best_run_distance: Option<f64>,
    best_run_effective_distance: Option<f64>,
    best_run_turns: Option<u64>,
    total_distance: f64,
    total_effective_distance: f64,
    total_turns: u64,
}

impl ScoreReport {
    fn new(scores: &Scores) -> Self {
        let (total, best) = (scores.total(), scores.best_run());
        Self {
            score: scores.score(),
            best_run_distance: best.map(TravelStats::distance),
            best_run_effective_distance: best.map(TravelStats::effective_distance),
            best_run_turns: best.map(TravelStats::turns),
            total_distance: total.distance(),
            total_effective_distance: total.effective_distance(),
            total_turns: total.turns(),
        }
    }
}
