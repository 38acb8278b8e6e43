//! The events of a run: the states in which the mouse reaches the goal, begins a run and so on.

use std::collections::BTreeMap;

use mmsim_maze::{KnownMaze, Maze, Walls};
use mmsim_protocol::State;
use mmsim_recording::{ScannedState, States};
use mmsim_trial::TrialStatus;
use serde::Serialize;

use crate::movement::{MovementRules, Transition};
use crate::paths::bounds;
use crate::phases::{Phases, RunPhase};
use crate::state_figures::trial_status;

/// The maximum number of listed states for each kind of event.
const MAX_LISTED: usize = 2048;

/// A kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A search run or a fast run reaches the goal. In a two-run trial, only the first time.
    Goal,
    /// A return run begins: the mouse has moved for the first time.
    Return,
    /// A fast run begins: the mouse has left the start cell.
    FastRun,
    /// The mouse is put back at the start.
    Reset,
    /// The mouse appears in another cell.
    Jump,
    /// The client claims a wall incorrectly that it did not claim incorrectly in the previous state.
    WrongWall,
    /// The shortest path, or the fastest race of a trial, is proven for the first time.
    Solved,
    /// The first run of a trial begins.
    #[serde(rename = "run_1")]
    Run1,
    /// The second run of a trial begins.
    #[serde(rename = "run_2")]
    Run2,
    /// A trial ends with a score.
    Scored,
    /// A trial ends without a score.
    Unscored,
    /// Log lines precede the state.
    Log,
}

/// The events of one kind.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct EventList {
    kind: EventKind,
    /// The number of events.
    count: usize,
    /// The list contains the first event and then each event with this distance from the previous
    /// one: 1, or a power of two if there are too many events.
    every: usize,
    /// The indices of the states.
    states: Vec<usize>,
}

/// The events of a run up to a state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunEvents {
    /// The number of states whose events are listed.
    states: usize,
    /// The kinds that have events.
    events: Vec<EventList>,
}

/// Finds the events of a growing run. See [`EventKind`].
#[derive(Debug)]
pub struct EventFinder {
    rules: MovementRules,
    /// The map of the mouse before the first state.
    unexplored: KnownMaze,
    truth: Option<Maze>,
    phases: Phases,
    /// The kinds that have events, in the order of [`EventKind`].
    lists: BTreeMap<EventKind, EventList>,
    is_solved: bool,
    /// The newest state.
    previous: Option<PreviousState>,
}

/// What the next state is compared with.
#[derive(Debug)]
struct PreviousState {
    message: Vec<u8>,
    status: Option<TrialStatus>,
    /// The walls that the client knows.
    known: KnownMaze,
    /// Contains each wall that the client claims incorrectly.
    wrong: Walls,
}

impl EventList {
    const fn new(kind: EventKind) -> Self {
        Self { kind, count: 0, every: 1, states: Vec::new() }
    }

    fn push(&mut self, state: usize) {
        if self.count.is_multiple_of(self.every) {
            self.states.push(state);
        }
        self.count += 1;
        if self.states.len() > MAX_LISTED {
            self.states = self.states.iter().copied().step_by(2).collect();
            self.every *= 2;
        }
    }
}

impl EventFinder {
    /// Starts before the first state of a run. `unexplored` is the map of the mouse before the first
    /// state, and `truth` the true maze, if it is known.
    pub fn new(unexplored: &KnownMaze, truth: Option<&Maze>) -> Self {
        Self {
            rules: MovementRules::from_map(unexplored, truth),
            unexplored: unexplored.clone(),
            truth: truth.cloned(),
            phases: Phases::default(),
            lists: BTreeMap::new(),
            is_solved: false,
            previous: None,
        }
    }

    /// Returns the number of states that have been read.
    pub const fn states(&self) -> usize {
        self.phases.states as usize
    }

    /// Returns the events that have been found.
    pub fn events(&self) -> RunEvents {
        RunEvents { states: self.states(), events: self.lists.values().cloned().collect() }
    }

    /// Reads the new states of a block. The block contains the state after the last one that has been
    /// read.
    ///
    /// # Errors
    /// Returns the index of a state that cannot be decoded.
    pub fn extend(&mut self, block: &States) -> Result<(), usize> {
        let before = self.states();
        let mut scan = block.scan().ok_or(before)?;
        while let Some(state) = scan.advance() {
            if state.index == self.states() {
                self.add(&state).ok_or(state.index)?;
            }
        }
        if self.states() == before { Err(before) } else { Ok(()) }
    }

    fn push(&mut self, kind: EventKind, state: usize) {
        self.lists.entry(kind).or_insert_with(|| EventList::new(kind)).push(state);
    }

    /// Adds the events of the next state. Returns `None` if the state cannot be decoded.
    fn add(&mut self, scanned: &ScannedState<'_>) -> Option<()> {
        let ScannedState { index, message, context, is_context_new, .. } = *scanned;
        let size = self.unexplored.size();
        let state = State::decode(message, size).ok()?;
        let phases_before = self.phases;
        self.phases.add(&self.rules, scanned.pose, scanned.has_restart);
        let previous = self.previous.take();
        let before = previous.as_ref();
        let status = match before {
            Some(before) if !is_context_new => before.status,
            _ => trial_status(context.notes()),
        };
        let phase_events = phase_events(&phases_before, &self.phases, status);
        let has_new_status = status != before.and_then(|before| before.status);
        let status_event = status.filter(|_| has_new_status).map(status_event);
        let log = (scanned.log_lines > 0).then_some(EventKind::Log);
        for kind in phase_events.into_iter().flatten().chain(status_event).chain(log) {
            self.push(kind, index);
        }
        let has_same_walls = |before: &PreviousState| {
            let walls = State::decode(&before.message, size).map(|state| state.walls());
            !is_context_new && walls == Ok(state.walls())
        };
        let (known, wrong) = match previous {
            // Most states change no walls.
            Some(before) if has_same_walls(&before) => (before.known, before.wrong),
            before => {
                let truth = self.truth.as_ref();
                let known = context.known_maze(&state, &self.unexplored, truth);
                let claimed = context.claimed_maze(&state, &self.unexplored);
                let (mut wrong, mut is_new) = (Walls::open(size), false);
                for (cell, heading) in
                    truth.iter().flat_map(|maze| claimed.wrong_walls(maze.walls()))
                {
                    wrong.set(cell, heading, true);
                    is_new |= before.as_ref().is_none_or(|it| !it.wrong.has(cell, heading));
                }
                if is_new {
                    self.push(EventKind::WrongWall, index);
                }
                if !self.is_solved {
                    self.is_solved = bounds(&known, status.is_some()).is_proven();
                    if self.is_solved {
                        self.push(EventKind::Solved, index);
                    }
                }
                (known, wrong)
            }
        };
        let message = message.to_vec();
        self.previous = Some(PreviousState { message, status, known, wrong });
        Some(())
    }
}

/// Returns the events of a state that follow from its phases and those of the previous state.
fn phase_events(
    before: &Phases,
    now: &Phases,
    status: Option<TrialStatus>,
) -> [Option<EventKind>; 4] {
    let is = |kind, condition: bool| condition.then_some(kind);
    let jump = is(EventKind::Jump, now.transition == Some(Transition::Jump));
    let phase_before = (before.states > 0).then_some(before.phase);
    // A goal after a jump does not count.
    let is_at_goal = now.phase == RunPhase::AtGoal
        && phase_before != Some(RunPhase::AtGoal)
        && now.first_jump.is_none();
    if let Some(status) = status {
        // The runs of a trial take the place of the phases.
        let is_first = phase_before.is_none_or(|phase| phase == RunPhase::Search);
        let is_first_goal = status == TrialStatus::Explore && is_at_goal && is_first;
        return [is(EventKind::Goal, is_first_goal), jump, None, None];
    }
    let is_restart = now.transition == Some(Transition::Restart);
    let has_left_goal = phase_before == Some(RunPhase::AtGoal) && now.phase != RunPhase::AtGoal;
    let is_fast_run = now.fast_runs > before.fast_runs;
    [
        is(EventKind::Goal, is_at_goal),
        is(EventKind::Return, has_left_goal && !is_restart),
        is(EventKind::FastRun, is_fast_run),
        is(EventKind::Reset, is_restart).or(jump),
    ]
}

const fn status_event(status: TrialStatus) -> EventKind {
    match status {
        TrialStatus::Explore => EventKind::Run1,
        TrialStatus::Race => EventKind::Run2,
        TrialStatus::Scored => EventKind::Scored,
        TrialStatus::OutOfTime | TrialStatus::GaveUp | TrialStatus::Failed => EventKind::Unscored,
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Maze, Pose, WallState};
    use mmsim_protocol::{Annotations, MapState, Order, state_bytes};
    use mmsim_recording::{Block, History, UpdateTracker};
    use proptest::prelude::*;

    use super::*;

    const MAZE: &str = "\
o---o---o---o
| G     |   |
o   o---o   o
|           |
o   o   o   o
| S |       |
o---o---o---o
";

    /// All kinds of events, in the order in which they are listed.
    const KINDS: [EventKind; 12] = [
        EventKind::Goal,
        EventKind::Return,
        EventKind::FastRun,
        EventKind::Reset,
        EventKind::Jump,
        EventKind::WrongWall,
        EventKind::Solved,
        EventKind::Run1,
        EventKind::Run2,
        EventKind::Scored,
        EventKind::Unscored,
        EventKind::Log,
    ];

    fn finder() -> EventFinder {
        let maze = MAZE.parse().unwrap();
        EventFinder::new(&KnownMaze::unexplored(&maze), Some(&maze))
    }

    /// Finds the events by looking at each state and the state before.
    fn naive(maze: &Maze, history: &History, count: usize) -> RunEvents {
        let mut lists = KINDS.map(EventList::new);
        let mut is_solved = false;
        let (unexplored, mut so_far) = (KnownMaze::unexplored(maze), Phases::default());
        let rules = MovementRules::from_maze(maze);
        let blocks = (0..count).step_by(Block::STATES);
        let blocks = blocks.map(|at| history.block(at / Block::STATES).unwrap().unpack().unwrap());
        let phases: Vec<Phases> = blocks
            .flat_map(|block| block.poses(0).collect::<Vec<_>>())
            .map(|(pose, has_restart)| {
                so_far.add(&rules, pose.unwrap(), has_restart);
                so_far
            })
            .collect();
        let view = |index: usize| {
            let block = history.block(index / Block::STATES).and_then(Block::unpack).unwrap();
            let state = State::decode(block.get(index).unwrap(), maze.size()).unwrap();
            let context = block.context(index).unwrap();
            let claimed = context.claimed_maze(&state, &unexplored);
            let wrong: Vec<_> = claimed.wrong_walls(maze.walls()).collect();
            let known = context.known_maze(&state, &unexplored, Some(maze));
            let status = trial_status(context.notes());
            let is_proven = bounds(&known, status.is_some()).is_proven();
            (phases[index], wrong, is_proven, status)
        };
        for index in 0..count {
            let (phases, wrong, is_proven, status) = view(index);
            let before = index.checked_sub(1).map(view);
            let old_phase = before.as_ref().map(|before| before.0.phase);
            let old_wrong = before.as_ref().map_or(&[][..], |before| &before.1);
            let lines = history.log(index, usize::MAX, |_| true);
            let (is_trial, transition) = (status.is_some(), phases.transition);
            let has_status = |kind: TrialStatus| {
                status == Some(kind) && before.as_ref().and_then(|before| before.3) != status
            };
            let enters_goal = phases.phase == RunPhase::AtGoal
                && old_phase != Some(RunPhase::AtGoal)
                && phases.first_jump.is_none();
            for list in &mut lists {
                let happens = match list.kind {
                    EventKind::Goal if is_trial => {
                        enters_goal
                            && status == Some(TrialStatus::Explore)
                            && matches!(old_phase, None | Some(RunPhase::Search))
                    }
                    EventKind::Goal => enters_goal,
                    EventKind::Return => {
                        !is_trial
                            && phases.return_run
                                != before.as_ref().map_or(phases, |it| it.0).return_run
                            && old_phase == Some(RunPhase::AtGoal)
                    }
                    EventKind::FastRun => {
                        !is_trial
                            && phases.fast_runs != before.as_ref().map_or(0, |it| it.0.fast_runs)
                    }
                    EventKind::Reset => !is_trial && transition == Some(Transition::Restart),
                    EventKind::Jump => transition == Some(Transition::Jump),
                    EventKind::WrongWall => wrong.iter().any(|wall| !old_wrong.contains(wall)),
                    EventKind::Solved => is_proven && !is_solved,
                    EventKind::Run1 => has_status(TrialStatus::Explore),
                    EventKind::Run2 => has_status(TrialStatus::Race),
                    EventKind::Scored => has_status(TrialStatus::Scored),
                    EventKind::Unscored => has_status(TrialStatus::GaveUp),
                    EventKind::Log => lines.iter().any(|line| line.state == index),
                };
                if happens {
                    list.push(index);
                }
            }
            is_solved |= is_proven;
        }
        let events = lists.into_iter().filter(|list| list.count > 0).collect();
        RunEvents { states: count, events }
    }

    /// Annotations that a client may send before a state.
    const LISTS: [&[u8]; 9] = [
        b"AR",
        b"AL\x01\0aL\0\0",
        b"AT\x01\x01\x01x",
        b"AD\x01\x01N1",
        b"AD\x01\x01E0",
        b"AS\x14two-run trial: run 1",
        b"AS\x14two-run trial: run 2",
        b"AS\x15two-run trial: scored",
        b"AS\x16two-run trial: gave up",
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn extending_equals_looking_at_each_state(
            steps in prop::collection::vec((0u8..16, 0usize..4, 0usize..40, 0u8..9), 1..320),
            pauses in prop::collection::vec(1usize..80, 1..8),
            reads in any::<bool>(),
        ) {
            let maze: Maze = MAZE.parse().unwrap();
            let mut history = History::new(maze.size());
            let (mut updates, mut pose) = (UpdateTracker::default(), maze.start());
            let (mut seen, mut finder) = (KnownMaze::unexplored(&maze), finder());
            let mut pauses = pauses.into_iter().cycle();
            let mut next = pauses.next().unwrap();
            for (index, &(kind, heading, list, wall)) in steps.iter().enumerate() {
                let heading = Heading::ALL[heading];
                pose = match kind {
                    0 => maze.start(),
                    1 => Pose::new(Cell::new(wall % 3, wall / 3), heading),
                    _ if maze.walls().has(pose.cell, heading) => Pose::new(pose.cell, heading),
                    _ => Pose::new(pose.cell.neighbour(heading).unwrap(), heading),
                };
                if reads {
                    updates.read(pose);
                }
                if let Some(list) = LISTS.get(list) {
                    updates.annotate(Annotations::decode(list, maze.size()).unwrap()).unwrap();
                }
                let _ = seen.observe(pose, maze.walls().around(pose));
                if kind == 2 {
                    seen.set_wall(Cell::new(wall % 3, wall / 3), heading, WallState::Present);
                }
                let mut message = vec![0; state_bytes(maze.size())];
                let state = MapState::new(pose, &seen, |_| 7, Order::C);
                state.encode(&mut message).unwrap();
                history.push_with_update(updates.update(), &message).unwrap();
                updates.report();
                next -= 1;
                if next == 0 || index + 1 == steps.len() {
                    next = pauses.next().unwrap();
                    while finder.states() <= index {
                        let block = finder.states() / Block::STATES;
                        let block = history.block(block).and_then(Block::unpack).unwrap();
                        finder.extend(&block).unwrap();
                    }
                    prop_assert_eq!(finder.events(), naive(&maze, &history, index + 1));
                }
            }
        }

        #[test]
        fn long_lists_are_thinned_evenly(count in 0usize..20_000) {
            let mut list = EventList::new(EventKind::Reset);
            (0..count).for_each(|number| list.push(3 * number + 1));
            prop_assert!(list.states.len() <= MAX_LISTED);
            prop_assert!(list.every == 1 || list.states.len() > MAX_LISTED / 2);
            let expected: Vec<_> = (0..count).step_by(list.every).map(|number| 3 * number + 1).collect();
            prop_assert_eq!((list.count, &list.states), (count, &expected));
        }
    }

    #[test]
    fn a_block_without_new_states_is_an_error() {
        let mut history = History::new(MAZE.parse::<Maze>().unwrap().size());
        history.push(b"S\0\0NC\0\0\0\0\0\0\0\0\0C\0\0\0\0\0\0\0\0\0").unwrap();
        let block = history.block(0).and_then(Block::unpack).unwrap();
        let mut finder = finder();
        finder.extend(&block).unwrap();
        assert_eq!(finder.states(), 1);
        assert!(finder.extend(&block).is_err());
    }
}
