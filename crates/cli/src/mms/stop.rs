//! Stopping a mouse: Ctrl-C, the time limit and the viewer page.

use std::time::Duration;

use mmsim_viewer::{MouseControl, StopReason};

use super::exit::ExitCause;

/// Waits that end early if the mouse must stop.
#[derive(Clone, Copy)]
pub(crate) struct Stop<'a> {
    pub(crate) control: &'a MouseControl,
    pub(crate) time_limit: Option<Duration>,
}

impl Stop<'_> {
    /// Waits for the given time. Returns an error as soon as the mouse must stop.
    pub(crate) fn wait(self, time: Duration) -> Result<(), ExitCause> {
        self.control.wait_for_stop(time).map_or(Ok(()), |reason| Err(self.cause(reason)))
    }

    /// Returns an error if the mouse must stop.
    pub(crate) fn check(self) -> Result<(), ExitCause> {
        self.wait(Duration::ZERO)
    }

    /// Waits until the mouse may take its next step. Returns an error if the mouse must stop.
    pub(crate) fn wait_for_step(self) -> Result<(), ExitCause> {
        if self.control.throttle().wait() { self.check() } else { Ok(()) }
    }

    fn cause(self, reason: StopReason) -> ExitCause {
        match (reason, self.time_limit) {
            (StopReason::Exit, _) => ExitCause::Interrupted,
            (StopReason::TimeLimit, Some(limit)) => ExitCause::TimeLimit(limit),
            _ => ExitCause::Stopped(reason),
        }
    }
}
