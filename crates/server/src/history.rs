//! Every state of a search, in the order in which they came.

use std::collections::TryReserveError;
use std::fmt;

use mmsim_maze::MazeSize;
use mmsim_protocol::state_bytes;
use zstd::bulk::{Compressor, Decompressor};

use crate::block::Block;
use crate::memory::reserve;
use crate::motion_count::{self, MotionCount};
use crate::slabs::Slabs;

/// States in a block.
pub(crate) const BLOCK_STATES: usize = 256;

/// How hard blocks are packed. States of real searches come to 9 bytes each at this level; higher
/// ones take longer and gain nothing.
const LEVEL: i32 = 1;

/// Every state since the last reset, as the bytes of its message.
///
/// The newest states, up to 256, are kept as they came; once there is one more, they are packed
/// into a block. Neighbouring states differ little, so those of real searches come to some 10 bytes
/// each. Adding a state never moves those before it, and any of them can be read.
///
/// ```
/// use mmsim_maze::MazeSize;
/// use mmsim_server::History;
/// let mut history = History::new(MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// assert_eq!(history.get(1).as_deref(), Some(&b"S\x01\x00EC\x01\x00C\x0d\x17"[..]));
/// assert_eq!(history.get(2), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct History {
    /// Length of a state in bytes, the same for all.
    state_bytes: usize,
    /// How many bytes may be held.
    limit: usize,
    /// Blocks of 256 states. One that would not get smaller is as long as its states.
    packed: Slabs,
    /// The newest states as they came.
    open: Vec<u8>,
    packer: Packer,
    /// What leads to the first state of each block.
    tallies: Vec<MotionCount>,
    newest: Newest,
    /// The state before that, as long as the newest can be taken back.
    before: Newest,
}

/// The pose of the newest state, as it stands in its message, and what leads to it.
#[derive(Clone, Copy)]
struct Newest {
    pose: Option<[u8; 3]>,
    tally: MotionCount,
}

/// A history that has no room for another state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "cannot keep another state: the {states} so far take the {} MiB of the history; reset empties it \
     (--history-limit allows more)",
    limit >> 20
)]
pub struct Full {
    /// How many bytes may be held.
    pub limit: usize,
    /// How many states are held.
    pub states: usize,
}

/// Why a state was not added to a history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PushError {
    /// Its message has not the length of a state of this maze.
    #[error("expected a state of {expected} bytes, found {found} bytes")]
    Length {
        /// The length of every state, in bytes.
        expected: usize,
        /// That of the message.
        found: usize,
    },
    /// The history is as large as it may be.
    #[error(transparent)]
    Full(#[from] Full),
    /// The system has no memory left for it.
    #[error("cannot keep another state: out of memory after {states}; reset empties the history")]
    OutOfMemory {
        /// How many states are held.
        states: usize,
    },
}

impl History {
    /// A history without a state, for a maze of this size, limited by the memory of the machine
    /// alone.
    pub const fn new(size: MazeSize) -> Self {
        Self::with_limit(size, usize::MAX)
    }

    /// A history that holds at most so many bytes. What reading and packing need beside them, about
    /// a mebibyte, is not counted.
    pub const fn with_limit(size: MazeSize, limit: usize) -> Self {
        Self {
            state_bytes: state_bytes(size),
            limit,
            packed: Slabs::new(),
            open: Vec::new(),
            packer: Packer(None),
            tallies: Vec::new(),
            newest: Newest::START,
            before: Newest::START,
        }
    }

    /// How many states there are.
    pub const fn len(&self) -> usize {
        self.packed.len() * BLOCK_STATES + self.open.len() / self.state_bytes
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.packed.len() == 0 && self.open.is_empty()
    }

    /// How many bytes it holds, the packed states with what it takes to find them.
    pub const fn bytes(&self) -> usize {
        self.packed.bytes() + self.open.len() + self.tallies.len() * size_of::<MotionCount>()
    }

    /// How many bytes it may hold.
    pub const fn limit(&self) -> usize {
        self.limit
    }

    /// Adds a state.
    ///
    /// # Errors
    /// The message has not the length of a state, or there is no room for it. No state changes then.
    pub fn push(&mut self, state: &[u8]) -> Result<(), PushError> {
        if state.len() != self.state_bytes {
            return Err(PushError::Length { expected: self.state_bytes, found: state.len() });
        }
        let states = self.len();
        let out_of_memory = |_: TryReserveError| PushError::OutOfMemory { states };
        if self.open.len() == self.block_bytes() {
            self.pack().map_err(out_of_memory)?;
        }
        let begins_block = self.open.is_empty();
        let bytes = if begins_block { size_of::<MotionCount>() } else { 0 } + state.len();
        if self.bytes().saturating_add(bytes) > self.limit {
            return Err(Full { limit: self.limit, states }.into());
        }
        let room = self.block_bytes() - self.open.len();
        reserve(&mut self.open, room).map_err(out_of_memory)?;
        reserve(&mut self.tallies, 1).map_err(out_of_memory)?;
        self.open.extend_from_slice(state);
        self.before = self.newest;
        self.newest.follow(state);
        if begins_block {
            self.tallies.push(self.newest.tally);
        }
        Ok(())
    }

    /// Takes back the state that was just added, as if it had never come. Only the newest can be
    /// taken back for sure: the one before it may be packed.
    pub(crate) fn take_back(&mut self) {
        self.open.truncate(self.open.len().saturating_sub(self.state_bytes));
        self.tallies.truncate(self.len().div_ceil(BLOCK_STATES));
        self.newest = self.before;
    }

    /// The bytes of the state with this index, counted from 0.
    pub fn get(&self, index: usize) -> Option<Vec<u8>> {
        self.reader().get(index).map(<[u8]>::to_vec)
    }

    /// What leads from the first state to the one with this index.
    pub fn tally(&self, index: usize) -> Option<MotionCount> {
        self.block(index / BLOCK_STATES)?.unpack()?.tally(index)
    }

    /// The block with this index, for others to read: state `n` is in block `n / 256`. This copies
    /// the block as it is kept, so it is quick; unpacking it takes its time wherever it is done.
    /// `None` if there is no such block, or no memory left for a copy of it.
    pub fn block(&self, index: usize) -> Option<Block> {
        let (states, packed) = match self.packed.get(index) {
            Some(packed) => (packed, packed.len() != self.block_bytes()),
            None if index == self.packed.len() && !self.open.is_empty() => (&*self.open, false),
            None => return None,
        };
        let mut copy = Vec::new();
        reserve(&mut copy, states.len()).ok()?;
        copy.extend_from_slice(states);
        Some(Block {
            first: index * BLOCK_STATES,
            tally: *self.tallies.get(index)?,
            state_bytes: self.state_bytes,
            states: copy,
            packed,
        })
    }

    /// For reading many states: those of a block are unpacked once.
    pub const fn reader(&self) -> Reader<'_> {
        Reader { history: self, unpacker: None, block: None, states: Vec::new() }
    }

    /// All states, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = Vec<u8>> {
        let mut reader = self.reader();
        (0..self.len()).map_while(move |index| reader.get(index).map(<[u8]>::to_vec))
    }

    /// Forgets all states and frees their memory.
    pub fn clear(&mut self) {
        self.packed = Slabs::new();
        self.open = Vec::new();
        self.tallies = Vec::new();
        (self.newest, self.before) = (Newest::START, Newest::START);
    }

    const fn block_bytes(&self) -> usize {
        BLOCK_STATES * self.state_bytes
    }

    /// Makes a block of the open states.
    fn pack(&mut self) -> Result<(), TryReserveError> {
        self.packed.push(self.packer.pack(&self.open))?;
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

impl Newest {
    const START: Self = Self { pose: None, tally: MotionCount { steps: 0, turns: 0 } };

    /// Goes on to this state.
    fn follow(&mut self, state: &[u8]) {
        let pose = motion_count::pose(state);
        if let (Some(before), Some(after)) = (self.pose, pose) {
            self.tally += MotionCount::between(before, after);
        }
        self.pose = pose;
    }
}

/// What packs blocks, made for the first of them, and the room in which it does.
struct Packer(Option<(Compressor<'static>, Vec<u8>)>);

impl Packer {
    /// The block packed, or as it is where that fails or gains nothing: no state may get lost.
    fn pack<'p>(&'p mut self, block: &'p [u8]) -> &'p [u8] {
        self.try_pack(block).filter(|packed| packed.len() < block.len()).unwrap_or(block)
    }

    fn try_pack(&mut self, block: &[u8]) -> Option<&[u8]> {
        if self.0.is_none() {
            let mut room = Vec::new();
            reserve(&mut room, zstd::zstd_safe::compress_bound(block.len())).ok()?;
            self.0 = Some((Compressor::new(LEVEL).ok()?, room));
        }
        let (compressor, room) = self.0.as_mut()?;
        compressor.compress_to_buffer(block, room).ok()?;
        Some(room)
    }
}

/// Reads states of a history, one block at a time.
pub struct Reader<'h> {
    history: &'h History,
    unpacker: Option<Decompressor<'static>>,
    /// Which block is unpacked, and its states.
    block: Option<usize>,
    states: Vec<u8>,
}

impl Reader<'_> {
    /// The bytes of the state with this index, counted from 0; `None` if there is none, or if the
    /// machine has no memory left to unpack it.
    pub fn get(&mut self, index: usize) -> Option<&[u8]> {
        let (block, History { state_bytes, packed, open, .. }) =
            (index / BLOCK_STATES, self.history);
        let start = index % BLOCK_STATES * state_bytes;
        let states: &[u8] = match packed.get(block) {
            Some(packed) if packed.len() == self.history.block_bytes() => packed,
            Some(packed) => {
                if self.block != Some(block) {
                    self.unpack(packed)?;
                    self.block = Some(block);
                }
                &self.states
            }
            None if block == packed.len() => open,
            None => return None,
        };
        states.get(start..start + state_bytes)
    }

    fn unpack(&mut self, packed: &[u8]) -> Option<()> {
        self.block = None;
        if self.unpacker.is_none() {
            reserve(&mut self.states, self.history.block_bytes()).ok()?;
            self.unpacker = Some(Decompressor::new().ok()?);
        }
        self.unpacker.as_mut()?.decompress_to_buffer(packed, &mut self.states).ok().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn state(number: usize) -> Vec<u8> {
        number.to_le_bytes().into_iter().cycle().take(state_bytes(MazeSize::CLASSIC)).collect()
    }

    /// A state that no compression makes smaller.
    fn noise(number: u64) -> Vec<u8> {
        let mut seed = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut byte = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed.to_le_bytes()[0]
        };
        (0..state_bytes(MazeSize::CLASSIC)).map(|_| byte()).collect()
    }

    #[test]
    fn every_state_is_kept_across_blocks() {
        for make in [state, |number| noise(number as u64)] {
            let mut history = History::new(MazeSize::CLASSIC);
            assert!(history.is_empty());
            for count in 0..3 * BLOCK_STATES + 7 {
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
    fn what_is_no_state_is_not_kept() {
        let mut history = History::new(MazeSize::CLASSIC);
        let error = history.push(b"S").unwrap_err();
        assert_eq!(error, PushError::Length { expected: 518, found: 1 });
        assert!(history.push(&[b'S'; 519]).is_err());
        assert!(history.is_empty());
        assert!(history.get(usize::MAX).is_none());
    }

    #[test]
    fn a_full_history_keeps_what_it_has_until_it_is_emptied() {
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
        assert_eq!(error, Full { limit, states }.into());
        insta::assert_snapshot!(Full { limit, states: 7 }, @"cannot keep another state: the 7 so far take the 1 MiB of the history; reset empties it (--history-limit allows more)");
        assert!(history.push(&noise(0)).is_err());
        assert!(history.iter().enumerate().all(|(index, kept)| kept == noise(index as u64)));
        assert_eq!(history.len(), states);
        history.clear();
        history.push(&noise(1)).unwrap();
        assert_eq!(history.get(0), Some(noise(1)));
    }

    #[test]
    fn the_newest_state_can_be_taken_back() {
        let mut history = History::new(MazeSize::CLASSIC);
        history.take_back();
        for number in 0..2 * BLOCK_STATES + 2 {
            history.push(&state(usize::MAX)).unwrap();
            history.take_back();
            assert_eq!(history.len(), number);
            history.push(&state(number)).unwrap();
        }
        assert!(history.iter().eq((0..2 * BLOCK_STATES + 2).map(state)));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50))]
        #[test]
        fn a_history_is_a_list(
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
