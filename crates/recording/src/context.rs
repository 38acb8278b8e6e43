//! The client's state beyond the bytes of its last message: the walls that it has read, and the
//! annotations in effect.

pub(crate) mod changes;
pub(crate) mod notes;
pub(crate) mod update;

use mmsim_maze::{KnownMaze, Maze, MazeSize, Pose, Walls, WallsAround};
use mmsim_protocol::{Annotation, State, StateMessage};

use crate::context::changes::{Changes, RESTART, put_line};
use crate::context::notes::Notes;
use crate::context::update::{
    Events, NOT_OWN, Readings, StoredReadings, StoredUpdate, TrailingAnnotations, UNTRACKED,
    Update, put_reading,
};

/// The client's state beyond the bytes of its last message: the walls that it has read, and the
/// annotations in effect.
///
/// A client may claim walls that it cannot know, for example because it marks a cell as visited
/// before it reads the walls of that cell. [`known_maze`](Self::known_maze) contains only walls
/// that the client can know.
///
/// ```
/// use mmsim_maze::{Cell, Heading, KnownMaze, Maze, WallState};
/// use mmsim_protocol::State;
/// use mmsim_recording::{History, Readings, Update};
/// let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse()?;
/// let mut history = History::new(maze.size());
/// // The mouse has moved to the middle, but has only read the walls at the start.
/// let state = b"S\x01\x00NC\x02\x01\x00C\x0d\x01\x00";
/// let readings = Readings::Poses(&[maze.start()]);
/// history.push_with_update(Update { readings, ..Update::default() }, state)?;
///
/// let context = history.context(0).expect("a state with the index 0");
/// let (state, unexplored) = (State::decode(state, maze.size())?, KnownMaze::unexplored(&maze));
/// let known = context.known_maze(&state, &unexplored, Some(&maze));
/// assert_eq!(known.wall(Cell::new(0, 0), Heading::East), WallState::Absent);
/// assert_eq!(known.wall(Cell::new(1, 0), Heading::East), WallState::Unknown);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Context {
    size: MazeSize,
    /// Contains a wall for each wall that the client has read, present or absent. `None` if the
    /// readings are unknown.
    walls_read: Option<Walls>,
    notes: Notes,
}

const TRACKED_KEY: u8 = b'T';
const UNTRACKED_KEY: u8 = b'U';

impl Context {
    /// Creates the context before the first state of a run.
    pub(crate) fn new(size: MazeSize) -> Self {
        Self { size, walls_read: Some(Walls::open(size)), notes: Notes::new(size) }
    }

    /// Returns the walls that the client has read: a wall in the result means that the client has
    /// read whether the maze has a wall in this position. Returns `None` if the client has not read
    /// any walls since the reset, so it knows the walls from another source.
    pub const fn walls_read(&self) -> Option<&Walls> {
        self.walls_read.as_ref()
    }

    /// Returns the texts, colours, declared walls and names that the mouse displays.
    pub const fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Returns the map that the client claims to know: the walls in the flags of the state, except
    /// that declared walls override the flags. A client that marks a cell as visited before it reads
    /// the walls does not claim that they are absent. `unexplored` is the map before the first
    /// state, which provides the start and the goal.
    pub fn claimed_maze(&self, state: &State<'_>, unexplored: &KnownMaze) -> KnownMaze {
        let mut map = state.map(unexplored.start().cell, *unexplored.goals());
        if let Some(walls_read) = &self.walls_read {
            map.forget_unobserved_openings(walls_read);
        }
        self.notes.declare(&mut map);
        map
    }

    /// Returns the map of the walls that the client knows. A wall is known if the client claims it
    /// (see [`claimed_maze`](Self::claimed_maze)), if it agrees with the true maze (if given), and
    /// if the client has read it (or has not read any walls since the reset).
    ///
    /// If the true maze is given, its shortest path is at least as long as the optimistic distance
    /// and at most as long as the pessimistic distance.
    pub fn known_maze(
        &self,
        state: &State<'_>,
        unexplored: &KnownMaze,
        truth: Option<&Maze>,
    ) -> KnownMaze {
        let mut map = self.claimed_maze(state, unexplored);
        self.forget_unknown(&mut map, truth);
        map
    }

    /// Turns the map that the client claims to know into the map of the walls that it knows. See
    /// [`known_maze`](Self::known_maze).
    pub fn forget_unknown(&self, claimed: &mut KnownMaze, truth: Option<&Maze>) {
        if let Some(truth) = truth {
            claimed.forget_errors(truth.walls());
        }
        if let Some(walls_read) = &self.walls_read {
            claimed.forget_unobserved(walls_read);
        }
    }

    /// Applies the annotations after the state of this context: what the mouse displays at the end of
    /// its run.
    pub fn annotate(&mut self, trailing: &TrailingAnnotations) {
        self.notes.apply_all(trailing.list());
    }

    /// Applies an update before a state with the pose `pose`. Returns true if the context has
    /// changed.
    pub(crate) fn apply(&mut self, pose: Option<Pose>, update: &StoredUpdate<'_>) -> bool {
        let has_read = self.apply_readings(pose, update.readings);
        self.notes.apply_changes(update.changes) || has_read
    }

    fn apply_readings(&mut self, pose: Option<Pose>, readings: StoredReadings<'_>) -> bool {
        match readings {
            StoredReadings::AtPose => {
                let read = self.walls_read.as_mut().zip(pose);
                read.is_some_and(|(walls_read, pose)| read_around(walls_read, pose))
            }
            StoredReadings::Untracked => self.walls_read.take().is_some(),
            StoredReadings::Poses { own: reads_pose, others } => {
                let mut changed = self.walls_read.is_none();
                let walls_read = self.walls_read.get_or_insert_with(|| Walls::open(self.size));
                for pose in pose.filter(|_| reads_pose).into_iter().chain(others.iter()) {
                    changed |= read_around(walls_read, pose);
                }
                changed
            }
        }
    }

    /// Appends the bytes of an update before a state with the pose `pose`. Omits everything that
    /// changes neither the context nor the returned events, so the update of most states is empty.
    pub(crate) fn encode_update(
        &self,
        pose: Option<Pose>,
        update: Update<'_>,
        to: &mut Vec<u8>,
    ) -> Events {
        self.encode_readings(pose, update.readings, to);
        if update.annotations.is_empty() {
            return Events::default();
        }
        let mut next = self.notes.clone();
        let events = next.apply_all(update.annotations);
        self.notes.encode_changes(&next, to);
        if events.has_restart {
            to.push(RESTART);
        }
        if events.lines > 0 {
            for annotation in update.annotations.iter() {
                if let Annotation::Log(line) = annotation {
                    put_line(to, line);
                }
            }
        }
        events
    }

    fn encode_readings(&self, pose: Option<Pose>, readings: Readings<'_>, to: &mut Vec<u8>) {
        match (readings, &self.walls_read) {
            (Readings::AtPose, _) | (Readings::Untracked, None) => {}
            (Readings::Untracked, Some(_)) => to.push(UNTRACKED),
            (Readings::Poses(poses), Some(walls_read)) => {
                let is_at_pose = match (poses, pose) {
                    (&[read], Some(pose)) => read == pose,
                    ([], Some(pose)) => is_read(walls_read, pose),
                    (_, None) | ([_, ..], _) => poses.is_empty(),
                };
                if !is_at_pose {
                    encode_poses(walls_read.clone(), pose, poses, to);
                }
            }
            (Readings::Poses(poses), None) => {
                let start = to.len();
                encode_poses(Walls::open(self.size), pose, poses, to);
                if to.len() == start {
                    // An empty update would mean that there are still no readings.
                    match pose {
                        Some(pose) => put_reading(to, pose),
                        None => to.push(NOT_OWN),
                    }
                }
            }
        }
    }

    /// Returns the maximum length of the encoded context in bytes.
    pub(crate) fn max_bytes(&self) -> usize {
        let walls_read = 2 * row_bytes(self.size) * usize::from(self.size.height());
        1 + walls_read + self.notes.max_bytes()
    }

    /// Appends the context as bytes: the walls that the client has read, then the notes.
    pub(crate) fn encode(&self, to: &mut Vec<u8>) {
        if let Some(walls_read) = &self.walls_read {
            to.push(TRACKED_KEY);
            for rows in [walls_read.north_rows(), walls_read.east_rows()] {
                for row in &rows[..self.size.height().into()] {
                    to.extend_from_slice(&row.to_le_bytes()[..row_bytes(self.size)]);
                }
            }
        } else {
            to.push(UNTRACKED_KEY);
        }
        Notes::new(self.size).encode_changes(&self.notes, to);
    }

    /// Decodes the bytes written by [`encode`](Self::encode).
    pub(crate) fn decode(mut bytes: &[u8], size: MazeSize) -> Option<Self> {
        let &key = bytes.split_off_first()?;
        let mut walls_read = None;
        if key == TRACKED_KEY {
            let bytes_each = row_bytes(size) * usize::from(size.height());
            let mut take_rows = || Some(decode_rows(bytes.split_off(..bytes_each)?, size));
            walls_read = Some(Walls::from_rows(size, take_rows()?, take_rows()?));
        }
        let mut notes = Notes::new(size);
        notes.apply_changes(Changes::decode(bytes, size).ok()?);
        Some(Self { size, walls_read, notes })
    }
}

/// Encodes the update of each state for [`RecordingWriter::write_with_update`]. A [`History`]
/// encodes its updates itself.
///
/// [`History`]: crate::History
/// [`RecordingWriter::write_with_update`]: crate::RecordingWriter::write_with_update
#[derive(Clone, Debug)]
pub struct UpdateEncoder {
    context: Context,
    bytes: Vec<u8>,
}

impl UpdateEncoder {
    /// Creates an encoder for the states of a maze of this size.
    pub fn new(size: MazeSize) -> Self {
        Self { context: Context::new(size), bytes: Vec::new() }
    }

    /// Returns the bytes of the update before the next state.
    pub fn encode(&mut self, update: Update<'_>, state: &[u8]) -> &[u8] {
        let size = self.context.size;
        let pose = StateMessage::new(state, size).and_then(|state| state.pose()).ok();
        self.bytes.clear();
        self.context.encode_update(pose, update, &mut self.bytes);
        // Always succeeds, because the update has just been encoded.
        if let Ok(update) = StoredUpdate::decode(&self.bytes, size) {
            self.context.apply(pose, &update);
        }
        &self.bytes
    }
}

/// Returns the length of an encoded row of walls in bytes.
fn row_bytes(size: MazeSize) -> usize {
    usize::from(size.width()).div_ceil(8)
}

fn decode_rows(bytes: &[u8], size: MazeSize) -> [u32; MazeSize::MAX_SIDE as usize] {
    let mut rows = [0; MazeSize::MAX_SIDE as usize];
    for (row, bytes) in rows.iter_mut().zip(bytes.chunks(row_bytes(size))) {
        *row = bytes.iter().rev().fold(0, |row, &byte| row << 8 | u32::from(byte));
    }
    rows
}

/// Returns true if all walls around a pose have been read.
fn is_read(walls_read: &Walls, pose: Pose) -> bool {
    walls_read.around(pose) == WallsAround { left: true, front: true, right: true }
}

/// Marks the walls around a pose as read. Returns true if one of them had not been read.
fn read_around(walls_read: &mut Walls, pose: Pose) -> bool {
    let is_new = !is_read(walls_read, pose);
    if is_new {
        let Pose { cell, heading } = pose;
        for heading in [heading.left(), heading, heading.right()] {
            walls_read.set(cell, heading, true);
        }
    }
    is_new
}

/// Appends readings. `before` contains the walls that have been read before.
fn encode_poses(before: Walls, pose: Option<Pose>, poses: &[Pose], to: &mut Vec<u8>) {
    let (mut after, mut encoded) = (before.clone(), before);
    for &pose in poses {
        read_around(&mut after, pose);
    }
    match pose {
        Some(pose) if is_read(&after, pose) => drop(read_around(&mut encoded, pose)),
        _ => to.push(NOT_OWN),
    }
    for &pose in poses {
        if read_around(&mut encoded, pose) {
            put_reading(to, pose);
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, WallState};
    use mmsim_protocol::Annotations;

    use super::*;
    use crate::context::update::UpdateTracker;
    use crate::history::History;

    fn pose(x: u8, y: u8, heading: Heading) -> Pose {
        Pose::new(Cell::new(x, y), heading)
    }

    fn encoded(context: &Context, own: Option<Pose>, readings: Readings<'_>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let update = Update { readings, ..Update::default() };
        context.encode_update(own, update, &mut bytes);
        bytes
    }

    #[test]
    fn claimed_openings_are_read_or_declared() {
        let size = MazeSize::new(3, 1).unwrap();
        let unexplored = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
        // The cells (0, 0) and (2, 0) are visited and have no walls.
        let message = b"S\0\0NC\0\0\0C\x01\0\x01";
        let east = |readings, annotations: &[u8]| {
            let mut tracker = UpdateTracker::default();
            if !annotations.is_empty() {
                tracker.annotate(Annotations::decode(annotations, size).unwrap()).unwrap();
            }
            let mut history = History::new(size);
            let update = Update { readings, ..tracker.update() };
            history.push_with_update(update, message).unwrap();
            let state = State::decode(message, size).unwrap();
            let map = history.context(0).unwrap().claimed_maze(&state, &unexplored);
            [0, 1].map(|x| map.wall(Cell::new(x, 0), Heading::East))
        };
        let [absent, unknown] = [WallState::Absent, WallState::Unknown];
        assert_eq!(east(Readings::AtPose, b""), [absent, unknown], "the walls around the mouse");
        assert_eq!(east(Readings::Poses(&[]), b""), [unknown; 2]);
        assert_eq!(east(Readings::Untracked, b""), [absent; 2]);
        assert_eq!(east(Readings::Poses(&[]), b"AD\x01\x00E0"), [unknown, absent]);
    }

    #[test]
    fn only_other_readings_are_encoded() {
        use Readings::{AtPose, Poses, Untracked};
        let size = MazeSize::new(4, 3).unwrap();
        let mut context = Context::new(size);
        let (own, next) = (pose(1, 1, Heading::North), pose(1, 2, Heading::East));
        let back = pose(1, 1, Heading::South);
        let update =
            |context: &Context, readings: Readings<'_>| encoded(context, Some(own), readings);
        assert_eq!(update(&context, AtPose), b"");
        assert_eq!(update(&context, Untracked), b"U");
        assert_eq!(update(&context, Poses(&[own])), b"");
        assert_eq!(update(&context, Poses(&[])), b"N");
        assert_eq!(update(&context, Poses(&[next])), b"NR\x01\x02E");
        assert_eq!(update(&context, Poses(&[next, own])), b"R\x01\x02E");
        assert_eq!(update(&context, Poses(&[own, own, back])), b"R\x01\x01S");
        assert_eq!(update(&context, Poses(&[pose(3, 2, Heading::East)])), b"NR\x03\x02E");
        assert_eq!(encoded(&context, None, Poses(&[])), b"");
        assert_eq!(encoded(&context, None, Poses(&[own])), b"NR\x01\x01N");
        // The neighbours have read three of the walls.
        context.apply(Some(own), &StoredUpdate::decode(b"", size).unwrap());
        assert_eq!(update(&context, Poses(&[])), b"");
        assert_eq!(update(&context, Poses(&[own])), b"");
        assert_eq!(update(&context, Poses(&[own, own])), b"");
        context.apply(Some(own), &StoredUpdate::decode(b"U", size).unwrap());
        assert_eq!(update(&context, AtPose), b"");
        assert_eq!(update(&context, Untracked), b"");
        assert_eq!(update(&context, Poses(&[])), b"N");
        assert_eq!(update(&context, Poses(&[own])), b"R\x01\x01N");
        assert_eq!(update(&context, Poses(&[own, next])), b"R\x01\x02E");
        assert_eq!(encoded(&context, None, Poses(&[])), b"N");
    }

    #[test]
    fn contexts_survive_a_round_trip() {
        for size in [(1, 1), (9, 3), (16, 16), (32, 32)] {
            let size = MazeSize::new(size.0, size.1).unwrap();
            let mut context = Context::new(size);
            for (index, cell) in size.cells().enumerate().step_by(3) {
                let own = Pose::new(cell, Heading::ALL[index % 4]);
                context.apply(Some(own), &StoredUpdate::decode(b"", size).unwrap());
                let mut bytes = Vec::new();
                context.encode(&mut bytes);
                assert!(bytes.len() <= context.max_bytes());
                assert_eq!(Context::decode(&bytes, size).as_ref(), Some(&context));
            }
            context.apply(None, &StoredUpdate::decode(b"U", size).unwrap());
            let mut bytes = Vec::new();
            context.encode(&mut bytes);
            assert_eq!(Context::decode(&bytes, size), Some(context));
        }
    }
}
