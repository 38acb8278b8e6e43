//! Monotonic time of day.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// A clock that returns nanoseconds since 1970 (UTC) and never goes back, even if the system clock
/// is set.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    /// Nanoseconds since 1970 at `started`.
    since_epoch: u64,
}

impl Clock {
    /// Creates a clock that agrees with the system clock now.
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
    use super::*;

    #[test]
    fn now_is_the_time_of_day() {
        let clock = Clock::start();
        let (first, second) = (clock.now(), clock.now());
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos();
        assert!(first <= second && u128::from(second) <= now + 1_000_000_000);
        assert!(u128::from(first) + 60_000_000_000 > now);
    }
}
