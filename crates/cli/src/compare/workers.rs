//! Runs searches of processes in parallel, so that all processors are busy.

use std::sync::{Condvar, Mutex, PoisonError};

use crate::parallel::map_with_permits;

/// The number of threads per slot. A search that waits for a mouse in the goal needs a thread, but no
/// slot.
const THREADS_PER_SLOT: usize = 8;

/// The number of searches that may use a processor at the same time.
struct Slots {
    free: Mutex<usize>,
    changed: Condvar,
}

/// The right to use a processor, which ends when it is released or dropped.
pub(super) struct Slot<'s> {
    slots: &'s Slots,
    is_held: bool,
}

impl Slots {
    fn acquire(&self) -> Slot<'_> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let free = self.changed.wait_while(free, |free| *free == 0);
        *free.unwrap_or_else(PoisonError::into_inner) -= 1;
        Slot { slots: self, is_held: true }
    }
}

impl Slot<'_> {
    /// Lets another search use the processor. Does nothing if the slot was released before.
    pub(super) fn release(&mut self) {
        if std::mem::take(&mut self.is_held) {
            *self.slots.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
            self.slots.changed.notify_one();
        }
    }
}

impl Drop for Slot<'_> {
    fn drop(&mut self) {
        self.release();
    }
}

/// Calls `work` for each item, with up to `slots` calls that hold their slot at the same time.
/// Returns the results in the order of the items.
pub(super) fn map_waiting<T: Sync, R: Send>(
    items: &[T],
    slots: usize,
    work: impl Fn(&T, &mut Slot<'_>) -> R + Sync,
) -> Vec<R> {
    let count = slots.max(1);
    let slots = Slots { free: Mutex::new(count), changed: Condvar::new() };
    let acquire = || slots.acquire();
    map_with_permits(THREADS_PER_SLOT * count, items, acquire, |item, mut slot| {
        work(item, &mut slot)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::time::Duration;

    use super::*;

    #[test]
    fn results_keep_the_order_of_the_items() {
        let items: Vec<usize> = (0..1000).collect();
        let most = AtomicUsize::new(0);
        let running = AtomicUsize::new(0);
        let results = map_waiting(&items, 3, |&item, _| {
            most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            running.fetch_sub(1, Ordering::SeqCst);
            2 * item
        });
        assert!(results.into_iter().eq(items.iter().map(|item| 2 * item)));
        assert!(most.into_inner() <= 3);
        assert_eq!(map_waiting(&[0_u8; 0], 3, |_, _| ()), []);
    }

    #[test]
    fn another_item_can_start_when_a_slot_is_released() {
        let (mutex, changed) = (Mutex::new(()), Condvar::new());
        let has_second_started = AtomicBool::new(false);
        map_waiting(&[1, 2], 1, |&item, slot| {
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
