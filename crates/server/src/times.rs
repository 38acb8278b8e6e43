//! When each state came, in few bytes.

use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Bytes after which a piece is closed.
const PIECE_BYTES: usize = 64 * 1024;

/// The times of the states of a history, each kept as the microseconds since the one before: one or
/// two bytes for a search at full speed.
#[derive(Clone, Debug)]
pub(crate) struct Times {
    /// When counting began, by the clock that never goes back, and in nanoseconds since 1970.
    began: (Instant, u64),
    /// Microseconds from there to the newest state.
    newest: u64,
    /// The same before the newest state came, for taking it back, and the bytes there were.
    before: (u64, usize),
    /// Microseconds between states, seven bits a byte, the lowest first; the last byte has its
    /// eighth bit clear. Older ones are in closed pieces, so that a copy of all is quick.
    pieces: Vec<Arc<[u8]>>,
    gaps: Vec<u8>,
}

impl Times {
    pub(crate) fn new() -> Self {
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let nanoseconds = u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX);
        let began = (Instant::now(), nanoseconds);
        Self { began, newest: 0, before: (0, 0), pieces: Vec::new(), gaps: Vec::new() }
    }

    /// How many bytes it holds.
    pub(crate) fn bytes(&self) -> usize {
        self.pieces.len() * PIECE_BYTES + self.gaps.len()
    }

    /// A state comes now.
    pub(crate) fn push(&mut self) {
        self.push_at(u64::try_from(self.began.0.elapsed().as_micros()).unwrap_or(u64::MAX));
    }

    fn push_at(&mut self, micros: u64) {
        if self.gaps.len() >= PIECE_BYTES {
            self.pieces.push(self.gaps.as_slice().into());
            self.gaps.clear();
        }
        self.before = (self.newest, self.gaps.len());
        let mut gap = micros.saturating_sub(self.newest);
        self.newest += gap;
        loop {
            let [low, ..] = gap.to_le_bytes();
            gap >>= 7;
            self.gaps.push(if gap > 0 { low | 0x80 } else { low });
            if gap == 0 {
                break;
            }
        }
    }

    /// The newest state has never come.
    pub(crate) fn take_back(&mut self) {
        self.newest = self.before.0;
        self.gaps.truncate(self.before.1);
    }

    /// Nanoseconds since 1970 (UTC) at which each state came.
    pub(crate) fn all(&self) -> Vec<u64> {
        let (mut times, mut time, mut gap, mut shift) = (Vec::new(), self.began.1, 0_u64, 0);
        for byte in self.pieces.iter().flat_map(|piece| &**piece).chain(&self.gaps) {
            gap |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                time = time.saturating_add(gap.saturating_mul(1000));
                times.push(time);
                (gap, shift) = (0, 0);
            }
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn times_come_back(gaps in prop::collection::vec((0u32..50).prop_map(|bits| (1u64 << bits) - 1), 0..50)) {
            let (mut times, mut expected, mut now) = (Times::new(), Vec::new(), 0);
            for gap in gaps {
                times.push_at(now + 77);
                times.take_back();
                now += gap;
                times.push_at(now);
                expected.push(times.began.1.saturating_add(now.saturating_mul(1000)));
            }
            prop_assert_eq!(times.all(), expected);
        }
    }

    #[test]
    fn times_come_back_from_closed_pieces() {
        let (mut times, count) = (Times::new(), 3 * PIECE_BYTES as u64);
        for micros in 0..count {
            times.push_at(micros);
            times.take_back();
            times.push_at(micros);
        }
        assert_eq!(times.bytes() as u64, count);
        let began = times.began.1;
        assert!(times.clone().all().into_iter().eq((0..count).map(|micros| began + micros * 1000)));
    }

    #[test]
    fn a_state_comes_now() {
        let mut times = Times::new();
        times.push();
        times.push();
        let [first, second] = times.all()[..] else { panic!() };
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
        assert!(first <= second && u128::from(second) <= now + 1_000_000_000);
        assert!(u128::from(first) + 60_000_000_000 > now);
    }
}
