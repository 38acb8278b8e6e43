//! Runs work in parallel on all processors.

use rayon::prelude::*;

/// Calls `work` for each item on the threads of the current pool. Returns the results in the order
/// of the items.
pub(crate) fn map_each<'a, T: Sync, R: Send>(
    items: &'a [T],
    work: impl Fn(&'a T) -> R + Send + Sync,
) -> Vec<R> {
    // Each item is a separate task, because neighbouring items may take a thousand times as long as
    // others.
    items.par_iter().with_max_len(1).map(work).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::{Condvar, Mutex};
    use std::time::Duration;

    use rayon::ThreadPoolBuilder;

    use super::*;

    /// Checks that the last two items run in parallel: the work for each waits until the work for
    /// the other has started.
    #[test]
    fn neighbours_run_in_parallel_and_keep_their_order() {
        let items: Vec<usize> = (0..1000).collect();
        let (working, changed) = (Mutex::new(0), Condvar::new());
        let work = |&item: &usize| {
            if item >= items.len() - 2 {
                let mut working = working.lock().unwrap();
                *working += 1;
                changed.notify_all();
                let timeout = Duration::from_secs(30);
                let waited = changed.wait_timeout_while(working, timeout, |working| *working < 2);
                assert!(!waited.unwrap().1.timed_out(), "one thread runs both last items");
            }
            2 * item
        };
        let pool = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let results = pool.install(|| map_each(&items, work));
        assert!(results.into_iter().eq(items.iter().map(|item| 2 * item)));
    }
}
