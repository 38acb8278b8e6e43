//! Keeps every state of a search in memory.

pub(crate) mod block;
pub(crate) mod context_log;
pub(crate) mod log;
pub(crate) mod storage;
pub(crate) mod times;

use std::convert::Infallible;
use std::ops::RangeInclusive;
use std::{fmt, mem};

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{StateMessage, state_bytes};
use zstd::bulk::Decompressor;

use crate::context::Context;
use crate::context::update::{Events, Update};
use crate::history::block::{Block, States, StoredBytes};
use crate::history::context_log::ContextLog;
use crate::history::log::{LogBlock, LogEnd, LogLine, read_log};
use crate::history::storage::{BlockCompressor, Slabs};
use crate::memory::{OutOfMemory, reserve};

/// Every state since the last reset, stored as the bytes of its message.
///
/// The newest states are stored uncompressed. Once there are 256 uncompressed states, the next push
/// compresses them into a block. Consecutive states of a real search differ little, so a compressed
/// state takes only about 10 bytes. Appending a state never moves older blocks. Any state can be
/// read in microseconds.
///
/// ```
/// use mmsim_maze::MazeSize;
/// use mmsim_recording::History;
/// let mut history = History::new(MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// assert_eq!(history.get(1).as_deref(), Some(&b"S\x01\x00EC\x01\x00C\x0d\x17"[..]));
/// assert_eq!(history.get(2), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct History {
    size: MazeSize,
    /// The maximum memory in bytes.
    limit: usize,
    /// Blocks of 256 states, each compressed if this saves memory.
    packed: Slabs,
    /// The newest states, which are not compressed.
    open: Vec<u8>,
    compressor: BlockCompressor,
    pub(crate) contexts: ContextLog,
    /// The update of the state that is being added.
    update: Vec<u8>,
}

/// The reason why a state was not added to a history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PushError {
    /// The message has the wrong length for the size of the maze.
    #[error("expected a state of {expected} bytes, found {found} bytes")]
    Length {
        /// The length of every state in bytes.
        expected: usize,
        /// The length of the message in bytes.
        found: usize,
    },
    /// The history has reached its memory limit.
    #[error(
        "cannot store another state: history limit of {} MiB reached after {states} states (reset, \
         or raise --history-limit)",
        limit >> 20
    )]
    Full {
        /// The limit in bytes.
        limit: usize,
        /// The number of states in the history.
        states: usize,
    },
    /// The system is out of memory.
    #[error(
        "cannot store another state: out of memory after {states} states (reset to free memory)"
    )]
    OutOfMemory {
        /// The number of states in the history.
        states: usize,
    },
}

impl History {
    /// Creates an empty history for a maze of this size, without a memory limit.
    pub fn new(size: MazeSize) -> Self {
        Self::with_limit(size, usize::MAX)
    }

    /// Creates an empty history that uses at most `limit` bytes, not counting a few MiB of working
    /// memory for compression and for the newest update. Each log line counts as its compressed
    /// bytes plus the size of a [`LogLine`], because empty lines compress to nothing.
    pub fn with_limit(size: MazeSize, limit: usize) -> Self {
        Self {
            size,
            limit,
            packed: Slabs::default(),
            open: Vec::new(),
            compressor: BlockCompressor::default(),
            contexts: ContextLog::new(size),
            update: Vec::new(),
        }
    }

    /// Returns the number of states.
    pub const fn len(&self) -> usize {
        self.packed.len() * Block::STATES + self.open.len() / state_bytes(self.size)
    }

    /// Returns true if there are no states.
    pub const fn is_empty(&self) -> bool {
        self.packed.len() == 0 && self.open.is_empty()
    }

    /// Returns the memory that the states use, in bytes.
    pub const fn bytes(&self) -> usize {
        self.packed.bytes + self.open.len() + self.contexts.bytes()
    }

    /// Returns the memory limit in bytes.
    pub const fn limit(&self) -> usize {
        self.limit
    }

    /// Appends a state with an empty update: the client has read the walls around the pose.
    ///
    /// # Errors
    /// See [`push_with_update`](Self::push_with_update).
    pub fn push(&mut self, state: &[u8]) -> Result<(), PushError> {
        self.push_with_update(Update::default(), state)
    }

    /// Appends a state and the update that precedes it.
    ///
    /// # Errors
    /// Returns an error if the message has the wrong length for the size of the maze, or if there
    /// is not enough memory for another state. On error, the states in the history stay the same.
    pub fn push_with_update(&mut self, update: Update<'_>, state: &[u8]) -> Result<(), PushError> {
        self.push_with(state, |context, pose, bytes| {
            reserve(bytes, update.max_bytes())?;
            Ok(context.encode_update(pose, update, bytes))
        })
    }

    /// Appends a state and the valid bytes of the update that precedes it.
    pub(crate) fn push_recorded(&mut self, update: &[u8], state: &[u8]) -> Result<(), PushError> {
        let events = Events::from_update(update, self.size);
        self.push_with(state, |_, _, bytes| {
            reserve(bytes, update.len())?;
            bytes.extend_from_slice(update);
            Ok(events)
        })
    }

    fn push_with(
        &mut self,
        state: &[u8],
        encode: impl FnOnce(&Context, Option<Pose>, &mut Vec<u8>) -> Result<Events, OutOfMemory>,
    ) -> Result<(), PushError> {
        let (expected, found) = (state_bytes(self.size), state.len());
        if found != expected {
            return Err(PushError::Length { expected, found });
        }
        let states = self.len();
        let out_of_memory = |_: OutOfMemory| PushError::OutOfMemory { states };
        if self.open.len() == self.block_bytes() {
            self.pack().map_err(out_of_memory)?;
        }
        let pose = StateMessage::new(state, self.size).and_then(|state| state.pose()).ok();
        self.update.clear();
        let encoded = encode(self.contexts.context(), pose, &mut self.update);
        let events = encoded.map_err(out_of_memory)?;
        let starts_block = self.open.is_empty();
        let bytes = state.len() + self.contexts.push_bytes(starts_block, &self.update, events);
        if self.bytes().saturating_add(bytes) > self.limit {
            return Err(PushError::Full { limit: self.limit, states });
        }
        let room = self.block_bytes() - self.open.len();
        reserve(&mut self.open, room).map_err(out_of_memory)?;
        let block = self.packed.len();
        let prepared = self.contexts.prepare(starts_block, block, &mut self.compressor);
        prepared.map_err(out_of_memory)?;
        let pushed = self.contexts.push(states % Block::STATES, pose, &self.update, events);
        pushed.map_err(out_of_memory)?;
        self.open.extend_from_slice(state);
        Ok(())
    }

    /// Removes the newest state, as if it had never been added. `undo_push` works only once after
    /// each [`push`](Self::push), because older states may be compressed.
    pub fn undo_push(&mut self) {
        self.open.truncate(self.open.len().saturating_sub(state_bytes(self.size)));
        self.contexts.undo_push();
    }

    /// Returns the state with this index, counted from 0.
    pub fn get(&self, index: usize) -> Option<Vec<u8>> {
        self.reader().get(index).map(<[u8]>::to_vec)
    }

    /// Copies the block with this index. State `n` is in block `n / 256`.
    ///
    /// Copying is fast because the block stays compressed. The caller can decompress the copy on
    /// any thread. Returns `None` if the block does not exist or memory runs out.
    pub fn block(&self, index: usize) -> Option<Block> {
        let (messages, length) = self.stored(index)?;
        Some(Block(States {
            first: index * Block::STATES,
            size: self.size,
            messages: StoredBytes::new(messages, length).ok()?,
            context: self.contexts.copy_context(index).ok()?,
            updates: self.contexts.copy_updates(index, index == self.packed.len()).ok()?,
        }))
    }

    /// Returns the context of the state with this index. To read the contexts of many states, use
    /// [`block`](Self::block).
    pub fn context(&self, index: usize) -> Option<Context> {
        self.block(index / Block::STATES)?.unpack()?.context(index)
    }

    /// Returns the context of the newest state, or the context of a new run if there are no states.
    pub fn newest_context(&self) -> Context {
        self.contexts.newest_context()
    }

    /// Copies the log lines of the first or last block with log lines whose index is in `blocks`.
    /// See [`read_log`].
    pub fn log_block(&self, blocks: RangeInclusive<usize>, end: LogEnd) -> Option<LogBlock> {
        self.contexts.log_block(blocks, end, self.packed.len())
    }

    /// Returns the last `max` log lines that match a filter, up to the state with the index `last`,
    /// in order.
    pub fn log(&self, last: usize, max: usize, filter: impl Fn(&str) -> bool) -> Vec<LogLine> {
        let read = |blocks, end| Ok::<_, Infallible>(self.log_block(blocks, end));
        read_log(&(0..=last), LogEnd::Last, max, filter, read)
            .unwrap_or_else(|never| match never {})
    }

    /// Returns the update of the newest state as bytes, for
    /// [`RecordingWriter::write_with_update`](crate::RecordingWriter::write_with_update). The bytes are empty
    /// for most states.
    pub fn newest_update(&self) -> &[u8] {
        self.contexts.newest()
    }

    /// Returns a reader that is efficient for many states. If states are read in order, each block
    /// is decompressed only once.
    pub const fn reader(&self) -> HistoryReader<'_> {
        HistoryReader { history: self, decompressor: None, block: None, states: Vec::new() }
    }

    /// Iterates over all states from the oldest to the newest.
    pub fn iter(&self) -> impl Iterator<Item = Vec<u8>> {
        let mut reader = self.reader();
        (0..self.len()).map_while(move |index| reader.get(index).map(<[u8]>::to_vec))
    }

    /// Removes all states and frees their memory.
    pub fn clear(&mut self) {
        let compressor = mem::take(&mut self.compressor);
        *self = Self { compressor, ..Self::with_limit(self.size, self.limit) };
    }

    /// Returns the stored bytes of a block and their uncompressed length. The bytes are compressed
    /// if the lengths differ.
    fn stored(&self, index: usize) -> Option<(&[u8], usize)> {
        let is_open = index == self.packed.len() && !self.open.is_empty();
        let open = is_open.then_some((&*self.open, self.open.len()));
        self.packed.get(index).map(|packed| (packed, self.block_bytes())).or(open)
    }

    const fn block_bytes(&self) -> usize {
        Block::STATES * state_bytes(self.size)
    }

    /// Compresses the states in `open` into a block. If compression fails or saves no memory, the
    /// block is stored uncompressed.
    fn pack(&mut self) -> Result<(), OutOfMemory> {
        self.contexts.pack_updates(self.packed.len(), &mut self.compressor)?;
        self.packed.push(self.compressor.compress(&self.open))?;
        self.open.clear();
        Ok(())
    }
}

impl fmt::Debug for History {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (states, bytes) = (self.len(), self.bytes());
        f.debug_struct("History").field("states", &states).field("bytes", &bytes).finish()
    }
}

/// Reads states from a history and caches one decompressed block.
pub struct HistoryReader<'h> {
    history: &'h History,
    decompressor: Option<Decompressor<'static>>,
    /// The index of the block in `states`.
    block: Option<usize>,
    states: Vec<u8>,
}

impl HistoryReader<'_> {
    /// Returns the state with this index, counted from 0. Returns `None` if the state does not
    /// exist or memory runs out.
    pub fn get(&mut self, index: usize) -> Option<&[u8]> {
        let (block, length) = (index / Block::STATES, state_bytes(self.history.size));
        let (mut states, unpacked_length) = self.history.stored(block)?;
        if states.len() != unpacked_length {
            if self.block != Some(block) {
                self.unpack(states)?;
                self.block = Some(block);
            }
            states = &self.states;
        }
        let start = index % Block::STATES * length;
        states.get(start..start + length)
    }

    fn unpack(&mut self, packed: &[u8]) -> Option<()> {
        self.block = None;
        if self.decompressor.is_none() {
            reserve(&mut self.states, self.history.block_bytes()).ok()?;
            self.decompressor = Some(Decompressor::new().ok()?);
        }
        self.decompressor.as_mut()?.decompress_to_buffer(packed, &mut self.states).ok().map(drop)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::WyRand;
    use proptest::prelude::*;

    use super::*;

    fn state(number: usize) -> Vec<u8> {
        number.to_le_bytes().into_iter().cycle().take(state_bytes(MazeSize::CLASSIC)).collect()
    }

    /// Returns an incompressible state.
    fn noise(number: u64) -> Vec<u8> {
        let mut rng = WyRand::new(number);
        (0..state_bytes(MazeSize::CLASSIC)).map(|_| rng.next_u64().to_le_bytes()[0]).collect()
    }

    #[test]
    fn every_state_survives_across_blocks() {
        for make in [state, |number| noise(number as u64)] {
            let mut history = History::new(MazeSize::CLASSIC);
            assert!(history.is_empty());
            for count in 0..3 * Block::STATES + 7 {
                assert_eq!(history.len(), count);
                assert!(history.get(count).is_none());
                history.push(&make(count)).unwrap();
            }
            for (index, kept) in history.iter().enumerate() {
                assert_eq!(kept, make(index));
                assert_eq!(history.get(index), Some(kept));
            }
            assert_eq!(history.iter().count(), history.len());
            history.clear();
            assert!(history.is_empty() && history.get(0).is_none());
            assert_eq!((history.len(), history.bytes()), (0, 0));
        }
    }

    #[test]
    fn messages_of_another_length_are_refused() {
        let mut history = History::new(MazeSize::CLASSIC);
        let error = history.push(b"S").unwrap_err();
        assert_eq!(error, PushError::Length { expected: 518, found: 1 });
        assert!(history.push(&[b'S'; 519]).is_err());
        assert!(history.is_empty());
        assert!(history.get(usize::MAX).is_none());
    }

    #[test]
    fn a_full_history_refuses_states_until_cleared() {
        let limit = 1 << 20;
        let mut history = History::with_limit(MazeSize::CLASSIC, limit);
        let error = loop {
            match history.push(&noise(history.len() as u64)) {
                Ok(()) => assert!(history.bytes() <= limit),
                Err(error) => break error,
            }
        };
        let states = history.len();
        assert!((2000..=limit / 518).contains(&states), "{states} states");
        assert_eq!(error, PushError::Full { limit, states });
        insta::assert_snapshot!(PushError::Full { limit, states: 7 }, @"cannot store another state: history limit of 1 MiB reached after 7 states (reset, or raise --history-limit)");
        assert!(history.push(&noise(0)).is_err());
        assert!(history.iter().enumerate().all(|(index, kept)| kept == noise(index as u64)));
        assert_eq!(history.len(), states);
        history.clear();
        history.push(&noise(1)).unwrap();
        assert_eq!(history.get(0), Some(noise(1)));
    }

    #[test]
    fn the_newest_state_can_be_undone() {
        let mut history = History::new(MazeSize::CLASSIC);
        history.undo_push();
        for number in 0..2 * Block::STATES + 2 {
            history.push(&state(usize::MAX)).unwrap();
            history.undo_push();
            assert_eq!(history.len(), number);
            history.push(&state(number)).unwrap();
        }
        assert!(history.iter().eq((0..2 * Block::STATES + 2).map(state)));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50))]
        #[test]
        fn a_history_equals_a_list(
            (width, height) in (1usize..=8, 1usize..=8),
            bytes in prop::collection::vec(any::<u8>(), 1..40),
            count in 0usize..2000,
            reads in prop::collection::vec(0usize..2100, 100),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let length = state_bytes(size);
            let twin: Vec<Vec<u8>> = (0..count)
                .map(|number| bytes.iter().copied().cycle().skip(number).take(length).collect())
                .collect();
            let mut history = History::new(size);
            for state in &twin {
                history.push(state).unwrap();
            }
            prop_assert_eq!(history.len(), count);
            let mut reader = history.reader();
            for index in reads {
                prop_assert_eq!(reader.get(index), twin.get(index).map(Vec::as_slice));
            }
        }
    }
}
