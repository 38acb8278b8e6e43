//! Copies of up to 256 consecutive states of a history with their contexts, which can be read on
//! other threads.
//!
//! ```text
//! updates  for each update: index of the state in the block (1 byte), length (4 bytes), bytes
//! ```

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{State, StateMessage, state_bytes};

use crate::context::Context;
use crate::context::update::{Events, StoredUpdate};
use crate::history::storage::decompress;
use crate::memory::{OutOfMemory, reserve};

/// A copy of up to 256 consecutive states of a [`History`](crate::History), possibly compressed.
#[derive(Clone, Debug)]
pub struct Block(pub(crate) States);

/// Up to 256 consecutive states of a history. They are uncompressed unless they belong to a
/// [`Block`].
#[derive(Clone, Debug)]
pub struct States {
    pub(crate) first: usize,
    pub(crate) size: MazeSize,
    /// The message of each state.
    pub(crate) messages: StoredBytes,
    /// The context before the first state. Empty if nothing has changed since the start of the run.
    pub(crate) context: StoredBytes,
    pub(crate) updates: UpdateData,
}

impl Block {
    /// The number of states in every block except the last.
    pub const STATES: usize = 256;

    /// Decompresses the states. Returns `None` if memory runs out.
    pub fn unpack(self) -> Option<States> {
        let Self(States { first, size, messages, context, updates }) = self;
        let (messages, context) = (messages.unpack().ok()?, context.unpack().ok()?);
        Some(States { first, size, messages, context, updates: updates.unpack().ok()? })
    }
}

impl States {
    /// Returns the number of states.
    pub const fn len(&self) -> usize {
        self.messages.bytes.len() / state_bytes(self.size)
    }

    /// Returns true if there are no states. A block that was copied from a history has at least one
    /// state.
    pub const fn is_empty(&self) -> bool {
        self.messages.bytes.is_empty()
    }

    /// Returns the memory that the states use, in bytes.
    pub fn memory(&self) -> usize {
        let updates = self.updates.0.iter().map(|part| part.bytes.len()).sum::<usize>();
        self.messages.bytes.len() + self.context.bytes.len() + updates
    }

    /// Returns the state with this index in the whole history.
    pub fn get(&self, index: usize) -> Option<&[u8]> {
        let length = state_bytes(self.size);
        let start = index.checked_sub(self.first)?.checked_mul(length)?;
        self.messages.bytes.get(start..start.checked_add(length)?)
    }

    /// Returns a view of the state with this index in the whole history.
    pub fn message(&self, index: usize) -> Option<StateMessage<'_>> {
        StateMessage::new(self.get(index)?, self.size).ok()
    }

    /// Returns the bytes of up to `count` states, starting with the state at index `from` in the
    /// whole history.
    pub fn range(&self, from: usize, count: usize) -> &[u8] {
        let length = state_bytes(self.size);
        let start = from.saturating_sub(self.first).saturating_mul(length);
        let end = start.saturating_add(count.saturating_mul(length));
        let end = end.min(self.messages.bytes.len());
        self.messages.bytes.get(start..end).unwrap_or_default()
    }

    /// Returns the context of the state with this index.
    pub fn context(&self, index: usize) -> Option<Context> {
        let last = index - self.get(index).map(|_| self.first)?;
        let (mut context, mut updates) = (self.first_context()?, self.updates.iter());
        for at in 0..=last {
            let pose = self.message(self.first + at).and_then(|state| state.pose().ok());
            let update = StoredUpdate::decode(updates.seek(at), self.size).ok()?;
            context.apply(pose, &update);
        }
        Some(context)
    }

    /// Returns the update of the state with this index as bytes, for [`save`](crate::save). The
    /// bytes are empty for most states.
    pub fn update(&self, index: usize) -> Option<&[u8]> {
        let at = index - self.get(index).map(|_| self.first)?;
        Some(self.updates.iter().seek(at))
    }

    /// Returns the context before the first state.
    fn first_context(&self) -> Option<Context> {
        match &*self.context.bytes {
            [] => Some(Context::new(self.size)),
            bytes => Context::decode(bytes, self.size),
        }
    }

    /// Iterates over the states of this block from the index `from` in the whole history: the pose, or
    /// `None` if it is invalid, and true if the mouse was put back at the start before the state.
    pub fn poses(&self, from: usize) -> impl Iterator<Item = (Option<Pose>, bool)> {
        let mut updates = self.updates.iter();
        (from.max(self.first)..self.first + self.len()).map(move |index| {
            let events = Events::from_update(updates.seek(index - self.first), self.size);
            let pose = self.message(index).and_then(|message| message.pose().ok());
            (pose, events.has_restart)
        })
    }
}

/// Reads the states of a block in order. [`States::context`] starts at the beginning of the block for
/// each state, but a scan computes each context from the previous one.
///
/// ```
/// use mmsim_recording::History;
/// let mut history = History::new(mmsim_maze::MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// let states = history.block(0).and_then(|block| block.unpack()).expect("a block");
/// let mut scan = states.scan().expect("an intact block");
/// let mut cells = Vec::new();
/// while let Some(state) = scan.advance() {
///     cells.push((state.index, state.pose.cell.x));
/// }
/// assert_eq!(cells, [(0, 0), (1, 1)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateScan<'a> {
    states: &'a States,
    updates: Updates<'a>,
    cursor: StateCursor,
}

/// A state with its context.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ScannedState<'s> {
    /// The index of the state in the whole history.
    pub index: usize,
    /// The message `S`.
    pub message: &'s [u8],
    /// The pose of the mouse.
    pub pose: Pose,
    /// True if the mouse was put back at the start before this state.
    pub has_restart: bool,
    /// The context of this state.
    pub context: &'s Context,
    /// True if the context may differ from that of the previous state.
    pub is_context_new: bool,
    /// The number of log lines that precede this state.
    pub log_lines: usize,
}

impl<'s> ScannedState<'s> {
    /// Decodes the message, or returns `None` if it is invalid.
    pub fn state(&self, size: MazeSize) -> Option<State<'s>> {
        State::decode(self.message, size).ok()
    }
}

/// The context of the states that have been read.
#[derive(Clone, Debug)]
pub(crate) struct StateCursor {
    size: MazeSize,
    /// The index of the next state.
    next: usize,
    context: Context,
}

impl StateCursor {
    /// Starts before the first state of a run.
    pub(crate) fn new(size: MazeSize) -> Self {
        Self { size, next: 0, context: Context::new(size) }
    }

    /// Reads the next state and the update that precedes it. Returns `None` if one of them is
    /// invalid.
    pub(crate) fn advance<'s>(
        &'s mut self,
        update: &[u8],
        message: &'s [u8],
    ) -> Option<ScannedState<'s>> {
        let Self { size, next, context } = self;
        let pose = StateMessage::new(message, *size).ok()?.pose().ok()?;
        let update = StoredUpdate::decode(update, *size).ok()?;
        let is_context_new = context.apply(Some(pose), &update);
        let (index, events) = (*next, update.changes.events());
        *next += 1;
        let (has_restart, log_lines) = (events.has_restart, events.lines);
        Some(ScannedState { index, message, pose, has_restart, context, is_context_new, log_lines })
    }
}

impl States {
    /// Starts a scan at the first state of this block. Returns `None` if the block is damaged.
    pub fn scan(&self) -> Option<StateScan<'_>> {
        let context = self.first_context()?;
        let cursor = StateCursor { size: self.size, next: self.first, context };
        Some(StateScan { states: self, updates: self.updates.iter(), cursor })
    }
}

impl StateScan<'_> {
    /// Reads the next state. Returns `None` after the last state or if the block is damaged.
    pub fn advance(&mut self) -> Option<ScannedState<'_>> {
        let index = self.cursor.next;
        let message = self.states.get(index)?;
        self.cursor.advance(self.updates.seek(index - self.states.first), message)
    }
}

/// The updates in a block, in one or more parts. Decompressed updates have one part.
#[derive(Clone, Debug, Default)]
pub(crate) struct UpdateData(pub(crate) Vec<StoredBytes>);

/// A copy of stored bytes. They are compressed if their number differs from `length`.
#[derive(Clone, Debug, Default)]
pub(crate) struct StoredBytes {
    bytes: Vec<u8>,
    /// The uncompressed length in bytes.
    length: usize,
}

impl StoredBytes {
    pub(crate) fn new(bytes: &[u8], length: usize) -> Result<Self, OutOfMemory> {
        let mut copy = Vec::new();
        reserve(&mut copy, bytes.len())?;
        copy.extend_from_slice(bytes);
        Ok(Self { bytes: copy, length })
    }

    fn unpack(self) -> Result<Self, OutOfMemory> {
        Ok(Self { bytes: decompress(self.bytes, self.length)?, ..self })
    }
}

impl UpdateData {
    /// Decompresses the updates.
    pub(crate) fn unpack(self) -> Result<Self, OutOfMemory> {
        let mut bytes = Vec::new();
        reserve(&mut bytes, self.0.iter().map(|part| part.length).sum())?;
        for part in self.0 {
            bytes.extend_from_slice(&part.unpack()?.bytes);
        }
        let length = bytes.len();
        Ok(Self(vec![StoredBytes { bytes, length }]))
    }

    /// Iterates over the updates. They must be decompressed.
    pub(crate) fn iter(&self) -> Updates<'_> {
        Updates(self.0.first().map_or(&[], |data| &data.bytes))
    }
}

/// The updates in a block that have not been read yet.
#[derive(Clone, Debug)]
pub(crate) struct Updates<'a>(&'a [u8]);

impl<'a> Updates<'a> {
    /// Returns the update before the state `index` of the block. Skips the updates of earlier
    /// states.
    pub(crate) fn seek(&mut self, index: usize) -> &'a [u8] {
        while let Some(&at) = self.0.first()
            && usize::from(at) <= index
            && let Some((at, update)) = self.next()
        {
            if at == index {
                return update;
            }
        }
        &[]
    }
}

impl<'a> Iterator for Updates<'a> {
    /// The index of a state in the block, and the bytes of its update.
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        let (&[index, a, b, c, d], rest) = self.0.split_first_chunk()?;
        let length = usize::try_from(u32::from_le_bytes([a, b, c, d])).ok()?;
        let (update, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some((index.into(), update))
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize};
    use mmsim_protocol::{Annotations, state_bytes};
    use proptest::prelude::*;

    use super::*;
    use crate::context::update::{Readings, Update, UpdateTracker};
    use crate::history::History;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50))]
        #[test]
        fn blocks_equal_the_history(
            poses in prop::collection::vec((0u8..4, 0u8..3, 0usize..4), 1..700),
            restarts in prop::collection::vec(prop::bool::weighted(0.1), 700),
            is_undone in any::<bool>(),
            reads in prop::collection::vec((0usize..800, 0usize..300), 30),
        ) {
            let size = MazeSize::new(4, 3).unwrap();
            let state = |&(x, y, heading): &(u8, u8, usize)| {
                let mut state = vec![b'S', x, y, b"NESW"[heading]];
                state.resize(state_bytes(size), x ^ y);
                state
            };
            let mut history = History::new(size);
            for (index, pose) in poses.iter().enumerate() {
                if is_undone {
                    history.push(&state(&(3, 2, index % 4))).unwrap();
                    history.undo_push();
                }
                let list: &[u8] = if restarts[index] { b"AR" } else { b"" };
                let annotations = Annotations::decode(list, size);
                let mut updates = UpdateTracker::default();
                if let Ok(request) = annotations {
                    updates.annotate(request).unwrap();
                }
                let update = Update { readings: Readings::AtPose, ..updates.update() };
                history.push_with_update(update, &state(pose)).unwrap();
                assert_eq!(history.newest_update().len(), usize::from(restarts[index]));
            }
            let pose = |index: usize| {
                let (x, y, heading) = poses[index];
                Pose::new(Cell::new(x, y), Heading::ALL[heading])
            };
            for (index, count) in reads {
                let states = history.block(index / Block::STATES).and_then(Block::unpack);
                let got = states.as_ref().and_then(|states| states.get(index)).map(<[u8]>::to_vec);
                prop_assert_eq!(&got, &history.get(index));
                if let Some(states) = states.filter(|_| got.is_some()) {
                    let end = (index + count).min(poses.len()).min(states.first + states.len());
                    let expected: Vec<u8> = poses[index..end].iter().flat_map(state).collect();
                    prop_assert_eq!(states.range(index, count), expected);
                    let found = states.poses(index).take(end - index);
                    let expected = (index..end).map(|index| (Some(pose(index)), restarts[index]));
                    prop_assert!(found.eq(expected));
                }
            }
            prop_assert!(history.block(poses.len().div_ceil(Block::STATES)).is_none());
        }
    }

    const LISTS: [&[u8]; 6] =
        [b"AR", b"AL\x01\0a", b"AL\x01\0aL\0\0R", b"AT\x01\x01\x01x", b"AS\x01s", b"AC\x02\x00g"];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn scanned_states_equal_single_reads(
            states in prop::collection::vec((0u8..4, 0u8..3, 0usize..4, 0usize..20), 1..600),
        ) {
            let size = MazeSize::new(4, 3).unwrap();
            let (mut history, mut updates) = (History::new(size), UpdateTracker::default());
            for &(x, y, heading, list) in &states {
                if let Some(list) = LISTS.get(list) {
                    updates.annotate(Annotations::decode(list, size).unwrap()).unwrap();
                }
                let mut state = vec![b'S', x, y, b"NESW"[heading]];
                state.resize(state_bytes(size), b'C');
                history.push_with_update(updates.update(), &state).unwrap();
                updates.report();
            }
            let (mut count, mut previous) = (0, Context::new(size));
            for block in 0..states.len().div_ceil(Block::STATES) {
                let block = history.block(block).and_then(Block::unpack).unwrap();
                let mut scan = block.scan().unwrap();
                while let Some(state) = scan.advance() {
                    prop_assert_eq!(state.index, count);
                    prop_assert_eq!(Some(state.message), block.get(count));
                    let found = (Some(state.pose), state.has_restart);
                    prop_assert_eq!(Some(found), block.poses(count).next());
                    prop_assert_eq!(state.context, &block.context(count).unwrap());
                    prop_assert!(state.is_context_new || *state.context == previous);
                    let lines = match LISTS.get(states[count].3) {
                        Some([b'A', b'L', .., b'R']) => 2,
                        Some([b'A', b'L', ..]) => 1,
                        _ => 0,
                    };
                    prop_assert_eq!(state.log_lines, lines);
                    previous = state.context.clone();
                    count += 1;
                }
            }
            prop_assert_eq!(count, states.len());
        }
    }
}
