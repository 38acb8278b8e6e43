//! How much processor time work takes.

use std::time::Duration;

/// Does the work and measures the processor time that this thread spends on it: time in which others
/// have the processor does not count.
pub(super) fn measure<R>(work: impl FnOnce() -> R) -> (R, Duration) {
    let begin = thread_time();
    let result = work();
    (result, thread_time().saturating_sub(begin))
}

/// Processor time of this thread since some moment.
#[cfg(unix)]
fn thread_time() -> Duration {
    use rustix::time::{ClockId, clock_gettime};

    clock_gettime(ClockId::ThreadCPUTime).try_into().unwrap_or_default()
}

/// The time on the wall instead: Windows counts processor time in steps of 16 ms.
#[cfg(not(unix))]
fn thread_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;

    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

#[cfg(all(test, unix))]
mod tests {
    use std::thread;

    use super::*;

    /// A thread that sleeps has no processor, however busy the machine is.
    #[test]
    fn time_without_a_processor_does_not_count() {
        let pause = Duration::from_millis(200);
        let ((), time) = measure(|| thread::sleep(pause));
        assert!(time < pause, "{time:?}");
    }

    #[test]
    fn time_with_a_processor_counts() {
        let spent = Duration::from_millis(1);
        let begin = thread_time();
        let ((), time) = measure(|| while thread_time() < begin + spent {});
        assert!(time > Duration::ZERO && thread_time() >= begin + time, "{time:?}");
    }
}
