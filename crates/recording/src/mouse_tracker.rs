//! Computes the message about the mouse in each state of a recording.

use mmsim_maze::{KnownMaze, Maze, MazeSize, Pose, Unknown};
use mmsim_protocol::{Info, State};
use mmsim_solvers::PathBounds;
use mmsim_trial::{TrialStatus, race_optimum};

use crate::context::Context;
use crate::mouse_message::{MouseFigures, MousePhase};
use crate::phases::Phases;
use crate::transition::{Course, Transition};
use crate::update::{Events, StoredUpdate};

/// Computes the figures of the mouse in each state of a recording, one state after another.
pub(crate) struct MouseTracker {
    size: MazeSize,
    course: Course,
    truth: Option<Maze>,
    unexplored: KnownMaze,
    context: Context,
    phases: Phases,
    pose: Option<Pose>,
    /// The number of states so far.
    states: usize,
    /// The quarter turns of the reset before the second run of a trial, which are not turns of the
    /// robot. `None` during the first run.
    reset_turns: Option<u64>,
}

impl MouseTracker {
    /// Starts before the first state. Returns `None` if the description is invalid.
    pub(crate) fn new(info: &Info, maze: Option<&Maze>) -> Option<Self> {
        let size = info.size()?;
        Some(Self {
            size,
            course: Course::from_info(info, maze),
            truth: maze.cloned(),
            unexplored: info.known_maze()?,
            context: Context::new(size),
            phases: Phases::default(),
            pose: None,
            states: 0,
            reset_turns: None,
        })
    }

    /// Adds the next state and the update that precedes it. Returns `None` if the state is invalid.
    pub(crate) fn add(&mut self, update: &[u8], state: &[u8]) -> Option<MouseFigures> {
        let state = State::decode(state, self.size).ok()?;
        let pose = state.pose();
        let events = Events::from_update(update, self.size);
        match self.pose.replace(pose) {
            Some(before) => {
                let transition = self.course.transition_after(events, before, pose);
                self.phases.add(&self.course, self.states, transition, pose);
            }
            None => self.phases.arrive(&self.course, pose),
        }
        if let Ok(update) = StoredUpdate::decode(update, self.size) {
            self.context.apply(Some(pose), &update);
        }
        let index = self.states as u64;
        self.states += 1;

        let status = self.context.notes().strategy().and_then(TrialStatus::from_strategy);
        let known = self.context.known_maze(&state, &self.unexplored, self.truth.as_ref());
        let claimed = self.context.claimed_maze(&state, &self.unexplored);
        let (steps, turns) = match status {
            None => (self.phases.total.steps, self.phases.total.turns),
            // The robot reports one state before the first step and one after each step.
            Some(status) => (index, self.phases.total.turns - self.reset_turns(status)),
        };
        Some(MouseFigures {
            pose,
            phase: status.map_or(MousePhase::Search(self.phases.phase), MousePhase::Trial),
            steps,
            turns,
            visited_cells: claimed.visited().len(),
            distances: distances(&known, status.is_some()),
        })
    }

    /// Returns the quarter turns of the reset before the second run, in a trial with this status.
    fn reset_turns(&mut self, status: TrialStatus) -> u64 {
        if status == TrialStatus::Explore {
            return 0;
        }
        let transition = self.phases.transition;
        *self.reset_turns.get_or_insert_with(|| match transition {
            Some(Transition::Move { turns, .. }) if status == TrialStatus::Race => turns.into(),
            _ => 0,
        })
    }
}

/// Returns the distances from the start to the goal if all unknown walls are open, and if they are
/// closed: in steps or, in a trial, in time steps.
fn distances(known: &KnownMaze, is_trial: bool) -> [Option<u16>; 2] {
    if is_trial {
        let (start, goals) = (known.start().cell, known.goals());
        return [Unknown::Open, Unknown::Closed]
            .map(|unknown| race_optimum(known.walls(unknown), start, goals));
    }
    let PathBounds { optimistic, pessimistic } = PathBounds::new(known);
    [optimistic, pessimistic]
}
