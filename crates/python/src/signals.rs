//! Checks for signals, so that Ctrl-C interrupts long calls.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::Error;

/// The time between two checks.
pub(crate) const INTERVAL: Duration = Duration::from_millis(50);

/// Runs Python's signal handlers, and returns their exception.
// The method itself is not general enough for `attach`.
#[allow(clippy::redundant_closure_for_method_calls)]
pub(crate) fn check() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}

/// Runs work in another thread, and checks for signals in the meantime. The flag is set when the work
/// must end, because a signal handler has raised an exception.
pub(crate) fn interruptible<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Arc<AtomicBool>) -> R + Send,
) -> PyResult<R> {
    let must_stop = Arc::new(AtomicBool::new(false));
    py.detach(|| {
        thread::scope(|scope| {
            let (done, ended) = mpsc::channel::<()>();
            let flag = Arc::clone(&must_stop);
            let work = move || {
                let _done = done;
                work(&flag)
            };
            let thread = thread::Builder::new().spawn_scoped(scope, work)?;
            let mut checked = Ok(());
            while ended.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if checked.is_ok() {
                    checked = check();
                    must_stop.store(checked.is_err(), Ordering::Relaxed);
                }
            }
            let result = thread.join().map_err(|_| Error::new_err("failed unexpectedly"))?;
            checked.map(|()| result)
        })
    })
}
