//! Measuring processor time.

use std::time::Duration;

/// Returns the processor time that this thread has used so far.
#[cfg(unix)]
pub(crate) fn thread_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};

    clock_gettime(ClockId::ThreadCPUTime).try_into().unwrap_or_default()
}

/// Returns the wall-clock time since the first call, because Windows measures the processor time
/// only in steps of 16 ms.
#[cfg(not(unix))]
pub(crate) fn thread_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;

    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn waiting_for_another_thread_does_not_count() {
        let spent = Duration::from_millis(50);
        let begin = thread_time();
        thread::spawn(move || while thread_time() < spent {}).join().unwrap();
        let time = thread_time().saturating_sub(begin);
        assert!(time < spent, "{time:?}");
    }

    #[test]
    fn computing_counts() {
        let spent = Duration::from_millis(1);
        let begin = thread_time();
        while thread_time() < begin + spent {}
        assert!(thread_time() >= begin + spent);
    }
}
