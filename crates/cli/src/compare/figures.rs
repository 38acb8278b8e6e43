//! The figures of a search.

use mmsim_maze::Cell;
use serde::Serialize;

/// The statistics of a search, excluding the fast run unless stated otherwise. The field names
/// are JSON keys and CSV column names.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Figures {
    pub(crate) goal_reached: bool,
    /// The number of steps until the mouse first reached a goal cell, possibly on the fast run.
    pub(crate) steps_to_goal: Option<u32>,
    /// The number of steps until the shortest path was proven.
    pub(crate) steps_until_proven: Option<u32>,
    /// The number of steps until the mouse stopped or began its fast run.
    pub(crate) steps_in_all: u32,
    /// The number of quarter turns until the mouse stopped or began its fast run. A U-turn counts
    /// as two quarter turns.
    pub(crate) turns: u32,
    /// The length in steps of the shortest path known to be open at the end of the search.
    pub(crate) path_found: Option<u16>,
    /// The distance in steps from the start to the goal in the true maze, or `None` if the goal is
    /// unreachable.
    pub(crate) shortest_path: Option<u16>,
    /// The processor time in microseconds, rounded to three decimal places, or `None` for a mouse in
    /// another process.
    pub(crate) time_us: Option<f64>,
    /// The reason why the search or the fast run ended early.
    pub(crate) error: Option<String>,
    /// How the search ended.
    pub(crate) ending: Ending,
    /// The number of steps of the best complete fast run.
    pub(crate) fast_run_steps: Option<u32>,
    /// The number of movements that a wall blocked, or `None` for a protocol client, which reports
    /// only poses.
    pub(crate) crashes: Option<u32>,
    /// True if the mouse correctly reported that the goal is unreachable.
    #[serde(skip)]
    pub(crate) is_rightly_given_up: bool,
    /// True if the mouse has stopped by itself or begun its fast run, so the figures of the whole
    /// search are complete.
    #[serde(skip)]
    pub(crate) is_complete: bool,
    /// The cells that the mouse entered until it stopped or began its fast run.
    #[serde(skip)]
    pub(crate) path: Vec<Cell>,
}

/// How a search ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Ending {
    /// The mouse stopped in the goal or after it had reached the goal.
    #[default]
    Finished,
    /// The mouse stopped by itself without having reached the goal.
    GaveUp,
    /// The mouse failed: its process ended with an error, could not be started or wrote no commands.
    Failed,
    TimeLimit,
    StepLimit,
    /// The search was not run, because the mouse had reached the time limit too often.
    Skipped,
}

impl Ending {
    pub(crate) const ALL: [Self; 6] = [
        Self::Finished,
        Self::GaveUp,
        Self::Failed,
        Self::TimeLimit,
        Self::StepLimit,
        Self::Skipped,
    ];
}
