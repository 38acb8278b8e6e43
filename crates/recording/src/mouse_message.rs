//! The message about the mouse in one state, for other tools; see `schemas/mouse.json`.

use mmsim_maze::{Heading, Pose};
use mmsim_trial::TrialStatus;
use serde::Serialize;

use crate::phases::RunPhase;

/// The JSON schema of a [`MouseMessage`].
///
/// Distances without a path are absent and not null, and each property has a single type or numbers
/// with titles, because Foxglove and Lichtblick reject channels whose schema contains other types.
pub(crate) const SCHEMA: &str = include_str!("../schemas/mouse.json");

/// The names of the phases of a search, and of the statuses of a two-run trial, by number.
const PHASES: [&str; 11] = [
    "search run",
    "at goal",
    "return run",
    "at start",
    "fast run",
    "run 1",
    "run 2",
    "scored",
    "out of time",
    "gave up",
    "failed",
];

/// The phase of a search or the status of a two-run trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MousePhase {
    Search(RunPhase),
    Trial(TrialStatus),
}

/// The mouse in one state. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MouseMessage {
    x: u8,
    y: u8,
    heading: char,
    heading_degrees: u16,
    phase: &'static str,
    phase_number: u8,
    steps: u64,
    turns: u64,
    visited_cells: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    optimistic_distance: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pessimistic_distance: Option<u16>,
}

/// The values of a [`MouseMessage`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct MouseFigures {
    pub(crate) pose: Pose,
    pub(crate) phase: MousePhase,
    pub(crate) steps: u64,
    pub(crate) turns: u64,
    pub(crate) visited_cells: usize,
    /// The optimistic and the pessimistic distance from the start to the goal.
    pub(crate) distances: [Option<u16>; 2],
}

impl MousePhase {
    const fn number(self) -> u8 {
        match self {
            Self::Search(RunPhase::Search) => 0,
            Self::Search(RunPhase::AtGoal) => 1,
            Self::Search(RunPhase::Return) => 2,
            Self::Search(RunPhase::AtStart) => 3,
            Self::Search(RunPhase::Fast) => 4,
            Self::Trial(TrialStatus::Explore) => 5,
            Self::Trial(TrialStatus::Race) => 6,
            Self::Trial(TrialStatus::Scored) => 7,
            Self::Trial(TrialStatus::OutOfTime) => 8,
            Self::Trial(TrialStatus::GaveUp) => 9,
            Self::Trial(TrialStatus::Failed) => 10,
        }
    }
}

impl From<MouseFigures> for MouseMessage {
    fn from(figures: MouseFigures) -> Self {
        let MouseFigures { pose: Pose { cell, heading }, phase, steps, turns, .. } = figures;
        let [optimistic_distance, pessimistic_distance] = figures.distances;
        Self {
            x: cell.x,
            y: cell.y,
            heading: heading.letter(),
            heading_degrees: degrees(heading),
            phase: PHASES[usize::from(phase.number())],
            phase_number: phase.number(),
            steps,
            turns,
            visited_cells: figures.visited_cells,
            optimistic_distance,
            pessimistic_distance,
        }
    }
}

/// Returns the degrees of a heading, clockwise from north.
const fn degrees(heading: Heading) -> u16 {
    match heading {
        Heading::North => 0,
        Heading::East => 90,
        Heading::South => 180,
        Heading::West => 270,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_phase_has_its_number_and_name() {
        let names = ["run 1", "run 2", "scored", "out of time", "gave up", "failed"];
        let statuses = names
            .map(|name| TrialStatus::from_strategy(&format!("two-run trial: {name}")).unwrap());
        for status in statuses {
            let number = MousePhase::Trial(status).number();
            assert_eq!(PHASES[usize::from(number)], status.to_string());
        }
        let runs = [
            RunPhase::Search,
            RunPhase::AtGoal,
            RunPhase::Return,
            RunPhase::AtStart,
            RunPhase::Fast,
        ];
        let phases = runs.map(MousePhase::Search).into_iter();
        let phases = phases.chain(statuses.map(MousePhase::Trial));
        assert!(phases.map(MousePhase::number).eq(0..11));
    }
}
