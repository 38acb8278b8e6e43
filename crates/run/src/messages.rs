//! Messages about the mouse in each state of a recording, for other tools; see docs/recordings.md.

use std::io;

use mmsim_maze::{KnownMaze, Maze, Pose};
use mmsim_protocol::{Info, State};
use mmsim_recording::{MESSAGE_TOPICS, MessageChannel, PutMessage, ScannedState, StateMessages};
use mmsim_trial::TrialStatus;
use serde::Serialize;

use crate::movement::MovementRules;
use crate::phases::{Phases, RunPhase};
use crate::scene::{POSE_SCHEMA, PoseMessage, SCENE_SCHEMA, maze_message};
use crate::state_figures::{MapFigures, reset_turns, trial_status};

/// The channels, in the order of their indices. Recordings without a maze lack the last one.
const CHANNELS: [MessageChannel; 3] = [
    MessageChannel { topic: MESSAGE_TOPICS[0], name: "mmsim.Mouse", schema: SCHEMA },
    MessageChannel { topic: MESSAGE_TOPICS[1], name: POSE_SCHEMA[0], schema: POSE_SCHEMA[1] },
    MessageChannel { topic: MESSAGE_TOPICS[2], name: SCENE_SCHEMA[0], schema: SCENE_SCHEMA[1] },
];
const MOUSE: usize = 0;
const POSE: usize = 1;
const SCENE: usize = 2;

/// The JSON schema of a [`MouseMessage`].
///
/// Distances without a path are absent and not null, and each property has a single type or numbers
/// with titles, because Foxglove and Lichtblick reject channels whose schema contains other types.
pub(crate) const SCHEMA: &str = include_str!("../schemas/mouse.json");

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
        let (phase_number, phase) = numbered_phase(phase, status);
        let Pose { cell, heading } = scanned.pose;
        Some(MouseMessage {
            x: cell.x,
            y: cell.y,
            heading: heading.letter(),
            // Clockwise from north.
            heading_degrees: 90 * heading as u16,
            phase,
            phase_number,
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

/// Returns the number and the name of a phase or, in a two-run trial, of its status. The numbers of
/// the statuses follow those of the phases, in the order of [`TrialStatus`].
fn numbered_phase(phase: RunPhase, status: Option<TrialStatus>) -> (u8, &'static str) {
    match status {
        None => (phase as u8, phase.key()),
        Some(status) => (RunPhase::Fast as u8 + 1 + status as u8, status.key()),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_phase_has_its_number_and_name() {
        let runs = [
            RunPhase::Search,
            RunPhase::AtGoal,
            RunPhase::Return,
            RunPhase::AtStart,
            RunPhase::Fast,
        ];
        let runs = runs.into_iter().map(|phase| numbered_phase(phase, None));
        let phases = ["search_run", "at_goal", "return_run", "at_start", "fast_run"];
        let names = ["run_1", "run_2", "scored", "out_of_time", "gave_up", "failed"];
        let statuses = names.map(|name| {
            TrialStatus::from_strategy(&format!("two-run trial: {}", name.replace('_', " ")))
                .unwrap()
        });
        let statuses =
            statuses.into_iter().map(|status| numbered_phase(RunPhase::Fast, Some(status)));
        assert!(runs.chain(statuses).eq((0..).zip(phases.into_iter().chain(names))));
    }
}
