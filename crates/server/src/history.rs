//! Every state of a search, in the order in which they came.

use mmsim_maze::MazeSize;
use mmsim_protocol::state_bytes;

/// States in a block.
const BLOCK_STATES: usize = 256;

/// Every state since the last reset, as the bytes of its message.
///
/// States are kept in blocks, so that adding one never moves those before it.
#[derive(Clone, Debug)]
pub struct History {
    /// Length of a state in bytes, the same for all.
    state_bytes: usize,
    /// All blocks but the last are full.
    blocks: Vec<Vec<u8>>,
}

impl History {
    /// A history without a state, for a maze of this size.
    pub const fn new(size: MazeSize) -> Self {
        Self { state_bytes: state_bytes(size), blocks: Vec::new() }
    }

    /// How many states there are.
    pub fn len(&self) -> usize {
        self.blocks.last().map_or(0, |last| {
            (self.blocks.len() - 1) * BLOCK_STATES + last.len() / self.state_bytes
        })
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Adds a state. Gives `false` and adds nothing if the message has not the length of one.
    pub fn push(&mut self, state: &[u8]) -> bool {
        if state.len() != self.state_bytes {
            return false;
        }
        let full = BLOCK_STATES * self.state_bytes;
        if self.blocks.last().is_none_or(|block| block.len() == full) {
            self.blocks.push(Vec::with_capacity(full));
        }
        if let Some(block) = self.blocks.last_mut() {
            block.extend_from_slice(state);
        }
        true
    }

    /// The bytes of the state with this index, counted from 0.
    pub fn get(&self, index: usize) -> Option<&[u8]> {
        let start = index % BLOCK_STATES * self.state_bytes;
        self.blocks.get(index / BLOCK_STATES)?.get(start..start + self.state_bytes)
    }

    /// All states, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.blocks.iter().flat_map(|block| block.chunks_exact(self.state_bytes))
    }

    /// Forgets all states and frees their memory.
    pub fn clear(&mut self) {
        self.blocks = Vec::new();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(number: usize) -> Vec<u8> {
        number.to_le_bytes().into_iter().cycle().take(state_bytes(MazeSize::CLASSIC)).collect()
    }

    #[test]
    fn every_state_is_kept_across_blocks() {
        let mut history = History::new(MazeSize::CLASSIC);
        assert!(history.is_empty());
        for count in 0..3 * BLOCK_STATES + 7 {
            assert_eq!(history.len(), count);
            assert!(history.get(count).is_none());
            assert!(history.push(&state(count)));
        }
        for (index, kept) in history.iter().enumerate() {
            assert_eq!(kept, state(index));
            assert_eq!(history.get(index), Some(kept));
        }
        assert_eq!(history.iter().count(), history.len());
        history.clear();
        assert!(history.is_empty() && history.get(0).is_none());
        assert_eq!(history.len(), 0);
    }

    #[test]
    fn what_is_no_state_is_not_kept() {
        let mut history = History::new(MazeSize::CLASSIC);
        assert!(!history.push(b"S"));
        assert!(!history.push(&[b'S'; 519]));
        assert!(history.is_empty());
        assert!(history.get(usize::MAX).is_none());
    }
}
