//! Runs work in parallel on all processors.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Calls `work` for each item, on one thread per processor. Returns the results in the order of the
/// items.
pub(crate) fn map_each<'a, T: Sync, R: Send>(
    items: &'a [T],
    work: impl Fn(&'a T) -> R + Sync,
) -> Vec<R> {
    map_on(thread::available_parallelism().map_or(1, NonZero::get), items, work)
}

/// Like [`map_each`], but uses at most this many threads.
pub(crate) fn map_on<'a, T: Sync, R: Send>(
    threads: usize,
    items: &'a [T],
    work: impl Fn(&'a T) -> R + Sync,
) -> Vec<R> {
    map_with_permits(threads, items, || (), |item, ()| work(item))
}

/// Like [`map_on`], but each thread acquires a permit before it takes an item. So the work begins in
/// the order of the items, even if threads wait for a permit.
pub(crate) fn map_with_permits<'a, T: Sync, P, R: Send>(
    threads: usize,
    items: &'a [T],
    acquire: impl Fn() -> P + Sync,
    work: impl Fn(&'a T, P) -> R + Sync,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    // Each thread takes one item at a time, because neighbouring items may take a thousand times as
    // long as others.
    let take = || {
        let permit = acquire();
        let index = next.fetch_add(1, Ordering::Relaxed);
        items.get(index).map(|item| (index, work(item, permit)))
    };
    let run = || std::iter::from_fn(take).collect::<Vec<_>>();
    let mut results = thread::scope(|scope| {
        // If the system cannot create a thread, the others do its work.
        let spawn = |_| thread::Builder::new().spawn_scoped(scope, run).ok();
        let others: Vec<_> = (1..threads.min(items.len())).filter_map(spawn).collect();
        let mut results = run();
        for thread in others {
            results.extend(thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        results
    });
    results.sort_unstable_by_key(|&(index, _)| index);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::{Condvar, Mutex};
    use std::time::Duration;

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
        let results = map_on(2, &items, work);
        assert!(results.into_iter().eq(items.iter().map(|item| 2 * item)));
    }
    #[test]
    fn every_number_of_threads_gives_all_results() {
        for (threads, count) in [(1, 9), (9, 1), (3, 0), (7, 100), (0, 2)] {
            let items: Vec<usize> = (0..count).collect();
            assert_eq!(map_on(threads, &items, |&item| item), items, "{threads} threads");
        }
        assert_eq!(map_each(&[1, 2], |item| item + 1), [2, 3]);
    }

    #[test]
    #[should_panic(expected = "item 5")]
    fn panics_are_passed_on() {
        map_on(2, &(0..10).collect::<Vec<_>>(), |item| assert_ne!(*item, 5, "item 5"));
    }
}
