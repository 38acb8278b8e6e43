//! Copies of up to 256 consecutive states of a history, which can be read on other threads.

use std::sync::Arc;

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{StateMessage, state_bytes};

use crate::compressor::decompress;
use crate::context::Context;
use crate::context_block::{ContextBlock, Updates};
use crate::phases::Phases;
use crate::transition::{Course, Transition};
use crate::update::{Events, StoredUpdate};

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
    /// The phases at the first state of this block.
    pub(crate) phases: Phases,
    pub(crate) course: Arc<Course>,
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

    /// Returns the phases of the states from the first state of the history to the state with this
    /// index.
    pub fn phases(&self, index: usize) -> Option<Phases> {
        self.get(index)?;
        let mut phases = self.phases;
        let mut updates = self.contexts.updates();
        for index in self.first + 1..=index {
            let (from, to) = (self.pose(index - 1)?, self.pose(index)?);
            let events = Events::from_update(updates.seek(index - self.first), self.size);
            let transition = self.course.transition_after(events, from, to);
            phases.add(&self.course, index, transition, to);
        }
        Some(phases)
    }

    /// Returns the transition from the pose `from` to the state with this index.
    pub fn transition(&self, from: Pose, index: usize) -> Option<Transition> {
        self.transitions().to(index, from)
    }

    /// Returns the transitions to states of this block, for reading them in ascending order. Each
    /// [`transition`](Self::transition) alone skips the updates of all earlier states.
    pub fn transitions(&self) -> Transitions<'_> {
        Transitions { states: self, updates: self.contexts.updates() }
    }

    /// Returns the start, the goal and the walls of the maze.
    pub fn course(&self) -> &Course {
        &self.course
    }

    pub(crate) fn pose(&self, index: usize) -> Option<Pose> {
        self.message(index)?.pose().ok()
    }
}

/// The transitions to the states of a block. See [`States::transitions`].
#[derive(Clone, Debug)]
pub struct Transitions<'a> {
    states: &'a States,
    updates: Updates<'a>,
}

impl Transitions<'_> {
    /// Returns the transition from the pose `from` to the state with this index, which must be
    /// greater than the previous index.
    pub fn to(&mut self, index: usize, from: Pose) -> Option<Transition> {
        let States { course, size, first, .. } = self.states;
        let to = self.states.pose(index)?;
        let update = self.updates.seek(index - first);
        Some(course.transition_after(Events::from_update(update, *size), from, to))
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading};
    use mmsim_protocol::Annotations;
    use proptest::prelude::*;

    use super::*;
    use crate::history::History;
    use crate::update::{Readings, Update};
    use crate::update_tracker::UpdateTracker;

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
                // The annotation makes the state a restart, whatever its pose.
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
            let course = Course::from_size(size);
            let pose = |index: usize| {
                let (x, y, heading) = poses[index];
                Pose::new(Cell::new(x, y), Heading::ALL[heading])
            };
            let transition = |index: usize| {
                let moved = || course.transition(pose(index - 1), pose(index));
                if restarts[index] { Transition::Restart } else { moved() }
            };
            for (index, count) in reads {
                let states = history.block(index / Block::STATES).and_then(Block::unpack);
                let got = states.as_ref().and_then(|states| states.get(index)).map(<[u8]>::to_vec);
                prop_assert_eq!(&got, &history.get(index));
                let mut phases = Phases::default();
                phases.arrive(&course, pose(0));
                for index in 1..=index.min(poses.len() - 1) {
                    phases.add(&course, index, transition(index), pose(index));
                }
                let found = states.as_ref().and_then(|states| states.phases(index));
                prop_assert_eq!(found, (index < poses.len()).then_some(phases));
                if let Some(states) = states.filter(|_| got.is_some()) {
                    let end = (index + count).min(poses.len()).min(states.first + states.len());
                    let expected: Vec<u8> = poses[index..end].iter().flat_map(state).collect();
                    prop_assert_eq!(states.range(index, count), expected);
                    let mut transitions = states.transitions();
                    for index in index.max(1)..end {
                        let expected = Some(transition(index));
                        let from = pose(index - 1);
                        prop_assert_eq!(transitions.to(index, from), expected);
                        prop_assert_eq!(states.transition(from, index), expected);
                    }
                }
            }
            prop_assert!(history.block(poses.len().div_ceil(Block::STATES)).is_none());
        }
    }
}
