//! The figures of a search.

use mmsim_maze::{Cell, Walls};
use serde::Serialize;

use super::times::Times;
use crate::output::counted;

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
    /// What the mouse can do after the search.
    #[serde(skip)]
    pub(crate) outcome: SearchOutcome,
    /// The times of a vehicle, if one was given.
    #[serde(skip)]
    pub(crate) times: Option<Times>,
}

/// What a mouse knows and where it is when it stops or begins its fast run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SearchOutcome {
    /// The walls that the mouse knows. Unknown walls count as present.
    pub(crate) known_walls: Option<Walls>,
    /// The cell in which the mouse is.
    pub(crate) last_cell: Option<Cell>,
    /// The cells of the first complete fast run, or no cells if the mouse made none.
    pub(crate) route: Vec<Cell>,
    /// The number of quarter turns until the mouse first reached a goal cell, or 0.
    pub(crate) turns_to_goal: u32,
    /// The number of times that the mouse was put back at the start or ran into a wall.
    pub(crate) touches: u32,
    /// The number of these before the mouse first reached a goal cell.
    pub(crate) touches_to_goal: u32,
}

impl Figures {
    /// Returns the reason why the mouse did not stop by itself in the goal, unless it correctly
    /// reported that the goal is unreachable.
    pub(crate) fn failure(&self) -> Option<String> {
        let Self { goal_reached, is_rightly_given_up, error, steps_in_all, .. } = self;
        if *is_rightly_given_up {
            None
        } else if *goal_reached {
            error.as_ref().map(|error| format!("after reaching the goal: {error}"))
        } else {
            let limit = || format!("goal not reached after {}", counted(*steps_in_all, "step"));
            Some(error.clone().unwrap_or_else(limit))
        }
    }
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
