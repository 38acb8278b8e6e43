//! The status and the stop handle that a server shares with other threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use mmsim_zmtp::Waker;

/// The maximum time that [`StopHandle::stop`] waits.
const MAX_STOP_TIME: Duration = Duration::from_secs(1);

/// The data that a server shares with its monitors and stop handles.
pub(crate) struct Control {
    pub(crate) waker: Waker,
    pub(crate) status: StatusCell,
    /// True if a connected client has searched the maze.
    pub(crate) has_client: AtomicBool,
    /// True if a client has sent the newest state or the newest `reset`.
    pub(crate) has_client_states: AtomicBool,
    /// True if the states are recorded.
    pub(crate) is_recorded: AtomicBool,
    /// The number of requests with annotations.
    pub(crate) annotations: AtomicU64,
    /// True while only this program may search the maze.
    pub(crate) is_reserved: AtomicBool,
    is_stopping: AtomicBool,
    has_ended: Mutex<bool>,
    ended: Condvar,
}

impl Control {
    pub(crate) fn new(waker: Waker) -> Self {
        Self {
            waker,
            status: StatusCell::default(),
            has_client: AtomicBool::new(false),
            has_client_states: AtomicBool::new(false),
            is_recorded: AtomicBool::new(false),
            annotations: AtomicU64::new(0),
            is_reserved: AtomicBool::new(false),
            is_stopping: AtomicBool::new(false),
            has_ended: Mutex::new(false),
            ended: Condvar::new(),
        }
    }

    pub(crate) fn is_stopping(&self) -> bool {
        self.is_stopping.load(Ordering::Acquire)
    }

    /// Wakes the threads that are waiting for the server to end.
    pub(crate) fn set_ended(&self) {
        *self.has_ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.ended.notify_all();
    }
}

/// Stops a [`Server`](crate::Server).
#[derive(Clone)]
pub struct StopHandle(pub(crate) Arc<Control>);

impl StopHandle {
    /// Stops the server after it has answered the requests that have already arrived. Waits at most
    /// one second for the server to stop. Does nothing if the server has already stopped.
    pub fn stop(self) {
        let control = &*self.0;
        control.is_stopping.store(true, Ordering::Release);
        control.waker.wake();
        let has_ended = control.has_ended.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = control.ended.wait_timeout_while(has_ended, MAX_STOP_TIME, |ended| !*ended);
    }
}

/// The current run number and the number of states in that run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// The run number. The first run is number 1, and every reset or new maze begins the next run.
    /// Before the server runs, the run number is 0.
    pub run: u32,
    /// The number of states in the current run.
    pub states: usize,
}

/// The number of bits in a [`StatusCell`] that hold the state count. The other 24 bits hold the run
/// number.
const STATES_BITS: u32 = 40;

/// The largest run number, after which the numbering restarts at 1.
pub(crate) const MAX_RUN: u32 = (1 << (64 - STATES_BITS)) - 1;

/// The current [`Status`] in one atomic word, which the server writes and any thread reads.
#[derive(Debug, Default)]
pub(crate) struct StatusCell(AtomicU64);

impl StatusCell {
    pub(crate) fn read(&self) -> Status {
        let word = self.0.load(Ordering::Acquire);
        let states = word & ((1 << STATES_BITS) - 1);
        Status {
            run: u32::try_from(word >> STATES_BITS).unwrap_or(MAX_RUN),
            states: usize::try_from(states).unwrap_or(usize::MAX),
        }
    }

    pub(crate) fn write(&self, Status { run, states }: Status) {
        self.0.store((u64::from(run) << STATES_BITS) | states as u64, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_returns_the_status_written() {
        let cell = StatusCell::default();
        assert_eq!(cell.read(), Status { run: 0, states: 0 });
        for (run, states) in [(1, 0), (7, 412), (MAX_RUN, (1 << STATES_BITS) - 1)] {
            let status = Status { run, states };
            cell.write(status);
            assert_eq!(cell.read(), status);
        }
    }
}
