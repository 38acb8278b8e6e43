//! How long a stopping server waits for requests that are on their way.

use std::time::{Duration, Instant};

/// The server stops when it has received nothing for this time …
const QUIET: Duration = Duration::from_millis(20);

/// … or for this time while a handshake or a skipped request is incomplete …
const QUIET_UNREADY: Duration = Duration::from_millis(100);

/// … and after this time in any case.
const MAX_DRAIN: Duration = Duration::from_millis(300);

/// The maximum time for sending the last replies, from the beginning of the drain.
const LINGER: Duration = Duration::from_millis(500);

/// The end of a server: it answers the requests that are on their way, then stops.
#[derive(Debug)]
pub(crate) struct Drain {
    started: Instant,
    last_input: Instant,
}

impl Drain {
    pub(crate) const fn new(now: Instant) -> Self {
        Self { started: now, last_input: now }
    }

    /// Records that something has arrived.
    pub(crate) const fn record_input(&mut self, now: Instant) {
        self.last_input = now;
    }

    /// Returns how long to wait for the next request, or `None` when the drain is over.
    pub(crate) fn time_left(&self, has_unready: bool, now: Instant) -> Option<Duration> {
        let quiet = if has_unready { QUIET_UNREADY } else { QUIET };
        let end = (self.started + MAX_DRAIN).min(self.last_input + quiet);
        Some(end.saturating_duration_since(now)).filter(|left| !left.is_zero())
    }

    /// Returns the deadline for sending the last replies.
    pub(crate) fn linger_deadline(&self) -> Instant {
        self.started + LINGER
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn drain_ends_after_silence() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        assert_eq!(drain.time_left(false, start), Some(20 * MS));
        assert_eq!(drain.time_left(false, start + 20 * MS), None);
        assert_eq!(drain.time_left(true, start + 20 * MS), Some(80 * MS));
        drain.record_input(start + 15 * MS);
        assert_eq!(drain.time_left(false, start + 20 * MS), Some(15 * MS));
    }

    #[test]
    fn drain_ends_in_spite_of_input() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        drain.record_input(start + 290 * MS);
        assert_eq!(drain.time_left(true, start + 290 * MS), Some(10 * MS));
        assert_eq!(drain.time_left(true, start + 300 * MS), None);
        assert_eq!(drain.linger_deadline(), start + 500 * MS);
    }
}
