//! Reads the states of a block in order, with their phases and contexts.

use crate::block::States;
use crate::context::Context;
use crate::context_block::Updates;
use crate::phases::Phases;
use crate::update::{Events, StoredUpdate};

/// Reads the states of a block in order. [`States::phases`] and [`States::context`] start at the
/// beginning of the block for each state, but a scan computes each phase and context from the
/// previous one.
///
/// ```
/// use mmsim_recording::History;
/// let mut history = History::new(mmsim_maze::MazeSize::new(2, 1)?);
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// let states = history.block(0).and_then(|block| block.unpack()).expect("a block");
/// let mut scan = states.scan().expect("an intact block");
/// let mut steps = Vec::new();
/// while let Some(state) = scan.advance() {
///     steps.push((state.index, state.phases.total.steps));
/// }
/// assert_eq!(steps, [(0, 0), (1, 1)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StateScan<'a> {
    states: &'a States,
    updates: Updates<'a>,
    /// The index of the next state.
    next: usize,
    phases: Phases,
    context: Context,
}

/// A state that a [`StateScan`] has read.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ScannedState<'s> {
    /// The index of the state in the whole history.
    pub index: usize,
    /// The message `S`.
    pub message: &'s [u8],
    /// The phases up to this state.
    pub phases: &'s Phases,
    /// The context of this state.
    pub context: &'s Context,
    /// True if the context may differ from that of the previous state.
    pub is_context_new: bool,
    /// The number of log lines that precede this state.
    pub log_lines: usize,
}

impl States {
    /// Starts a scan at the first state of this block. Returns `None` if the block is damaged.
    pub fn scan(&self) -> Option<StateScan<'_>> {
        Some(StateScan {
            states: self,
            updates: self.contexts.updates(),
            next: self.first,
            phases: self.phases,
            context: self.contexts.first(self.size)?,
        })
    }
}

impl StateScan<'_> {
    /// Reads the next state. Returns `None` after the last state or if the block is damaged.
    pub fn advance(&mut self) -> Option<ScannedState<'_>> {
        let Self { states, updates, next, phases, context } = self;
        let (index, size) = (*next, states.size);
        let message = states.get(index)?;
        let update = updates.seek(index - states.first);
        let pose = states.pose(index)?;
        if index > states.first {
            let events = Events::from_update(update, size);
            let from = states.pose(index - 1)?;
            let transition = states.course.transition_after(events, from, pose);
            phases.add(&states.course, index, transition, pose);
        }
        let update = StoredUpdate::decode(update, size).ok()?;
        let is_context_new = context.apply(Some(pose), &update);
        let log_lines = update.changes.events().lines;
        *next += 1;
        Some(ScannedState { index, message, phases, context, is_context_new, log_lines })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;
    use mmsim_protocol::{Annotations, state_bytes};
    use proptest::prelude::*;

    use super::*;
    use crate::block::Block;
    use crate::history::History;
    use crate::update_tracker::UpdateTracker;

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
                    prop_assert_eq!(Some(*state.phases), block.phases(count));
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
