//! Reads the states of a block in order, with their contexts.

use mmsim_maze::{MazeSize, Pose};
use mmsim_protocol::{State, StateMessage};

use crate::context::Context;
use crate::context::update::StoredUpdate;
use crate::history::block::States;
use crate::history::context_block::Updates;

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
        let context = self.contexts.first(self.size)?;
        let cursor = StateCursor { size: self.size, next: self.first, context };
        Some(StateScan { states: self, updates: self.contexts.updates(), cursor })
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

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;
    use mmsim_protocol::{Annotations, state_bytes};
    use proptest::prelude::*;

    use super::*;
    use crate::context::update_tracker::UpdateTracker;
    use crate::history::History;
    use crate::history::block::Block;

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
