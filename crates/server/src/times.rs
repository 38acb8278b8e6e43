//! When each state came, in few bytes.

use std::collections::TryReserveError;
use std::mem;
use std::sync::Arc;

use crate::memory::reserve;

/// Bytes after which a piece is closed.
const PIECE_BYTES: usize = 64 * 1024;

/// The longest gap in bytes: 64 bits, seven in a byte.
const GAP_BYTES: usize = 10;

/// The times of the states of a history, each kept as the time since the one before: one or two
/// bytes for a search at full speed. A copy is quick.
#[derive(Clone, Debug)]
pub struct Times {
    /// Nanoseconds in a tick; times are rounded down to it.
    tick_ns: u64,
    count: usize,
    /// Ticks from the beginning of 1970 to the newest state.
    newest: u64,
    /// The same before the newest state came, for taking it back, and the bytes there were.
    before: (u64, usize),
    /// Ticks between states, seven bits a byte, the lowest first; the last byte has its eighth bit
    /// clear. Older ones are in closed pieces, which copies share.
    pieces: Vec<Arc<Vec<u8>>>,
    gaps: Vec<u8>,
}

impl Times {
    /// No times yet, to be kept to the tick.
    pub(crate) const fn new(tick_ns: u64) -> Self {
        Self { tick_ns, count: 0, newest: 0, before: (0, 0), pieces: Vec::new(), gaps: Vec::new() }
    }

    /// Returns the number of times.
    pub const fn len(&self) -> usize {
        self.count
    }

    /// Returns whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the number of bytes that it holds.
    pub(crate) const fn bytes(&self) -> usize {
        self.pieces.len() * PIECE_BYTES + self.gaps.len()
    }

    /// Adds the time of another state, in nanoseconds since the beginning of 1970.
    pub(crate) fn push(&mut self, time: u64) -> Result<(), TryReserveError> {
        if self.gaps.len() + GAP_BYTES > PIECE_BYTES {
            let mut next = Vec::new();
            reserve(&mut next, PIECE_BYTES)?;
            reserve(&mut self.pieces, 1)?;
            self.pieces.push(Arc::new(mem::replace(&mut self.gaps, next)));
        } else {
            let room = PIECE_BYTES - self.gaps.len();
            reserve(&mut self.gaps, room)?;
        }
        self.before = (self.newest, self.gaps.len());
        let ticks = time / self.tick_ns;
        // Times of other tools may go back, which makes this a very large gap.
        let mut gap = ticks.wrapping_sub(self.newest);
        self.newest = ticks;
        self.count += 1;
        loop {
            let [low, ..] = gap.to_le_bytes();
            gap >>= 7;
            self.gaps.push(if gap > 0 { low | 0x80 } else { low });
            if gap == 0 {
                return Ok(());
            }
        }
    }

    /// Forgets the newest time, once.
    pub(crate) fn take_back(&mut self) {
        self.newest = self.before.0;
        self.gaps.truncate(self.before.1);
        self.count -= 1;
    }

    /// Returns the newest time, in nanoseconds since the beginning of 1970 (UTC).
    pub fn last(&self) -> Option<u64> {
        (self.count > 0).then_some(self.newest * self.tick_ns)
    }

    /// Iterates over all times, in nanoseconds since the beginning of 1970 (UTC).
    pub fn iter(&self) -> impl Iterator<Item = u64> {
        let (mut time, mut gap, mut shift) = (0_u64, 0_u64, 0);
        let closed = self.pieces.iter().flat_map(|piece| piece.iter());
        closed.chain(&self.gaps).filter_map(move |byte| {
            gap |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 != 0 {
                return None;
            }
            time = time.wrapping_add(gap);
            (gap, shift) = (0, 0);
            Some(time * self.tick_ns)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn times_come_back(times in prop::collection::vec((any::<u64>(), 0u32..64), 0..50)) {
            for tick_ns in [1, 1000] {
                let (mut kept, mut expected) = (Times::new(tick_ns), Vec::new());
                for (time, shift) in &times {
                    kept.push(77).unwrap();
                    kept.take_back();
                    kept.push(time >> shift).unwrap();
                    expected.push((time >> shift) / tick_ns * tick_ns);
                }
                prop_assert_eq!(kept.iter().collect::<Vec<_>>(), expected.clone());
                prop_assert_eq!((kept.len(), kept.last()), (expected.len(), expected.last().copied()));
            }
        }
    }

    #[test]
    fn times_come_back_from_closed_pieces() {
        let (mut times, count) = (Times::new(1000), 3 * PIECE_BYTES as u64);
        for micros in 0..count {
            for _ in 0..2 {
                times.push(micros * 1000).unwrap();
                times.take_back();
            }
            times.push(micros * 1000 + 999).unwrap();
        }
        assert_eq!(times.pieces.len(), 3);
        assert!(times.pieces.iter().all(|piece| piece.capacity() == PIECE_BYTES));
        assert!((times.bytes() as u64).abs_diff(count) < 100, "a byte each");
        assert!(times.clone().iter().eq((0..count).map(|micros| micros * 1000)));
    }
}
