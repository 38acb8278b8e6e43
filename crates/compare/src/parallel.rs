//! Runs work in parallel on all processors.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Sender};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use mmsim_mouse::Shortage;

/// The number of threads per slot if work may wait. A search that waits for a mouse in the goal needs a
/// thread, but no slot.
const THREADS_PER_SLOT: usize = 8;

/// The right to use a processor, which ends when it is released or dropped.
pub struct Slot(Option<Sender<()>>);

impl Slot {
    /// Lets other work use the processor. Does nothing if the slot was released before.
    pub fn release(&mut self) {
        // After the last work, nothing receives it.
        self.0.take().map(|free| free.send(()));
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.release();
    }
}

/// The number of open files that this process needs for itself.
#[cfg(unix)]
const OWN_FILES: u64 = 24;

/// The number of open files that a program of the user and its connections need.
#[cfg(unix)]
const FILES_PER_PROGRAM: u64 = 12;

/// Returns how many programs can run at a time under the limit of open files.
fn max_programs() -> usize {
    #[cfg(unix)]
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    #[cfg(unix)]
    let programs = limit.map(|files| files.saturating_sub(OWN_FILES) / FILES_PER_PROGRAM);
    // Other systems limit only the files of the C library.
    #[cfg(not(unix))]
    let programs = None::<u64>;
    programs.map_or(usize::MAX, |programs| usize::try_from(programs).unwrap_or(usize::MAX).max(1))
}

/// Limits the number of programs at a time to what the system allows.
pub(crate) struct Gate {
    state: Mutex<GateState>,
    changed: Condvar,
}

struct GateState {
    running: usize,
    max: usize,
    /// The shortage that a program has met although it ran alone.
    shortage: Option<Shortage>,
}

impl Gate {
    /// Creates a gate for as many programs as the limit of open files allows.
    pub(crate) fn new() -> Self {
        Self::with_max(max_programs())
    }

    fn with_max(max: usize) -> Self {
        let state = GateState { running: 0, max, shortage: None };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, GateState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs a program. If the system lacks something, waits until fewer programs run, and tries again.
    ///
    /// # Errors
    /// A program has met a shortage although it ran alone.
    pub(crate) fn run<T>(&self, program: impl Fn() -> Result<T, Shortage>) -> Result<T, Shortage> {
        loop {
            let pass = Pass::take(self)?;
            let max = pass.max;
            let result = program();
            drop(pass);
            let Err(shortage) = result else { return result };
            let mut state = self.lock();
            if max == 1 {
                state.shortage = Some(shortage);
                self.changed.notify_all();
            } else {
                state.max = state.running.min(state.max - 1).max(1);
            }
        }
    }
}

/// The right to run a program, which ends when it is dropped.
struct Pass<'g> {
    gate: &'g Gate,
    /// The maximum number of programs when this one began.
    max: usize,
}

impl<'g> Pass<'g> {
    fn take(gate: &'g Gate) -> Result<Self, Shortage> {
        let is_full =
            |state: &mut GateState| state.running >= state.max && state.shortage.is_none();
        let waited = gate.changed.wait_while(gate.lock(), is_full);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if let Some(shortage) = &state.shortage {
            return Err(shortage.clone());
        }
        state.running += 1;
        Ok(Self { gate, max: state.max })
    }
}

impl Drop for Pass<'_> {
    fn drop(&mut self) {
        self.gate.lock().running -= 1;
        self.gate.changed.notify_all();
    }
}

/// Calls `work` for each item, on one thread per processor. Returns the results in the order of the
/// items.
pub fn map_each<'a, T: Sync, R: Send>(items: &'a [T], work: impl Fn(&'a T) -> R + Sync) -> Vec<R> {
    map_waiting(items, None, false, |item, _| work(item))
}

/// Like [`map_each`], but up to `slots` calls hold their slot at the same time, by default one for each
/// processor. Calls can release their slot early only with `may_wait`. The work begins in the order of
/// the items.
pub fn map_waiting<'a, T: Sync, R: Send>(
    items: &'a [T],
    slots: Option<u16>,
    may_wait: bool,
    work: impl Fn(&'a T, &mut Slot) -> R + Sync,
) -> Vec<R> {
    let processors = || thread::available_parallelism().map_or(1, NonZero::get);
    let count = slots.map_or_else(processors, usize::from).max(1);
    let threads = if may_wait { THREADS_PER_SLOT * count } else { count };
    let (free, slots) = mpsc::channel();
    (0..count).for_each(|_| Slot(Some(free.clone())).release());
    let (slots, next) = (Mutex::new(slots), AtomicUsize::new(0));
    // Each thread takes one item at a time, because neighbouring items may take a thousand times as
    // long as others.
    let take = || {
        // This thread has a sender, so waiting cannot fail.
        let _ = slots.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let mut slot = Slot(Some(free.clone()));
        let index = next.fetch_add(1, Ordering::Relaxed);
        items.get(index).map(|item| (index, work(item, &mut slot)))
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
    use std::sync::Barrier;
    use std::sync::atomic::AtomicBool;
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
        let results = map_waiting(&items, Some(2), false, |item, _| work(item));
        assert!(results.into_iter().eq(items.iter().map(|item| 2 * item)));
    }
    #[test]
    fn every_number_of_threads_gives_all_results() {
        for (threads, count) in [(1, 9), (9, 1), (3, 0), (7, 100), (0, 2)] {
            let items: Vec<usize> = (0..count).collect();
            assert_eq!(
                map_waiting(&items, Some(threads), false, |&item, _| item),
                items,
                "{threads} threads"
            );
        }
        assert_eq!(map_each(&[1, 2], |item| item + 1), [2, 3]);
    }

    #[test]
    fn programs_wait_until_the_system_has_enough_for_them() {
        // The system allows three programs at a time. All ten begin before the first one ends.
        let (gate, barrier) = (Gate::with_max(10), Barrier::new(10));
        let (running, refused) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let items: Vec<usize> = (0..10).collect();
        let found = map_waiting(&items, Some(10), false, |&item, _| {
            let is_first = AtomicBool::new(true);
            gate.run(|| {
                let before = running.fetch_add(1, Ordering::SeqCst);
                if is_first.swap(false, Ordering::SeqCst) {
                    barrier.wait();
                }
                running.fetch_sub(1, Ordering::SeqCst);
                if before >= 3 {
                    refused.fetch_add(1, Ordering::SeqCst);
                    return Err(Shortage("too many".into()));
                }
                Ok(item)
            })
        });
        assert_eq!(found, items.iter().map(|&item| Ok(item)).collect::<Vec<_>>());
        assert!(refused.into_inner() >= 7);
    }

    #[test]
    fn a_shortage_of_a_program_that_runs_alone_ends_all() {
        let gate = Gate::with_max(5);
        let found = map_waiting(&[1, 2, 3], Some(3), false, |_, _| {
            gate.run(|| Err::<(), _>(Shortage("no memory".into())))
        });
        assert_eq!(found, vec![Err(Shortage("no memory".into())); 3]);
    }

    #[test]
    #[should_panic(expected = "item 5")]
    fn panics_are_passed_on() {
        map_waiting(&(0..10).collect::<Vec<_>>(), Some(2), false, |item, _| {
            assert_ne!(*item, 5, "item 5");
        });
    }

    #[test]
    fn results_keep_the_order_of_the_items() {
        let items: Vec<usize> = (0..1000).collect();
        let most = AtomicUsize::new(0);
        let running = AtomicUsize::new(0);
        let results = map_waiting(&items, Some(3), true, |&item, _| {
            most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            running.fetch_sub(1, Ordering::SeqCst);
            2 * item
        });
        assert!(results.into_iter().eq(items.iter().map(|item| 2 * item)));
        assert!(most.into_inner() <= 3);
        assert_eq!(map_waiting(&[0_u8; 0], Some(3), false, |_, _| ()), []);
    }

    #[test]
    fn another_item_can_start_when_a_slot_is_released() {
        let (mutex, changed) = (Mutex::new(()), Condvar::new());
        let has_second_started = AtomicBool::new(false);
        map_waiting(&[1, 2], Some(1), true, |&item, slot| {
            let guard = mutex.lock().unwrap();
            if item == 2 {
                has_second_started.store(true, Ordering::SeqCst);
                return changed.notify_all();
            }
            slot.release();
            let waited = changed.wait_timeout_while(guard, Duration::from_secs(30), |()| {
                !has_second_started.load(Ordering::SeqCst)
            });
            assert!(!waited.unwrap().1.timed_out(), "the second item has not started");
        });
    }
}
