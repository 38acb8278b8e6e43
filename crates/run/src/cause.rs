//! Why a mouse has not reached the goal: one cause, decided from the states of its run and from how the
//! run ended.

use std::fmt;

use mmsim_maze::{Cell, Heading, Maze, Pose, Wall, counted};
use mmsim_solvers::steps_between;
use serde::{Deserialize, Serialize, Serializer};

use crate::paths::shortest_path;
use crate::verdict::Ending;

/// The start of the log line with the [`EndFacts`] of a run, as JSON. The line is not one of the mouse.
pub const END_FACTS: &str = "run end: ";

/// The number of movements in a row that a wall must block, and of periods that a loop must have.
const REPETITIONS: usize = 3;

/// The cause of a failure. If several apply, the first one in this order is the cause, because it
/// explains the others. States are numbered from 0. The field names are JSON keys.
///
/// ```
/// use mmsim_run::{Cause, Exit, Messages};
/// let cause = Cause::Exited { exit: Exit::Signal(11), messages: Some(Messages::Commands(7)) };
/// assert_eq!(cause.to_string(), "killed by signal 11 after command 7");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Cause {
    /// The process of the mouse ended with an error.
    Exited {
        /// How it ended.
        #[serde(flatten)]
        exit: Exit,
        /// What the mouse had sent, or `None` if it had sent nothing.
        #[serde(flatten)]
        messages: Option<Messages>,
    },
    /// The mouse waited until the end after a message that was refused.
    Refused {
        /// What the mouse had sent, including a refused request but no invalid line.
        #[serde(flatten)]
        messages: Option<Messages>,
    },
    /// A wall blocked all movements since the last pose, at least three.
    Blocked {
        /// The cell of the mouse.
        #[serde(serialize_with = "coordinates")]
        cell: Cell,
        /// The number of movements.
        movements: u32,
        /// The state in which the mouse got there.
        state: u32,
    },
    /// The mouse reported at most one pose, but it sent something.
    NeverMoved,
    /// The mouse believed in a wall that is not there, on the shortest path from the start, beside a cell
    /// in which it was. If such walls cut off the goal, one of them is on this path.
    FalseWall {
        /// The cell closer to the start.
        #[serde(serialize_with = "coordinates")]
        cell: Cell,
        /// The side of the wall.
        #[serde(serialize_with = "letter")]
        heading: Heading,
        /// The state since which the mouse believed in the wall.
        state: u32,
    },
    /// The poses repeated a cycle until the end, at least three times.
    Loop {
        /// The number of cells.
        cells: usize,
        /// The cell in which the loop began.
        #[serde(serialize_with = "coordinates")]
        from: Cell,
        /// The cell after half a period.
        #[serde(serialize_with = "coordinates")]
        to: Cell,
        /// The first state of the loop.
        state: u32,
    },
    /// The mouse stopped by itself although a path leads to the goal.
    GaveUp {
        /// The cell of the mouse.
        #[serde(serialize_with = "coordinates")]
        cell: Cell,
        /// The state in which the mouse got there.
        state: u32,
        /// The length of the shortest path to the goal in steps.
        steps: u16,
    },
}

impl Cause {
    /// Returns the state that shows the cause, or `None` if no state does.
    pub const fn state(&self) -> Option<u32> {
        match *self {
            Self::Blocked { state, .. }
            | Self::FalseWall { state, .. }
            | Self::Loop { state, .. }
            | Self::GaveUp { state, .. } => Some(state),
            Self::Exited { .. } | Self::Refused { .. } | Self::NeverMoved => None,
        }
    }

    /// Adds the cause to the words about how the run ended.
    pub(crate) fn explain(&self, error: Option<String>) -> String {
        match (self, error) {
            (_, None) => self.to_string(),
            (Self::Exited { exit, .. }, Some(error)) => {
                format!("{self}{}", error.strip_prefix(&exit.to_string()).unwrap_or_default())
            }
            (_, Some(error)) => format!("{error}: {self}"),
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exited { exit, messages: Some(messages) } => write!(f, "{exit} after {messages}"),
            Self::Exited { exit, .. } => exit.fmt(f),
            Self::Refused { messages: Some(messages @ Messages::Requests(_)) } => {
                write!(f, "waits for a reply to {messages}, which was refused")
            }
            Self::Refused { messages: Some(messages) } => {
                write!(f, "waits for a reply to the invalid line after {messages}")
            }
            Self::Refused { .. } => f.write_str("waits for a reply to an invalid line"),
            Self::Blocked { cell, movements, state } => {
                write!(f, "runs into a wall {movements} times, in {cell} at state {state}")
            }
            Self::NeverMoved => f.write_str("never moved"),
            Self::FalseWall { cell, heading, state } => write!(
                f,
                "believes in a wall {heading} of {cell} that is not there, since state {state}"
            ),
            Self::Loop { cells: 1, from, state, .. } => {
                write!(f, "turns without leaving {from}, since state {state}")
            }
            Self::Loop { cells, from, to, state } => {
                let cells = counted(*cells, "cell");
                write!(f, "loops over {cells}, {from} to {to}, since state {state}")
            }
            Self::GaveUp { cell, state, steps } => {
                let steps = counted(*steps, "step");
                write!(f, "gave up in {cell} at state {state}, {steps} from the goal")
            }
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn coordinates<S: Serializer>(cell: &Cell, serializer: S) -> Result<S::Ok, S::Error> {
    [cell.x, cell.y].serialize(serializer)
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn letter<S: Serializer>(heading: &Heading, serializer: S) -> Result<S::Ok, S::Error> {
    heading.letter().serialize(serializer)
}

/// How a process ended that failed. The names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Exit {
    /// It exited with this code.
    ExitCode(i32),
    /// This signal killed it.
    Signal(i32),
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ExitCode(code) => write!(f, "exited with code {code}"),
            Self::Signal(signal) => write!(f, "killed by signal {signal}"),
        }
    }
}

/// The number of messages that a mouse has sent. The names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Messages {
    /// Valid commands of mms.
    Commands(u64),
    /// Requests.
    Requests(u64),
}

impl fmt::Display for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Commands(count) => write!(f, "command {count}"),
            Self::Requests(count) => write!(f, "request {count}"),
        }
    }
}

/// How a run ended, apart from its states. The field names are JSON keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EndFacts {
    /// How the run ended: [`Finished`](Ending::Finished) if the mouse stopped by itself.
    pub ending: Ending,
    /// How the process of the mouse failed, if it did.
    pub exit: Option<Exit>,
    /// What the mouse sent, or `None` if it sent nothing.
    pub messages: Option<Messages>,
    /// True if the last request was refused, or the last line was invalid.
    pub is_refused: bool,
    /// The number of movements that a wall has blocked since the last pose, if no judge has seen them.
    pub blocked: u32,
}

impl EndFacts {
    /// Returns true if a log line has facts, so that it is not a line of the mouse.
    #[cfg(feature = "recording")]
    pub fn is_log_line(line: &str) -> bool {
        Self::from_log_line(line).is_some()
    }

    /// Reads the facts from a log line, if it has facts.
    #[cfg(feature = "recording")]
    pub fn from_log_line(line: &str) -> Option<Self> {
        serde_json::from_str(line.strip_prefix(END_FACTS)?).ok()
    }

    /// Returns the log line for [`from_log_line`](Self::from_log_line).
    #[cfg(feature = "recording")]
    pub fn to_log_line(&self) -> String {
        format!("{END_FACTS}{}", serde_json::to_string(self).unwrap_or_default())
    }
}

/// What the states of a run show about the cause of a failure.
#[derive(Clone, Debug)]
pub(crate) struct Evidence {
    /// Each new pose, and the number of its state. A mouse may report a pose several times.
    poses: Vec<(Pose, u32)>,
    states: u32,
    /// The number of movements that a wall has blocked since the last state.
    blocked: u32,
    /// The steps of the shortest path from the start to the goal, and the state since which the mouse
    /// believes that a wall blocks the step.
    path: Vec<(Cell, Heading, Option<u32>)>,
}

impl Evidence {
    pub(crate) fn new(maze: &Maze) -> Self {
        let cells = shortest_path(maze, false);
        let steps = cells.windows(2).filter_map(|pair| {
            let heading = Heading::ALL
                .into_iter()
                .find(|&heading| pair[0].neighbour(heading) == Some(pair[1]))?;
            Some((pair[0], heading, None))
        });
        Self { poses: Vec::new(), states: 0, blocked: 0, path: steps.collect() }
    }

    /// Returns what the poses in all states show.
    pub(crate) fn from_poses(maze: &Maze, poses: &[Pose]) -> Self {
        let mut evidence = Self::new(maze);
        for &pose in poses {
            evidence.add(pose);
        }
        evidence
    }

    /// Adds the pose of the next state.
    pub(crate) fn add(&mut self, pose: Pose) {
        if self.poses.last().is_none_or(|&(last, _)| last != pose) {
            self.poses.push((pose, self.states));
        }
        self.states = self.states.saturating_add(1);
        self.blocked = 0;
    }

    /// Notes that a wall has blocked the mouse.
    pub(crate) const fn block(&mut self) {
        self.blocked = self.blocked.saturating_add(1);
    }

    /// Returns true if there are no states.
    pub(crate) const fn is_empty(&self) -> bool {
        self.states == 0
    }

    /// Forgets all states, as a reset does.
    pub(crate) fn clear(&mut self) {
        self.poses.clear();
        self.states = 0;
        self.blocked = 0;
        self.path.iter_mut().for_each(|(.., since)| *since = None);
    }

    /// Notes in which walls the mouse believes in the newest state or, if they are not shown yet, in the
    /// next one.
    pub(crate) fn believe(&mut self, is_shown: bool, has_wall: impl Fn(Cell, Heading) -> bool) {
        let state = self.states.saturating_sub(u32::from(is_shown));
        for (cell, heading, since) in &mut self.path {
            *since = has_wall(*cell, *heading).then_some(since.unwrap_or(state));
        }
    }

    /// Returns the cause of the failure of a mouse that has neither reached the goal nor jumped.
    pub(crate) fn cause(&self, maze: &Maze, facts: &EndFacts) -> Option<Cause> {
        let EndFacts { ending, exit, messages, is_refused, blocked } = *facts;
        if let Some(exit) = exit {
            // A mouse that gives up in a loop may exit with an error, which does not say why.
            let cycle = self.cycle().filter(|_| matches!(exit, Exit::ExitCode(_)));
            return cycle.or(Some(Cause::Exited { exit, messages }));
        }
        if matches!(ending, Ending::Failed | Ending::Skipped) {
            return None;
        }
        let is_waiting = matches!(ending, Ending::TimeLimit | Ending::Stopped);
        // A mouse that loops is not waiting.
        if is_refused && is_waiting && self.cycle().is_none() {
            return Some(Cause::Refused { messages });
        }
        let (last, blocked) = (self.poses.last().copied(), blocked.max(self.blocked));
        if let Some((Pose { cell, .. }, state)) = last
            && blocked as usize >= REPETITIONS
        {
            return Some(Cause::Blocked { cell, movements: blocked, state });
        }
        let Some((Pose { cell, .. }, state)) = last.filter(|_| self.poses.len() > 1) else {
            return (messages.is_some() || last.is_some()).then_some(Cause::NeverMoved);
        };
        let steps = steps_between(maze.walls(), cell, maze.goals());
        let gave_up = || {
            let has_given_up = matches!(ending, Ending::Finished | Ending::GaveUp);
            steps.filter(|_| has_given_up).map(|steps| Cause::GaveUp { cell, state, steps })
        };
        self.false_wall().or_else(|| self.cycle()).or_else(gave_up)
    }

    fn false_wall(&self) -> Option<Cause> {
        self.path.iter().find_map(|&(cell, heading, since)| {
            let state = since?;
            let mut sides = Wall::new(cell, heading).cells();
            // A mouse may report a pose before it has read the walls around it.
            let earlier = self.poses.split_last().map_or(&[][..], |(_, earlier)| earlier);
            let was_beside = sides.any(|side| earlier.iter().any(|(pose, _)| pose.cell == side));
            was_beside.then_some(Cause::FalseWall { cell, heading, state })
        })
    }

    /// Returns the longest loop at the end of the poses. Of several periods, the shortest counts.
    fn cycle(&self) -> Option<Cause> {
        let poses: Vec<Pose> = self.poses.iter().rev().map(|&(pose, _)| pose).collect();
        let lengths = common_prefixes(&poses);
        let (length, period) = (1..)
            .zip(lengths.get(1..)?)
            .filter(|&(period, equal)| *equal >= (REPETITIONS - 1) * period)
            .map(|(period, equal)| (equal + period, period))
            .max_by_key(|&(length, period)| (length, std::cmp::Reverse(period)))?;
        let run = &self.poses[self.poses.len() - length..];
        let mut cells: Vec<(u8, u8)> =
            run[..period].iter().map(|(pose, _)| (pose.cell.x, pose.cell.y)).collect();
        cells.sort_unstable();
        cells.dedup();
        let ((from, state), (to, _)) = (run[0], run[period / 2]);
        Some(Cause::Loop { cells: cells.len(), from: from.cell, to: to.cell, state })
    }
}

/// Returns how many poses from each index on are equal to those from the first one on: the Z-function
/// of strings (<https://en.wikipedia.org/wiki/Z_algorithm>). Takes linear time.
fn common_prefixes(poses: &[Pose]) -> Vec<usize> {
    let mut lengths = vec![0; poses.len()];
    let (mut left, mut right) = (0, 0);
    for index in 1..poses.len() {
        let known = if index < right { lengths[index - left].min(right - index) } else { 0 };
        let further = poses[index + known..].iter().zip(&poses[known..]);
        lengths[index] = known + further.take_while(|(one, other)| one == other).count();
        if index + lengths[index] > right {
            (left, right) = (index, index + lengths[index]);
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The shortest path leads north, east and south.
    const MAZE: &str =
        "o---o---o---o\n|           |\no   o---o   o\n| S |     G |\no---o---o---o\n";

    fn cause(poses: &str, beliefs: &[(usize, Cell, Heading)], facts: EndFacts) -> Option<Cause> {
        let maze: Maze = MAZE.parse().unwrap();
        let mut evidence = Evidence::new(&maze);
        for (state, pose) in poses.split_whitespace().enumerate() {
            let digit = |index| pose.as_bytes()[index] - b'0';
            let heading =
                Heading::ALL.into_iter().find(|one| pose.ends_with(one.letter())).unwrap();
            evidence.add(Pose::new(Cell::new(digit(0), digit(1)), heading));
            evidence.believe(true, |cell, heading| {
                beliefs.iter().any(|&(since, at, side)| {
                    state >= since && Wall::new(at, side) == Wall::new(cell, heading)
                })
            });
        }
        evidence.cause(&maze, &facts)
    }

    fn ended(ending: Ending) -> EndFacts {
        EndFacts { ending, ..EndFacts::default() }
    }

    #[test]
    fn an_exit_code_says_less_than_a_loop() {
        let failed = |exit| EndFacts { exit: Some(exit), ..ended(Ending::Failed) };
        let [code, killed] = [Exit::ExitCode(1), Exit::Signal(11)];
        let exited = |exit| Some(Cause::Exited { exit, messages: None });
        assert_eq!(cause("", &[], failed(code)), exited(code));
        assert_eq!(cause("00N 01N", &[], failed(code)), exited(code));
        let turns = "00N 00E 00S 00W 00N 00E 00S 00W 00N 00E 00S 00W";
        assert!(matches!(cause(turns, &[], failed(code)), Some(Cause::Loop { cells: 1, .. })));
        assert_eq!(cause(turns, &[], failed(killed)), exited(killed));
    }

    #[test]
    fn the_first_cause_that_applies_is_the_cause() {
        let exit = Some(Exit::ExitCode(3));
        let messages = Some(Messages::Requests(9));
        let wall = (2, Cell::new(0, 1), Heading::East);
        let all =
            EndFacts { ending: Ending::TimeLimit, exit, messages, is_refused: true, blocked: 3 };
        let looping = "00N 01N 01S 00S 00N 01N 01S 00S 00N 01N 01S 00S";
        let mut texts = Vec::new();
        let mut add = |poses, beliefs: &[_], facts| {
            let cause = cause(poses, beliefs, facts);
            texts.push(cause.map_or("-".into(), |cause| cause.to_string()));
        };
        add("00N 01N", &[wall], all);
        let all = EndFacts { exit: None, ..all };
        add("00N 01N", &[wall], all);
        add(looping, &[wall], EndFacts { blocked: 0, ..all });
        let all = EndFacts { is_refused: false, ..all };
        add(looping, &[wall], all);
        let all = EndFacts { blocked: 2, ..all };
        add("00N 00N", &[wall], all);
        add(looping, &[wall], all);
        add(looping, &[], all);
        add(looping, &[], ended(Ending::Finished));
        add("00N 01N 01S 00S", &[], ended(Ending::Finished));
        add("00N 01N 01S 00S", &[], all);
        add("00N", &[], ended(Ending::Failed));
        add("", &[], EndFacts { messages, ..EndFacts::default() });
        add("", &[], EndFacts::default());
        insta::assert_snapshot!(texts.join("\n"), @"
        exited with code 3 after request 9
        waits for a reply to request 9, which was refused
        believes in a wall east of (0, 1) that is not there, since state 2
        runs into a wall 3 times, in (0, 0) at state 11
        never moved
        believes in a wall east of (0, 1) that is not there, since state 2
        loops over 2 cells, (0, 0) to (0, 1), since state 0
        loops over 2 cells, (0, 0) to (0, 1), since state 0
        gave up in (0, 0) at state 3, 4 steps from the goal
        -
        -
        never moved
        -
        ");
    }

    #[test]
    fn only_walls_beside_the_mouse_on_the_path_count() {
        let time_limit = ended(Ending::TimeLimit);
        let far = (0, Cell::new(2, 1), Heading::South);
        assert_eq!(cause("00N 01N", &[far], time_limit), None, "a map that begins closed");
        let near = "00N 01N 11E 21E 11W 01W";
        assert!(matches!(cause(near, &[far], time_limit), Some(Cause::FalseWall { .. })));
        let inside = (0, Cell::new(0, 0), Heading::East);
        assert_eq!(cause("00N 01N", &[inside], time_limit), None, "there is a wall");
    }

    #[test]
    fn a_loop_has_three_periods_and_begins_with_its_first_state() {
        let time_limit = ended(Ending::TimeLimit);
        let period = "01N 11E 11W 01W 01S ";
        for (times, state) in [(2, None), (3, Some(2))] {
            let found = cause(&("00N 00N ".to_owned() + &period.repeat(times)), &[], time_limit);
            assert_eq!(found.and_then(|cause| cause.state()), state, "{times}");
        }
        // A mouse that displays something reports a pose again, which does not end its loop.
        let found = cause(&"00N 00N 01N 01S ".repeat(4), &[], time_limit);
        assert_eq!(found.and_then(|cause| cause.state()), Some(0));
    }

    #[cfg(feature = "recording")]
    #[test]
    fn causes_have_a_kind_and_its_numbers() {
        let (exit, messages) = (Exit::Signal(9), Some(Messages::Commands(2)));
        let cell = Cell::new(1, 0);
        let causes = [
            Cause::Exited { exit, messages },
            Cause::Refused { messages: None },
            Cause::FalseWall { cell, heading: Heading::West, state: 4 },
        ];
        let lines = causes.map(|cause| serde_json::to_string(&cause).unwrap()).join("\n");
        insta::assert_snapshot!(lines, @r#"
        {"kind":"exited","signal":9,"commands":2}
        {"kind":"refused"}
        {"kind":"false_wall","cell":[1,0],"heading":"W","state":4}
        "#);
        let facts = EndFacts { exit: Some(exit), messages, blocked: 4, ..ended(Ending::GaveUp) };
        assert_eq!(EndFacts::from_log_line(&facts.to_log_line()), Some(facts));
        assert_eq!(EndFacts::from_log_line("run end: soon"), None);
    }

    proptest! {
        #[test]
        fn common_prefixes_are_those_of_the_definition(turns in prop::collection::vec(0_usize..2, 0..40)) {
            let poses: Vec<Pose> = turns
                .iter()
                .map(|&turn| Pose::new(Cell::new(0, 0), Heading::ALL[turn]))
                .collect();
            let lengths = common_prefixes(&poses);
            for (index, &length) in lengths.iter().enumerate().skip(1) {
                let equal = poses[index..].iter().zip(&poses).take_while(|(a, b)| a == b).count();
                prop_assert_eq!(length, equal);
            }
        }
    }
}
