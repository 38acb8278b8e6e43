//! Stores the context of each state of a history.
//!
//! The context at the start of a block of 256 states is stored only if it has changed since it was
//! last stored. Within a block, only the updates that are not empty are stored:
//!
//! ```text
//! update  index of the state in the block (1 byte), length (4 bytes), bytes of the update
//! ```

use mmsim_maze::{MazeSize, Pose};

use crate::compressor::{BlockCompressor, decompress};
use crate::context::Context;
use crate::memory::{OutOfMemory, reserve};
use crate::slabs::Slabs;
use crate::update::{StoredUpdate, Update};

/// The length of the fields before an update in bytes.
const HEAD_BYTES: usize = 1 + size_of::<u32>();

/// The contexts of all states of a history.
#[derive(Debug)]
pub(crate) struct ContextLog {
    /// The context of the newest state, without the update in `newest`.
    context: Context,
    /// The pose and the update of the newest state, unless they have been applied to `context`.
    newest: Option<Newest>,
    /// True if the context differs from the last stored context.
    has_changed: bool,
    /// The updates in the block of the newest states, which are not compressed.
    open: Vec<u8>,
    /// Contexts and updates, compressed if this saves memory.
    packed: Slabs,
    /// The contexts at the start of blocks, in ascending order.
    contexts: Vec<Packed>,
    /// The updates in blocks, in ascending order.
    updates: Vec<Packed>,
    size: MazeSize,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    pose: Option<Pose>,
    /// The length of `open` without the update.
    start: usize,
}

/// The location of data in `packed`.
#[derive(Clone, Copy, Debug)]
struct Packed {
    /// The index of the block that the data belongs to.
    block: usize,
    /// The index of the data in `packed`.
    at: usize,
    /// The uncompressed length in bytes.
    length: usize,
}

/// The maximum memory for the location of packed data, in bytes.
const PACKED_BYTES: usize = size_of::<Packed>() + Slabs::LOCATION_BYTES;

impl ContextLog {
    pub(crate) fn new(size: MazeSize) -> Self {
        Self {
            context: Context::new(size),
            newest: None,
            has_changed: false,
            open: Vec::new(),
            packed: Slabs::default(),
            contexts: Vec::new(),
            updates: Vec::new(),
            size,
        }
    }

    /// Returns the memory in use, in bytes.
    pub(crate) const fn bytes(&self) -> usize {
        let locations = (self.contexts.len() + self.updates.len()) * size_of::<Packed>();
        self.packed.bytes + locations + self.open.len()
    }

    /// Encodes the update before the next state, which has the pose `pose`. `into` becomes the
    /// bytes of the update, without everything that does not change the context.
    pub(crate) fn encode(
        &mut self,
        pose: Option<Pose>,
        update: Update<'_>,
        into: &mut Vec<u8>,
    ) -> Result<(), OutOfMemory> {
        self.apply_newest();
        into.clear();
        reserve(into, update.max_bytes())?;
        self.context.encode_update(pose, update, into);
        Ok(())
    }

    /// Returns the maximum memory that a state with this update needs, in bytes.
    pub(crate) fn push_bytes(&self, starts_block: bool, update: &[u8]) -> usize {
        let stores_context = starts_block && self.has_changed;
        let context = if stores_context { self.context.max_bytes() + PACKED_BYTES } else { 0 };
        context + if update.is_empty() { 0 } else { HEAD_BYTES + update.len() }
    }

    /// Stores the context at the start of the block with this index, unless it has been stored.
    /// Call this method after `encode` and before `push`.
    pub(crate) fn begin_block(
        &mut self,
        block: usize,
        compressor: &mut BlockCompressor,
    ) -> Result<(), OutOfMemory> {
        if self.has_changed {
            let mut context = Vec::new();
            reserve(&mut context, self.context.max_bytes())?;
            self.context.encode(&mut context);
            pack(&context, block, compressor, &mut self.packed, &mut self.contexts)?;
            self.has_changed = false;
        }
        Ok(())
    }

    /// Appends the update of the next state, which has this index in its block.
    pub(crate) fn push(
        &mut self,
        index: usize,
        pose: Option<Pose>,
        update: &[u8],
    ) -> Result<(), OutOfMemory> {
        reserve(&mut self.open, HEAD_BYTES + update.len())?;
        self.newest = Some(Newest { pose, start: self.open.len() });
        // Both numbers fit: a block has 256 states, and updates have at most `MAX_UPDATE_BYTES`.
        if let (Ok(index), Ok(length)) = (u8::try_from(index), u32::try_from(update.len()))
            && length > 0
        {
            self.open.push(index);
            self.open.extend(length.to_le_bytes());
            self.open.extend_from_slice(update);
        }
        Ok(())
    }

    /// Removes the update of the newest state. Works only once after each `push`.
    pub(crate) fn undo_push(&mut self) {
        if let Some(newest) = self.newest.take() {
            self.open.truncate(newest.start);
        }
    }

    /// Returns the update of the newest state.
    pub(crate) fn newest(&self) -> &[u8] {
        let newest = self.newest.and_then(|newest| self.open.get(newest.start + HEAD_BYTES..));
        newest.unwrap_or_default()
    }

    /// Stores the updates in the open block, which has this index.
    pub(crate) fn end_block(
        &mut self,
        block: usize,
        compressor: &mut BlockCompressor,
    ) -> Result<(), OutOfMemory> {
        self.apply_newest();
        if !self.open.is_empty() {
            pack(&self.open, block, compressor, &mut self.packed, &mut self.updates)?;
            self.open.clear();
        }
        Ok(())
    }

    /// Copies the data from which the contexts in a block are computed. `is_open` is true for the
    /// block of the newest states.
    pub(crate) fn block(&self, block: usize, is_open: bool) -> Result<ContextBlock, OutOfMemory> {
        let last = |list: &[Packed]| {
            let count = list.partition_point(|packed| packed.block <= block);
            list[..count].last().copied()
        };
        let context = match last(&self.contexts) {
            Some(packed) => self.copy(packed)?,
            None => Data::default(),
        };
        let updates = match last(&self.updates) {
            Some(packed) if packed.block == block => self.copy(packed)?,
            _ if is_open => Data::new(&self.open, self.open.len())?,
            _ => Data::default(),
        };
        Ok(ContextBlock { context, updates })
    }

    fn copy(&self, Packed { at, length, .. }: Packed) -> Result<Data, OutOfMemory> {
        Data::new(self.packed.get(at).unwrap_or_default(), length)
    }

    fn apply_newest(&mut self) {
        let Some(Newest { pose, start }) = self.newest.take() else { return };
        let update = self.open.get(start + HEAD_BYTES..).unwrap_or_default();
        // Always succeeds, because `encode` has encoded the update.
        if let Ok(update) = StoredUpdate::decode(update, self.size) {
            self.has_changed |= self.context.apply(pose, &update);
        }
    }
}

/// Compresses data of a block and appends it to `slabs` and `list`.
fn pack(
    bytes: &[u8],
    block: usize,
    compressor: &mut BlockCompressor,
    slabs: &mut Slabs,
    list: &mut Vec<Packed>,
) -> Result<(), OutOfMemory> {
    reserve(list, 1)?;
    let at = slabs.len();
    slabs.push(compressor.compress(bytes))?;
    list.push(Packed { block, at, length: bytes.len() });
    Ok(())
}

/// The data from which the contexts in a block are computed.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContextBlock {
    /// The context before the first state. Empty if nothing has changed since the start of the run.
    context: Data,
    updates: Data,
}

/// A copy of stored data, which is compressed unless its length is `length`.
#[derive(Clone, Debug, Default)]
struct Data {
    bytes: Vec<u8>,
    /// The uncompressed length in bytes.
    length: usize,
}

impl Data {
    fn new(bytes: &[u8], length: usize) -> Result<Self, OutOfMemory> {
        let mut copy = Vec::new();
        reserve(&mut copy, bytes.len())?;
        copy.extend_from_slice(bytes);
        Ok(Self { bytes: copy, length })
    }

    fn unpack(self) -> Result<Self, OutOfMemory> {
        Ok(Self { bytes: decompress(self.bytes, self.length)?, ..self })
    }
}

impl ContextBlock {
    /// Decompresses the data.
    pub(crate) fn unpack(self) -> Result<Self, OutOfMemory> {
        Ok(Self { context: self.context.unpack()?, updates: self.updates.unpack()? })
    }

    /// Returns the context before the first state. The block must be decompressed.
    pub(crate) fn first(&self, size: MazeSize) -> Option<Context> {
        match &*self.context.bytes {
            [] => Some(Context::new(size)),
            bytes => Context::decode(bytes, size),
        }
    }

    /// Returns the updates of the states. The block must be decompressed.
    pub(crate) fn updates(&self) -> Updates<'_> {
        Updates(&self.updates.bytes)
    }
}

/// The updates in a block that have not been read yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Updates<'a>(&'a [u8]);

impl<'a> Updates<'a> {
    /// Returns the update before the state `index` of the block. Skips the updates of earlier
    /// states.
    pub(crate) fn seek(&mut self, index: usize) -> &'a [u8] {
        while let Some((&[at, a, b, c, d], rest)) = self.0.split_first_chunk()
            && usize::from(at) <= index
        {
            let length = usize::try_from(u32::from_le_bytes([a, b, c, d])).unwrap_or(usize::MAX);
            let (update, rest) = rest.split_at_checked(length).unwrap_or_default();
            self.0 = rest;
            if usize::from(at) == index {
                return update;
            }
        }
        &[]
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Walls};
    use mmsim_protocol::state_bytes;
    use proptest::prelude::*;

    use super::*;
    use crate::block::Block;
    use crate::history::History;
    use crate::update::Readings;

    fn size() -> MazeSize {
        MazeSize::new(5, 4).unwrap()
    }

    fn state(pose: Option<Pose>) -> Vec<u8> {
        let mut state = pose.map_or(b"S\xff\xff?".to_vec(), |Pose { cell, heading }| {
            vec![b'S', cell.x, cell.y, heading.letter() as u8]
        });
        state.resize(state_bytes(size()), b'C');
        state
    }

    fn any_pose() -> impl Strategy<Value = Pose> {
        (0u8..5, 0u8..4, 0usize..4)
            .prop_map(|(x, y, heading)| Pose::new(Cell::new(x, y), Heading::ALL[heading]))
    }

    /// Returns the walls that have been read after each state.
    fn naive(steps: &[(Option<Pose>, Option<Vec<Pose>>)]) -> Vec<Option<Walls>> {
        let mut sensed: Option<Walls> = Some(Walls::open(size()));
        let each = steps.iter().map(|(_, poses)| {
            sensed = poses.as_ref().map(|poses| {
                let mut walls = sensed.take().unwrap_or_else(|| Walls::open(size()));
                for &Pose { cell, heading } in poses {
                    for heading in [heading.left(), heading, heading.right()] {
                        walls.set(cell, heading, true);
                    }
                }
                walls
            });
            sensed.clone()
        });
        each.collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]
        #[test]
        fn the_log_equals_a_list(
            steps in prop::collection::vec(
                (
                    prop::option::weighted(0.9, any_pose()),
                    prop::option::weighted(0.97, prop::collection::vec(any_pose(), 0..3)),
                    any::<bool>(),
                ),
                1..30,
            ),
            repeats in prop::collection::vec(1usize..100, 30),
            is_undone in any::<bool>(),
        ) {
            // In half of the steps, the client has read the walls at its pose, as usual.
            let steps = steps.into_iter().map(|(own, mut poses, is_usual)| {
                if let (Some(own), Some(poses), true) = (own, &mut poses, is_usual) {
                    *poses = vec![own];
                }
                (own, poses)
            });
            let steps: Vec<_> = steps
                .zip(repeats)
                .flat_map(|(step, count)| std::iter::repeat_n(step, count))
                .collect();
            let mut history = History::new(size());
            for (own, poses) in &steps {
                if is_undone {
                    let pose = Pose::new(Cell::new(2, 2), Heading::South);
                    let update = Update { readings: Readings::Poses(&[pose]) };
                    history.push_after(update, &state(Some(pose))).unwrap();
                    history.undo_push();
                }
                let readings = poses.as_deref().map_or(Readings::Untracked, Readings::Poses);
                history.push_after(Update { readings }, &state(*own)).unwrap();
            }
            for (first, expected) in naive(&steps).chunks(Block::STATES).enumerate() {
                let states = history.block(first).unwrap().unpack().unwrap();
                for (index, sensed) in (first * Block::STATES..).zip(expected) {
                    let context = states.context(index).unwrap();
                    prop_assert_eq!(context.sensed(), sensed.as_ref(), "state {}", index);
                }
                prop_assert!(states.context(first * Block::STATES + expected.len()).is_none());
            }
        }
    }

    #[test]
    fn usual_readings_need_no_memory() {
        let poses = size().cells().map(|cell| Pose::new(cell, Heading::North)).cycle();
        let (mut history, mut log) = (History::new(size()), 0);
        for pose in poses.take(20 * Block::STATES + 1) {
            history.push(&state(Some(pose))).unwrap();
            assert_eq!(history.newest_update(), b"");
            log = history.contexts.bytes();
        }
        // Only the context at the start of the second block differs from the context before it.
        let context = Context::new(size()).max_bytes();
        assert!(log <= context + 100, "{log} bytes");
        history.clear();
        assert_eq!(history.contexts.bytes(), 0);
    }
}
