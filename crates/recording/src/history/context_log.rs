//! Stores the context of each state of a history.
//!
//! The context at the start of a block of 256 states is stored only if it has changed since it was
//! last stored. Within a block, only the updates that are not empty are stored.

use std::ops::RangeInclusive;

use mmsim_maze::{MazeSize, Pose};

use crate::context::Context;
use crate::context::update::{Events, StoredUpdate};
use crate::history::block::{StoredBytes, UpdateData};
use crate::history::log::{LogBlock, LogEnd, LogLine};
use crate::history::storage::{BlockCompressor, Slabs};
use crate::memory::{OutOfMemory, reserve};

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
    /// The newest updates in the block of the newest states, which are not compressed.
    open: Vec<u8>,
    /// The number of log lines in `open`.
    open_lines: usize,
    /// Contexts and updates, compressed if this saves memory.
    packed: Slabs,
    /// The contexts at the start of blocks, in ascending order.
    contexts: Vec<Packed>,
    /// The updates in blocks, in ascending order. A block with long updates has several parts.
    updates: Vec<Packed>,
    /// The blocks with log lines in `updates`, in ascending order.
    log_blocks: Vec<usize>,
    /// The number of all log lines.
    lines: usize,
    size: MazeSize,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    pose: Option<Pose>,
    /// The length of `open` without the update.
    start: usize,
    /// The number of log lines in the update.
    lines: usize,
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

/// Updates are compressed before the end of their block if they exceed this length in bytes.
const MAX_OPEN_BYTES: usize = 64 << 10;

/// The memory that is counted for a log line in addition to its compressed bytes. Readers of the
/// log need as much for a line.
const LINE_BYTES: usize = size_of::<LogLine>();

/// The maximum memory for the location of packed data, in bytes.
const PACKED_BYTES: usize = size_of::<Packed>() + Slabs::LOCATION_BYTES;

impl ContextLog {
    pub(crate) fn new(size: MazeSize) -> Self {
        Self {
            context: Context::new(size),
            newest: None,
            has_changed: false,
            open: Vec::new(),
            open_lines: 0,
            packed: Slabs::default(),
            contexts: Vec::new(),
            updates: Vec::new(),
            log_blocks: Vec::new(),
            lines: 0,
            size,
        }
    }

    /// Returns the memory in use, in bytes.
    pub(crate) const fn bytes(&self) -> usize {
        let locations = (self.contexts.len() + self.updates.len()) * size_of::<Packed>();
        let log = self.log_blocks.len() * size_of::<usize>() + self.lines * LINE_BYTES;
        self.packed.bytes + locations + log + self.open.len()
    }

    /// Returns the context before the update of the next state. After this call, `undo_push` has no
    /// effect.
    pub(crate) fn context(&mut self) -> &Context {
        self.apply_newest();
        &self.context
    }

    /// Returns the maximum memory that a state with this update needs, in bytes.
    pub(crate) fn push_bytes(&self, starts_block: bool, update: &[u8], events: Events) -> usize {
        let stores_context = starts_block && self.has_changed;
        let context = if stores_context { self.context.max_bytes() + PACKED_BYTES } else { 0 };
        let log = match events.lines {
            0 => 0,
            lines => size_of::<usize>() + lines * LINE_BYTES,
        };
        context + log + if update.is_empty() { 0 } else { HEAD_BYTES + update.len() }
    }

    /// Prepares the block with this index for the next state. Stores the context at the start of the
    /// block, unless it has been stored, and compresses long updates. Call this method between
    /// `context` and `push`.
    pub(crate) fn prepare(
        &mut self,
        starts_block: bool,
        block: usize,
        compressor: &mut BlockCompressor,
    ) -> Result<(), OutOfMemory> {
        if self.open.len() > MAX_OPEN_BYTES {
            self.pack_updates(block, compressor)?;
        }
        if starts_block && self.has_changed {
            let mut context = Vec::new();
            reserve(&mut context, self.context.max_bytes())?;
            self.context.encode(&mut context);
            reserve(&mut self.contexts, 1)?;
            let (at, length) = (self.packed.len(), context.len());
            self.packed.push(compressor.compress(&context))?;
            self.contexts.push(Packed { block, at, length });
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
        Events { lines, .. }: Events,
    ) -> Result<(), OutOfMemory> {
        if !update.is_empty() {
            reserve(&mut self.open, HEAD_BYTES + update.len())?;
        }
        self.newest = Some(Newest { pose, start: self.open.len(), lines });
        self.lines += lines;
        self.open_lines += lines;
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
            self.lines -= newest.lines;
            self.open_lines -= newest.lines;
        }
    }

    /// Returns the update of the newest state.
    pub(crate) fn newest(&self) -> &[u8] {
        let newest = self.newest.and_then(|newest| self.open.get(newest.start + HEAD_BYTES..));
        newest.unwrap_or_default()
    }

    /// Compresses the updates that belong to the block with this index.
    pub(crate) fn pack_updates(
        &mut self,
        block: usize,
        compressor: &mut BlockCompressor,
    ) -> Result<(), OutOfMemory> {
        self.apply_newest();
        if !self.open.is_empty() {
            reserve(&mut self.updates, 1)?;
            reserve(&mut self.log_blocks, 1)?;
            let (at, length) = (self.packed.len(), self.open.len());
            self.packed.push(compressor.compress(&self.open))?;
            self.updates.push(Packed { block, at, length });
            if self.open_lines > 0 && self.log_blocks.last() != Some(&block) {
                self.log_blocks.push(block);
            }
            self.open.clear();
            self.open_lines = 0;
        }
        Ok(())
    }

    /// Copies the context before the first state of a block, which is empty if nothing has changed
    /// since the start of the run.
    pub(crate) fn copy_context(&self, block: usize) -> Result<StoredBytes, OutOfMemory> {
        let count = self.contexts.partition_point(|packed| packed.block <= block);
        self.contexts[..count]
            .last()
            .map_or(Ok(StoredBytes::default()), |&packed| self.copy(packed))
    }

    /// Copies the updates of the first or last block with log lines whose index is in `blocks`. The
    /// index of the block of the newest states is `open`.
    pub(crate) fn log_block(
        &self,
        blocks: RangeInclusive<usize>,
        end: LogEnd,
        open: usize,
    ) -> Option<LogBlock> {
        let newest = (self.open_lines > 0).then_some(open).filter(|open| blocks.contains(open));
        let packed = &self.log_blocks;
        let block = match end {
            LogEnd::First => {
                let at = packed.partition_point(|block| block < blocks.start());
                packed.get(at).copied().or(newest)
            }
            LogEnd::Last => newest.or_else(|| {
                let count = packed.partition_point(|block| block <= blocks.end());
                packed[..count].last().copied()
            }),
        };
        let block = block.filter(|block| blocks.contains(block))?;
        let updates = self.copy_updates(block, block == open).ok()?;
        Some(LogBlock { block, updates, size: self.size })
    }

    /// Copies the updates in a block. `is_open` is true for the block of the newest states.
    pub(crate) fn copy_updates(
        &self,
        block: usize,
        is_open: bool,
    ) -> Result<UpdateData, OutOfMemory> {
        let start = self.updates.partition_point(|packed| packed.block < block);
        let packed = self.updates[start..].iter().take_while(|packed| packed.block == block);
        let mut parts = packed.map(|&packed| self.copy(packed)).collect::<Result<Vec<_>, _>>()?;
        if is_open {
            parts.push(StoredBytes::new(&self.open, self.open.len())?);
        }
        Ok(UpdateData(parts))
    }

    /// Returns the context of the newest state.
    pub(crate) fn newest_context(&self) -> Context {
        let mut context = self.context.clone();
        if let Some(Newest { pose, .. }) = self.newest
            && let Ok(update) = StoredUpdate::decode(self.newest(), self.size)
        {
            context.apply(pose, &update);
        }
        context
    }

    fn copy(&self, Packed { at, length, .. }: Packed) -> Result<StoredBytes, OutOfMemory> {
        StoredBytes::new(self.packed.get(at).unwrap_or_default(), length)
    }

    fn apply_newest(&mut self) {
        let Some(Newest { pose, start, .. }) = self.newest.take() else { return };
        let update = self.open.get(start + HEAD_BYTES..).unwrap_or_default();
        // Always succeeds, because the update is valid.
        if let Ok(update) = StoredUpdate::decode(update, self.size) {
            self.has_changed |= self.context.apply(pose, &update);
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Walls};
    use mmsim_protocol::state_bytes;
    use proptest::prelude::*;

    use super::*;
    use crate::context::update::{Readings, Update};
    use crate::history::History;
    use crate::history::block::Block;

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
        let mut walls_read: Option<Walls> = Some(Walls::open(size()));
        let each = steps.iter().map(|(_, poses)| {
            walls_read = poses.as_ref().map(|poses| {
                let mut walls = walls_read.take().unwrap_or_else(|| Walls::open(size()));
                for &Pose { cell, heading } in poses {
                    for heading in [heading.left(), heading, heading.right()] {
                        walls.set(cell, heading, true);
                    }
                }
                walls
            });
            walls_read.clone()
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
            // In half of the steps, the client has read the walls at its pose.
            let steps = steps.into_iter().map(|(own, mut poses, is_at_pose)| {
                if let (Some(own), Some(poses), true) = (own, &mut poses, is_at_pose) {
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
                    let update = Update { readings: Readings::Poses(&[pose]), ..Update::default() };
                    history.push_with_update(update, &state(Some(pose))).unwrap();
                    history.undo_push();
                }
                let readings = poses.as_deref().map_or(Readings::Untracked, Readings::Poses);
                history.push_with_update(Update { readings, ..Update::default() }, &state(*own)).unwrap();
            }
            for (first, expected) in naive(&steps).chunks(Block::STATES).enumerate() {
                let states = history.block(first).unwrap().unpack().unwrap();
                for (index, walls_read) in (first * Block::STATES..).zip(expected) {
                    let context = states.context(index).unwrap();
                    prop_assert_eq!(context.walls_read(), walls_read.as_ref(), "state {}", index);
                }
                prop_assert!(states.context(first * Block::STATES + expected.len()).is_none());
            }
        }
    }

    #[test]
    fn readings_at_the_pose_need_no_memory() {
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
