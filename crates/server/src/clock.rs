//! A monotonic clock with the time of day.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Nanoseconds since the beginning of 1970 (UTC). They never decrease, even if somebody changes the
/// system's clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    started: Instant,
    /// Nanoseconds since 1970 when the clock started.
    since_epoch: u64,
}

impl Clock {
    pub(crate) fn start() -> Self {
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let since_epoch = u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX);
        Self { started: Instant::now(), since_epoch }
    }

    pub(crate) fn now(&self) -> u64 {
        let elapsed = u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.since_epoch.saturating_add(elapsed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_returns_the_time_of_day() {
        let clock = Clock::start();
        let (first, second) = (clock.now(), clock.now());
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
        assert!(first <= second && u128::from(second) <= now + 1_000_000_000);
        assert!(u128::from(first) + 60_000_000_000 > now);
    }
}
