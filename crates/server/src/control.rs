//! Stopping and waking a server from other threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use mmsim_zmtp::Waker;

use crate::status::StatusCell;

/// The maximum time that [`StopHandle::stop`] waits.
const MAX_STOP_TIME: Duration = Duration::from_secs(1);

/// The state that a server shares with its monitors and stop handles.
pub(crate) struct Control {
    pub(crate) waker: Waker,
    pub(crate) status: StatusCell,
    is_stopping: AtomicBool,
    has_ended: Mutex<bool>,
    ended: Condvar,
}

impl Control {
    pub(crate) fn new(waker: Waker) -> Self {
        Self {
            waker,
            status: StatusCell::default(),
            is_stopping: AtomicBool::new(false),
            has_ended: Mutex::new(false),
            ended: Condvar::new(),
        }
    }

    pub(crate) fn is_stopping(&self) -> bool {
        self.is_stopping.load(Ordering::Acquire)
    }

    /// Reports the end of the server to those who wait for it.
    pub(crate) fn set_ended(&self) {
        *self.has_ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.ended.notify_all();
    }
}

/// Stops a [`Server`](crate::Server).
#[derive(Clone)]
pub struct StopHandle(pub(crate) Arc<Control>);

impl StopHandle {
    /// Stops the server after it has answered the requests that have arrived. Waits for it, but at
    /// most one second. Does nothing if the server has ended.
    pub fn stop(self) {
        let control = &*self.0;
        control.is_stopping.store(true, Ordering::Release);
        control.waker.wake();
        let has_ended = control.has_ended.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = control.ended.wait_timeout_while(has_ended, MAX_STOP_TIME, |ended| !*ended);
    }
}
