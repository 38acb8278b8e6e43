//! Waits in unit tests, with a time limit. The package of this crate has no `mmsim-tests`.

use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

/// The time limit, long enough for a busy machine.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(300);

/// Polls until `poll` returns a value.
#[track_caller]
pub(crate) fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = poll() {
            return found;
        }
        assert!(start.elapsed() < TIMEOUT, "waited {TIMEOUT:?} for {what}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// Runs a function on a separate thread, because the function might block forever.
#[track_caller]
pub(crate) fn within<T: Send + 'static>(what: &str, run: impl FnOnce() -> T + Send + 'static) -> T {
    let (send, result) = mpsc::channel();
    // After a timeout there is no receiver.
    thread::spawn(move || drop(send.send(run())));
    result.recv_timeout(TIMEOUT).unwrap_or_else(|error| panic!("waiting for {what}: {error}"))
}
