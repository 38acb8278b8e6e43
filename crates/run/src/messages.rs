//! Messages about the mouse in each state of a recording, for other tools; see docs/recordings.md.

use std::io;

use mmsim_maze::{Heading, KnownMaze, Maze, Pose};
use mmsim_protocol::{Info, State};
use mmsim_recording::{MessageChannel, PutMessage, ScannedState, StateMessages};
use mmsim_trial::TrialStatus;
use serde::Serialize;

use crate::movement::MovementRules;
use crate::phases::{Phases, RunPhase};
use crate::scene::{POSE_SCHEMA, PoseMessage, SCENE_SCHEMA, maze_message};
use crate::state_figures::{MapFigures, reset_turns, trial_status};

/// The channels, in the order of their indices. Recordings without a maze lack the last one.
const CHANNELS: [MessageChannel; 3] = [
    MessageChannel { topic: "/mouse", name: "mmsim.Mouse", schema: SCHEMA },
    MessageChannel { topic: "/pose", name: POSE_SCHEMA[0], schema: POSE_SCHEMA[1] },
    MessageChannel { topic: "/scene", name: SCENE_SCHEMA[0], schema: SCENE_SCHEMA[1] },
];
const MOUSE: usize = 0;
const POSE: usize = 1;
const SCENE: usize = 2;

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

/// Returns the messages about a recording for
/// [`Recorder::with_messages`](mmsim_recording::Recorder::with_messages): the figures of the mouse and
/// its pose in each state, and a picture of the maze. Returns `None` if the description is invalid.
pub fn messages(info: &Info, maze: Option<&Maze>) -> Option<Box<dyn StateMessages>> {
    let unexplored = info.known_maze()?;
    Some(Box::new(RunMessages {
        rules: MovementRules::from_map(&unexplored, maze),
        truth: maze.cloned(),
        unexplored,
        phases: Phases::default(),
        reset_turns: None,
        message: Vec::new(),
        map: None,
    }))
}

/// The messages about a recording, one state after another.
struct RunMessages {
    rules: MovementRules,
    truth: Option<Maze>,
    unexplored: KnownMaze,
    phases: Phases,
    /// The quarter turns of the reset before the second run of a trial, which are not turns of the
    /// robot. `None` during the first run.
    reset_turns: Option<u64>,
    /// The previous state.
    message: Vec<u8>,
    /// The figures that depend on the map in the previous state, and whether it belongs to a trial.
    /// Many states change no walls.
    map: Option<(MapFigures, bool)>,
}

impl StateMessages for RunMessages {
    fn channels(&self) -> Vec<MessageChannel> {
        let count = if self.truth.is_some() { CHANNELS.len() } else { SCENE };
        CHANNELS[..count].to_vec()
    }

    fn begin(&mut self, time: u64, put: PutMessage<'_>) -> io::Result<()> {
        match &self.truth {
            Some(maze) => put(SCENE, &serde_json::to_vec(&maze_message(maze, time))?),
            None => Ok(()),
        }
    }

    fn add(&mut self, state: &ScannedState<'_>, time: u64, put: PutMessage<'_>) -> io::Result<()> {
        let Some(message) = self.mouse_message(state) else { return Ok(()) };
        put(MOUSE, &serde_json::to_vec(&message)?)?;
        put(POSE, &serde_json::to_vec(&PoseMessage::new(state.pose, time))?)
    }
}

impl RunMessages {
    /// Returns the message about the next state, or `None` if the state is invalid.
    fn mouse_message(&mut self, scanned: &ScannedState<'_>) -> Option<MouseMessage> {
        let size = self.unexplored.size();
        let state = State::decode(scanned.message, size).ok()?;
        self.phases.add(&self.rules, scanned.pose, scanned.has_restart);
        let status = trial_status(scanned.context.notes());
        let walls = |message| State::decode(message, size).ok().map(|state| state.walls());
        let is_new = scanned.is_context_new || walls(&self.message) != Some(state.walls());
        let known = self.map.filter(|(_, is_trial)| !is_new && *is_trial == status.is_some());
        let (map, _) = *self.map.insert(known.unwrap_or_else(|| {
            let mut map = scanned.context.claimed_maze(&state, &self.unexplored);
            let visited = map.visited().len();
            scanned.context.forget_unknown(&mut map, self.truth.as_ref());
            (MapFigures::new(visited, &map, status.is_some()), status.is_some())
        }));
        self.message.clear();
        self.message.extend_from_slice(scanned.message);
        let Phases { total, states, phase, .. } = self.phases;
        let (steps, turns) = match status {
            None => (total.steps, total.turns),
            // The robot reports one state before the first step and one after each step.
            Some(status) => (u64::from(states - 1), total.turns - self.reset_turns(status)),
        };
        let phase = status.map_or(MousePhase::Search(phase), MousePhase::Trial);
        let Pose { cell, heading } = scanned.pose;
        Some(MouseMessage {
            x: cell.x,
            y: cell.y,
            heading: heading.letter(),
            heading_degrees: degrees(heading),
            phase: PHASES[usize::from(phase.number())],
            phase_number: phase.number(),
            steps,
            turns,
            visited_cells: map.visited_cells,
            optimistic_distance: map.optimistic_distance,
            pessimistic_distance: map.pessimistic_distance,
        })
    }

    /// Returns the quarter turns of the reset before the second run, in a trial with this status.
    fn reset_turns(&mut self, status: TrialStatus) -> u64 {
        if status == TrialStatus::Explore {
            return 0;
        }
        let here = if status == TrialStatus::Race { reset_turns(&self.phases) } else { 0 };
        *self.reset_turns.get_or_insert(here)
    }
}

/// The phase of a search or the status of a two-run trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MousePhase {
    Search(RunPhase),
    Trial(TrialStatus),
}

/// The mouse in one state. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct MouseMessage {
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
