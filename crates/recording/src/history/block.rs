//! Copies of up to 256 consecutive states of a history, which can be read on other threads.

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{StateMessage, state_bytes};

use crate::context::Context;
use crate::context::update::{Events, StoredUpdate};
use crate::history::compressor::decompress;
use crate::history::context_block::ContextBlock;

/// A copy of up to 256 consecutive states of a [`History`](crate::History), possibly compressed.
#[derive(Clone, Debug)]
pub struct Block {
    /// The states, compressed if `packed` is true.
    pub(crate) states: States,
    pub(crate) packed: bool,
}

/// Up to 256 consecutive uncompressed states of a history.
#[derive(Clone, Debug)]
pub struct States {
    pub(crate) first: usize,
    pub(crate) size: MazeSize,
    pub(crate) bytes: Vec<u8>,
    /// The contexts of the states, which are compressed if the states belong to a [`Block`].
    pub(crate) contexts: ContextBlock,
}

impl Block {
    /// The number of states in every block except the last.
    pub const STATES: usize = 256;

    /// Decompresses the states. Returns `None` if memory runs out.
    pub fn unpack(self) -> Option<States> {
        let Self { states, packed } = self;
        let length =
            if packed { Self::STATES * state_bytes(states.size) } else { states.bytes.len() };
        let bytes = decompress(states.bytes, length).ok()?;
        Some(States { bytes, contexts: states.contexts.unpack().ok()?, ..states })
    }
}

impl States {
    /// Returns the number of states.
    pub const fn len(&self) -> usize {
        self.bytes.len() / state_bytes(self.size)
    }

    /// Returns true if there are no states. A block that was copied from a history has at least one
    /// state.
    pub const fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Returns the memory that the states use, in bytes.
    pub fn memory(&self) -> usize {
        self.bytes.len() + self.contexts.bytes()
    }

    /// Returns the state with this index in the whole history.
    pub fn get(&self, index: usize) -> Option<&[u8]> {
        let length = state_bytes(self.size);
        let start = index.checked_sub(self.first)?.checked_mul(length)?;
        self.bytes.get(start..start.checked_add(length)?)
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
        let end = end.min(self.bytes.len());
        self.bytes.get(start..end).unwrap_or_default()
    }

    /// Returns the context of the state with this index.
    pub fn context(&self, index: usize) -> Option<Context> {
        let last = index - self.get(index).map(|_| self.first)?;
        let (mut context, mut updates) = (self.contexts.first(self.size)?, self.contexts.updates());
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
        Some(self.contexts.updates().seek(at))
    }

    /// Iterates over the states of this block from the index `from` in the whole history: the pose, or
    /// `None` if it is invalid, and true if the mouse was put back at the start before the state.
    pub fn poses(&self, from: usize) -> impl Iterator<Item = (Option<Pose>, bool)> {
        let mut updates = self.contexts.updates();
        (from.max(self.first)..self.first + self.len()).map(move |index| {
            let events = Events::from_update(updates.seek(index - self.first), self.size);
            let pose = self.message(index).and_then(|message| message.pose().ok());
            (pose, events.has_restart)
        })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading};
    use mmsim_protocol::Annotations;
    use proptest::prelude::*;

    use super::*;
    use crate::context::update::{Readings, Update};
    use crate::context::update_tracker::UpdateTracker;
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
}
