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
    /// The previous state.
    message: Vec<u8>,
    /// The figures of the previous state. Many states change no walls.
    map_figures: Option<MapFigures>,
}

/// The figures that depend on the walls in a state.
#[derive(Clone, Copy)]
struct MapFigures {
    visited_cells: usize,
    distances: [Option<u16>; 2],
    is_trial: bool,
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
            message: Vec::new(),
            map_figures: None,
        })
    }

    /// Adds the next state and the update that precedes it. Returns `None` if the state is invalid.
    pub(crate) fn add(&mut self, update: &[u8], message: &[u8]) -> Option<MouseFigures> {
        let state = State::decode(message, self.size).ok()?;
        let pose = state.pose();
        let events = Events::from_update(update, self.size);
        match self.pose.replace(pose) {
            Some(before) => {
                let transition = self.course.transition_after(events, before, pose);
                self.phases.add(&self.course, self.states, transition, pose);
            }
            None => self.phases.arrive(&self.course, pose),
        }
        let update = StoredUpdate::decode(update, self.size);
        let is_context_new = update.is_ok_and(|update| self.context.apply(Some(pose), &update));
        let before = State::decode(&self.message, self.size).ok().map(|before| before.walls());
        let has_changed = is_context_new || before != Some(state.walls());
        self.message.clear();
        self.message.extend_from_slice(message);
        let index = self.states as u64;
        self.states += 1;

        let status = self.context.notes().strategy().and_then(TrialStatus::from_strategy);
        let is_trial = status.is_some();
        if has_changed || self.map_figures.is_none_or(|figures| figures.is_trial != is_trial) {
            self.map_figures = Some(self.read_map(&state, is_trial));
        }
        let MapFigures { visited_cells, distances, .. } = self.map_figures?;
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
            visited_cells,
            distances,
        })
    }

    /// Computes the figures that depend on the walls.
    fn read_map(&self, state: &State<'_>, is_trial: bool) -> MapFigures {
        let mut map = self.context.claimed_maze(state, &self.unexplored);
        let visited_cells = map.visited().len();
        self.context.forget_unknown(&mut map, self.truth.as_ref());
        MapFigures { visited_cells, distances: distances(&map, is_trial), is_trial }
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

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading};
    use mmsim_protocol::{Annotations, state_bytes};
    use proptest::prelude::*;

    use super::*;
    use crate::block::Block;
    use crate::history::History;
    use crate::update_tracker::UpdateTracker;

    const LISTS: [&[u8]; 5] = [
        b"AR",
        b"AL\x01\0a",
        b"AD\x01\x00E0",
        b"AS\x14two-run trial: run 1",
        b"AS\x14two-run trial: run 2",
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        /// The history computes the figures of each state without those of the previous state.
        #[test]
        fn figures_equal_those_of_the_history(
            states in prop::collection::vec((0u8..4, 0u8..3, 0usize..4, 0u8..32, 0usize..20), 1..300),
        ) {
            let size = MazeSize::new(4, 3).unwrap();
            let mut info = Info::new(
                "open",
                size,
                Pose::new(Cell::new(0, 0), Heading::North),
                &size.central_cells(),
                0,
            );
            info.states = states.len();
            let unexplored = info.known_maze().unwrap();
            let (mut history, mut updates) = (History::new(size), UpdateTracker::default());
            let mut tracker = MouseTracker::new(&info, None).unwrap();
            for (index, &(x, y, heading, walls, list)) in states.iter().enumerate() {
                if let Some(list) = LISTS.get(list) {
                    updates.annotate(Annotations::decode(list, size).unwrap()).unwrap();
                }
                let mut message = vec![b'S', x, y, b"NESW"[heading]];
                message.resize(state_bytes(size), b'C');
                // Often, the walls stay the same.
                message[18..].fill(if walls < 16 { walls } else { 1 });
                message[17] = b'C';
                history.push_with_update(updates.update(), &message).unwrap();
                updates.report();
                let figures = tracker.add(history.newest_update(), &message).unwrap();

                let block = history.block(index / Block::STATES).unwrap().unpack().unwrap();
                let (phases, context) = (block.phases(index).unwrap(), block.context(index).unwrap());
                let state = State::decode(&message, size).unwrap();
                let status = context.notes().strategy().and_then(TrialStatus::from_strategy);
                let known = context.known_maze(&state, &unexplored, None);
                let visited = context.claimed_maze(&state, &unexplored).visited().len();
                prop_assert_eq!(figures.pose, state.pose());
                prop_assert_eq!(figures.visited_cells, visited);
                prop_assert_eq!(figures.distances, distances(&known, status.is_some()));
                match (figures.phase, status) {
                    (MousePhase::Trial(found), Some(status)) => {
                        prop_assert_eq!((found, figures.steps), (status, index as u64));
                        prop_assert!(figures.turns <= phases.total.turns);
                    }
                    (MousePhase::Search(found), None) => {
                        prop_assert_eq!(found, phases.phase);
                        prop_assert_eq!(figures.steps, phases.total.steps);
                        prop_assert_eq!(figures.turns, phases.total.turns);
                    }
                    (found, status) => prop_assert!(false, "{found:?}, expected {status:?}"),
                }
            }
        }
    }
}
