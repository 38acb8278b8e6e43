//! The times of states in compact form, and the clock that measures them.

use std::mem;
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use crate::context::changes::put_number;
use crate::memory::{OutOfMemory, reserve};

/// The capacity of a chunk in bytes. To read a time, the gaps of its chunk up to the time are decoded.
const CHUNK_BYTES: usize = 4 * 1024;

/// The maximum length of an encoded gap between two times, in bytes. A gap is a 64-bit number, and
/// each byte encodes seven bits of the gap.
const GAP_BYTES: usize = 10;

/// The times of the states of a history.
///
/// Each time is stored as the gap since the previous time, in a variable number of bytes. When
/// a search runs at full speed, each gap takes one or two bytes. Cloning is cheap.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// Nanoseconds per tick. Times are rounded down to whole ticks.
    tick_ns: u64,
    count: usize,
    /// The time of the newest state in ticks since 1970.
    newest: u64,
    /// The values of `newest` and `gaps.len()` before the last `push`. `undo_push` restores these
    /// values.
    previous: (u64, usize),
    /// The gaps before those in `gaps`, in the same encoding. Clones of the list share these full
    /// chunks.
    chunks: Vec<Arc<Vec<u8>>>,
    /// For each full chunk, the number of times and the newest time in ticks at its end.
    ends: Vec<(usize, u64)>,
    /// The ticks between states, encoded in LEB128: seven bits per byte, lowest bits first. The
    /// high bit is set in every byte of a gap except the last byte.
    gaps: Vec<u8>,
}

impl Times {
    /// Creates an empty list that stores times in units of `tick_ns` nanoseconds. If `tick_ns` is
    /// 0, the unit is one nanosecond.
    pub fn new(tick_ns: u64) -> Self {
        Self { tick_ns: tick_ns.max(1), ..Self::default() }
    }

    /// Returns the number of stored times.
    pub const fn len(&self) -> usize {
        self.count
    }

    /// Returns true if the list is empty.
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the memory in use, in bytes.
    pub const fn bytes(&self) -> usize {
        self.chunks.len() * CHUNK_BYTES + self.gaps.len()
    }

    /// Appends the time of a state, in nanoseconds since 1970 (UTC).
    ///
    /// # Errors
    /// The system is out of memory. On error, the list stays unchanged.
    pub fn push(&mut self, time: u64) -> Result<(), OutOfMemory> {
        if self.gaps.len() + GAP_BYTES > CHUNK_BYTES {
            let mut next = Vec::new();
            reserve(&mut next, CHUNK_BYTES)?;
            reserve(&mut self.chunks, 1)?;
            reserve(&mut self.ends, 1)?;
            self.ends.push((self.count, self.newest));
            self.chunks.push(Arc::new(mem::replace(&mut self.gaps, next)));
        } else {
            let room = CHUNK_BYTES - self.gaps.len();
            reserve(&mut self.gaps, room)?;
        }
        self.previous = (self.newest, self.gaps.len());
        let ticks = time / self.tick_ns;
        // The times in recordings of other tools may decrease, so the gap may wrap around.
        put_number(&mut self.gaps, ticks.wrapping_sub(self.newest));
        self.newest = ticks;
        self.count += 1;
        Ok(())
    }

    /// Removes the newest time. `undo_push` works only once after each [`push`](Self::push).
    pub fn undo_push(&mut self) {
        self.newest = self.previous.0;
        self.gaps.truncate(self.previous.1);
        self.count = self.count.saturating_sub(1);
    }

    /// Returns the newest time, in nanoseconds since 1970 (UTC).
    pub fn last(&self) -> Option<u64> {
        (self.count > 0).then_some(self.newest * self.tick_ns)
    }

    /// Returns the time of the state with this index, in nanoseconds since 1970 (UTC).
    pub fn get(&self, index: usize) -> Option<u64> {
        let chunk = self.ends.partition_point(|&(count, _)| count <= index);
        let before = chunk.checked_sub(1).and_then(|chunk| self.ends.get(chunk));
        let &(count, time) = before.unwrap_or(&(0, 0));
        let gaps = self.chunks.get(chunk).map_or(&*self.gaps, |chunk| chunk);
        self.decode(gaps, time).nth(index - count)
    }

    /// Returns the time between two states in seconds. A missing time counts as 0 s.
    #[expect(clippy::cast_precision_loss, reason = "times below 2^53 ns (104 days) are exact")]
    pub fn seconds(&self, first: usize, last: usize) -> f64 {
        let between = self.get(first).zip(self.get(last));
        between.map_or(0., |(first, last)| last.saturating_sub(first) as f64 / 1e9)
    }

    /// Iterates over all times, in nanoseconds since 1970 (UTC).
    pub fn iter(&self) -> impl Iterator<Item = u64> {
        self.decode(self.chunks.iter().flat_map(|chunk| chunk.iter()).chain(&self.gaps), 0)
    }

    /// Decodes gaps that follow the time `time` in ticks.
    fn decode<'a>(
        &self,
        gaps: impl IntoIterator<Item = &'a u8>,
        mut time: u64,
    ) -> impl Iterator<Item = u64> {
        let (mut gap, mut shift, tick_ns) = (0_u64, 0, self.tick_ns);
        gaps.into_iter().filter_map(move |byte| {
            gap |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 != 0 {
                return None;
            }
            time = time.wrapping_add(gap);
            (gap, shift) = (0, 0);
            Some(time * tick_ns)
        })
    }
}

/// A clock that returns nanoseconds since 1970 (UTC) and never goes back, even if the system clock
/// is set back.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    /// The system time at `started`, in nanoseconds since 1970 (UTC).
    since_epoch: u64,
}

impl Clock {
    /// Creates a clock that starts at the current time of the system clock.
    pub fn start() -> Self {
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let since_epoch = u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX);
        Self { started: Instant::now(), since_epoch }
    }

    /// Returns the current time in nanoseconds since 1970 (UTC).
    pub fn now(&self) -> u64 {
        let elapsed = u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.since_epoch.saturating_add(elapsed)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn times_are_stored_to_the_tick(times in prop::collection::vec((any::<u64>(), 0u32..64), 0..50)) {
            for tick_ns in [1, 1000] {
                let (mut kept, mut expected) = (Times::new(tick_ns), Vec::new());
                for (time, shift) in &times {
                    kept.push(77).unwrap();
                    kept.undo_push();
                    kept.push(time >> shift).unwrap();
                    expected.push((time >> shift) / tick_ns * tick_ns);
                }
                prop_assert_eq!(kept.iter().collect::<Vec<_>>(), expected.clone());
                prop_assert_eq!((kept.len(), kept.last()), (expected.len(), expected.last().copied()));
                let each: Vec<_> = (0..=expected.len()).map_while(|index| kept.get(index)).collect();
                prop_assert_eq!(each, expected);
            }
        }
    }

    #[test]
    fn times_survive_across_chunks() {
        let (mut times, count) = (Times::new(1000), 3 * CHUNK_BYTES as u64);
        for micros in 0..count {
            for _ in 0..2 {
                times.push(micros * 1000).unwrap();
                times.undo_push();
            }
            times.push(micros * 1000 + 999).unwrap();
        }
        assert_eq!(times.chunks.len(), 3);
        assert!(times.chunks.iter().all(|chunk| chunk.capacity() == CHUNK_BYTES));
        assert!((times.bytes() as u64).abs_diff(count) < 100, "a byte each");
        assert!(times.clone().iter().eq((0..count).map(|micros| micros * 1000)));
        let chunk = CHUNK_BYTES as u64;
        for micros in (0..count).step_by(999).chain(chunk - 20..chunk + 20).chain([count - 1]) {
            let index = usize::try_from(micros).unwrap();
            assert_eq!(times.get(index), Some(micros * 1000));
        }
        assert_eq!(times.get(times.len()), None);
    }

    #[test]
    fn now_is_the_time_of_day() {
        let clock = Clock::start();
        let (first, second) = (clock.now(), clock.now());
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
        assert!(first <= second && u128::from(second) <= now + 1_000_000_000);
        assert!(u128::from(first) + 60_000_000_000 > now);
    }
}
