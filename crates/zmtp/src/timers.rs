//! The timers of the server's main loop. Functions that need the current time take it as an
//! argument.

use std::time::{Duration, Instant};

/// The delay before the server tries again to accept connections. The server waits after it has
/// turned clients away, and after the operating system has run out of descriptors or memory.
const RETRY_DELAY: Duration = Duration::from_millis(100);

/// A server that is shutting down stops answering requests when it has received no input for this
/// time.
const QUIET: Duration = Duration::from_millis(20);

/// Like [`QUIET`], but for a server with at least one connection that is not ready for requests.
const QUIET_UNREADY: Duration = Duration::from_millis(100);

/// A server that is shutting down stops answering requests after this time, even if input still
/// arrives.
const MAX_DRAIN: Duration = Duration::from_millis(300);

/// The maximum duration of a shutdown, including the time for sending the last replies.
const LINGER: Duration = Duration::from_millis(500);

/// The schedule for accepting connections. While the server cannot take more connections, it delays
/// its next attempt to accept one.
#[derive(Debug)]
pub(crate) struct AcceptBackoff {
    /// True if a connection may be waiting to be accepted.
    pub(crate) is_pending: bool,
    /// The time of the next attempt, or `None` if the next attempt is not delayed.
    pub(crate) retry_at: Option<Instant>,
}

impl AcceptBackoff {
    pub(crate) const fn new() -> Self {
        Self { is_pending: true, retry_at: None }
    }

    /// Delays the next attempt to accept a connection.
    pub(crate) fn back_off(&mut self, now: Instant) {
        self.retry_at = Some(now + RETRY_DELAY);
    }

    /// Returns true if the server should try to accept a connection now.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        self.is_pending && self.retry_at.is_none_or(|time| time <= now)
    }

    /// Returns the time of the next attempt, or `None` if the next attempt is not delayed or if no
    /// connection is waiting.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.retry_at.filter(|_| self.is_pending)
    }
}

/// The timer of a server that is shutting down but still answers requests that clients have already
/// sent.
#[derive(Debug)]
pub(crate) struct Drain {
    started: Instant,
    /// The time of the latest input.
    pub(crate) last_input: Instant,
}

impl Drain {
    pub(crate) const fn new(now: Instant) -> Self {
        Self { started: now, last_input: now }
    }

    /// Returns the time left for answering requests, or `None` if the time is up.
    pub(crate) fn time_left(&self, has_unready: bool, now: Instant) -> Option<Duration> {
        let quiet = if has_unready { QUIET_UNREADY } else { QUIET };
        let end = (self.started + MAX_DRAIN).min(self.last_input + quiet);
        end.checked_duration_since(now).filter(|left| !left.is_zero())
    }

    /// Returns the time left for sending replies, or `None` if the time is up.
    pub(crate) fn linger_left(&self, now: Instant) -> Option<Duration> {
        (self.started + LINGER).checked_duration_since(now).filter(|left| !left.is_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn attempts_are_delayed_until_the_deadline_or_a_close() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        assert!(accept.is_due(start));
        assert_eq!(accept.deadline(), None);
        accept.back_off(start);
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(!accept.is_due(start + RETRY_DELAY.saturating_sub(MS)));
        assert!(accept.is_due(start + RETRY_DELAY));
        accept.retry_at = None;
        assert!(accept.is_due(start));
    }

    #[test]
    fn no_attempt_is_due_while_no_connection_waits() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        accept.back_off(start);
        accept.is_pending = false;
        assert!(!accept.is_due(start + 2 * RETRY_DELAY));
        assert_eq!(accept.deadline(), None);
        accept.is_pending = true;
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(accept.is_due(start + RETRY_DELAY));
    }

    #[test]
    fn drain_ends_after_silence() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        assert_eq!(drain.time_left(false, start), Some(20 * MS));
        assert_eq!(drain.time_left(false, start + 20 * MS), None);
        assert_eq!(drain.time_left(true, start + 20 * MS), Some(80 * MS));
        drain.last_input = start + 15 * MS;
        assert_eq!(drain.time_left(false, start + 20 * MS), Some(15 * MS));
    }

    #[test]
    fn drain_ends_in_spite_of_input() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        drain.last_input = start + 290 * MS;
        assert_eq!(drain.time_left(true, start + 290 * MS), Some(10 * MS));
        assert_eq!(drain.time_left(true, start + 300 * MS), None);
        assert_eq!(drain.linger_left(start + 300 * MS), Some(200 * MS));
        assert_eq!(drain.linger_left(start + 500 * MS), None);
    }
}
