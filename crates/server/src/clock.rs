//! The time of day, by a clock that never goes back.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Tells nanoseconds since the beginning of 1970 (UTC). They never go back, even if somebody sets
/// the clock of the system meanwhile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    began: Instant,
    /// Nanoseconds since 1970 at that moment.
    since_epoch: u64,
}

impl Clock {
    pub(crate) fn start() -> Self {
        let since_epoch = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let since_epoch = u64::try_from(since_epoch.as_nanos()).unwrap_or(u64::MAX);
        Self { began: Instant::now(), since_epoch }
    }

    pub(crate) fn now(&self) -> u64 {
        let elapsed = u64::try_from(self.began.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.since_epoch.saturating_add(elapsed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_tells_the_time_of_day() {
        let clock = Clock::start();
        let (first, second) = (clock.now(), clock.now());
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
        assert!(first <= second && u128::from(second) <= now + 1_000_000_000);
        assert!(u128::from(first) + 60_000_000_000 > now);
    }
}
