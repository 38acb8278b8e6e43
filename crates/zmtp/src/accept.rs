//! When to accept the next connection.

use std::time::{Duration, Instant};

/// Delay before the next attempt to accept, after the system had no descriptor or memory left, or
/// newcomers were turned away.
const RETRY_DELAY: Duration = Duration::from_millis(100);

/// Tracks whether connections wait to be accepted, and delays attempts that would fail.
#[derive(Debug)]
pub(crate) struct AcceptBackoff {
    is_pending: bool,
    /// Set while attempts are delayed.
    retry_at: Option<Instant>,
}

impl AcceptBackoff {
    pub(crate) const fn new() -> Self {
        Self { is_pending: true, retry_at: None }
    }

    /// Records that a connection may wait to be accepted.
    pub(crate) const fn set_pending(&mut self) {
        self.is_pending = true;
    }

    /// Records that no connection waits.
    pub(crate) const fn clear_pending(&mut self) {
        self.is_pending = false;
    }

    /// Delays the next attempt.
    pub(crate) fn back_off(&mut self, now: Instant) {
        self.retry_at = Some(now + RETRY_DELAY);
    }

    /// Ends a delay: a connection has closed, so there is room for another.
    pub(crate) const fn end_delay(&mut self) {
        self.retry_at = None;
    }

    /// Returns whether to try now.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        self.is_pending && self.retry_at.is_none_or(|time| time <= now)
    }

    /// Returns the time of the next attempt if it is delayed and a connection waits.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.retry_at.filter(|_| self.is_pending)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attempts_are_delayed_until_the_deadline_or_a_close() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        assert!(accept.is_due(start));
        assert_eq!(accept.deadline(), None);
        accept.back_off(start);
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(!accept.is_due(start + RETRY_DELAY.saturating_sub(Duration::from_millis(1))));
        assert!(accept.is_due(start + RETRY_DELAY));
        accept.end_delay();
        assert!(accept.is_due(start));
    }

    #[test]
    fn nothing_is_due_while_nobody_waits() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        accept.back_off(start);
        accept.clear_pending();
        assert!(!accept.is_due(start + 2 * RETRY_DELAY));
        assert_eq!(accept.deadline(), None);
        accept.set_pending();
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(accept.is_due(start + RETRY_DELAY));
    }
}
