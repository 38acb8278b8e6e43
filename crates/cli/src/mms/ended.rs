//! How a mouse has ended, as it is told.

use std::fmt::Write as _;
use std::process::ExitStatus;

use mmsim_client::RunError;
use mmsim_mms::{GeneralFormat, SimulatedMouse, Stat, TravelStats};
use serde::Serialize;

use crate::interrupt::Interrupt;

/// A mouse that has ended, or was ended.
pub(crate) struct Ended {
    pub(crate) mouse: SimulatedMouse,
    pub(crate) how: How,
    /// How many movements came to a wall, or were none.
    pub(crate) crashes: u64,
    /// How many lines were no commands.
    pub(crate) refused: u64,
}

pub(crate) enum How {
    ByItself(ExitStatus),
    Limit(u32),
    Interrupted,
    LostSimulator(RunError),
    NotStarted(String),
    Failed(String),
}

impl Ended {
    /// The exit code: the mouse's own where it has ended by itself.
    pub(crate) fn code(&self) -> i32 {
        match &self.how {
            How::ByItself(status) => {
                status.code().or_else(|| Some(128 + signal(*status)?)).unwrap_or(1)
            }
            How::Interrupted => Interrupt::CODE,
            How::Limit(_) | How::LostSimulator(_) | How::NotStarted(_) | How::Failed(_) => 1,
        }
    }

    /// A line that sums it up.
    pub(crate) fn summary(&self) -> String {
        let how = match &self.how {
            How::ByItself(status) => match signal(*status) {
                Some(signal) => format!("was ended by signal {signal}"),
                None => format!("has ended with exit code {}", self.code()),
            },
            How::Limit(limit) => format!("was ended: limit reached, {limit}"),
            How::Interrupted => "was ended by Ctrl-C".into(),
            How::NotStarted(_) => "was not started".into(),
            How::LostSimulator(_) | How::Failed(_) => "was ended".into(),
        };
        let scores = self.mouse.scores();
        let goal = if scores.best_run().is_some() { "goal reached" } else { "goal not reached" };
        format!("the mouse {how}; {goal}, score {}", GeneralFormat(scores.score()))
    }

    /// What mms's competitions write down, a line each.
    pub(crate) fn scores(&self) -> String {
        let scores = self.mouse.scores();
        Stat::COMPETITION.iter().fold(String::new(), |mut text, &stat| {
            let value = scores.stat(stat);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{stat}: {value}");
            text
        })
    }

    /// What `--json` prints.
    pub(crate) fn report(&self) -> Report {
        let scores = self.mouse.scores();
        let (total, best) = (scores.total(), scores.best_run());
        let (exit_code, signal) = match &self.how {
            How::ByItself(status) => (status.code(), signal(*status)),
            _ => (None, None),
        };
        let error = match &self.how {
            How::LostSimulator(error) => Some(error.to_string()),
            How::NotStarted(error) | How::Failed(error) => Some(error.clone()),
            _ => None,
        };
        Report {
            goal_reached: best.is_some(),
            score: scores.score(),
            best_run_distance: best.map(TravelStats::distance),
            best_run_effective_distance: best.map(TravelStats::effective_distance),
            best_run_turns: best.map(TravelStats::turns),
            total_distance: total.distance(),
            total_effective_distance: total.effective_distance(),
            total_turns: total.turns(),
            visited_cells: self.mouse.map().visited().len(),
            crashes: self.crashes,
            refused_lines: self.refused,
            limit_reached: matches!(self.how, How::Limit(_)),
            exit_code,
            signal,
            error,
        }
    }
}

/// What `--json` prints; null is what there is not.
#[derive(Serialize)]
pub(crate) struct Report {
    goal_reached: bool,
    score: f64,
    best_run_distance: Option<f64>,
    best_run_effective_distance: Option<f64>,
    best_run_turns: Option<u64>,
    total_distance: f64,
    total_effective_distance: f64,
    total_turns: u64,
    visited_cells: usize,
    crashes: u64,
    refused_lines: u64,
    limit_reached: bool,
    exit_code: Option<i32>,
    signal: Option<i32>,
    error: Option<String>,
}

/// The signal that has ended a process, where there are signals.
#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
const fn signal(_: ExitStatus) -> Option<i32> {
    None
}
