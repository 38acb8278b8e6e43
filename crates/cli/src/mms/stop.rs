//! The reasons to stop a mouse that do not depend on its commands: Ctrl-C and the time limit.

use std::time::{Duration, Instant};

use super::exit::ExitCause;
use crate::interrupt::Interrupt;

/// Ends waits when the mouse must stop. Its time limit begins when it is created.
pub(crate) struct Stop<'a> {
    interrupt: &'a Interrupt,
    started: Instant,
    time_limit: Option<Duration>,
}

impl<'a> Stop<'a> {
    pub(crate) fn new(interrupt: &'a Interrupt, time_limit: Option<Duration>) -> Self {
        Self { interrupt, started: Instant::now(), time_limit }
    }

    /// Waits for the given time. Returns an error as soon as the mouse must stop.
    pub(crate) fn wait(&self, time: Duration) -> Result<(), ExitCause> {
        let left = self.time_limit.map(|limit| limit.saturating_sub(self.started.elapsed()));
        if self.interrupt.wait_for(left.map_or(time, |left| left.min(time))) {
            return Err(ExitCause::Interrupted);
        }
        match self.time_limit {
            Some(limit) if self.started.elapsed() >= limit => Err(ExitCause::TimeLimit(limit)),
            _ => Ok(()),
        }
    }

    /// Returns an error if the mouse must stop.
    pub(crate) fn check(&self) -> Result<(), ExitCause> {
        self.wait(Duration::ZERO)
    }
}
