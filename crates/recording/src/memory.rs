//! Memory for states: fallible allocation, and a limit shared by several recordings.

use std::collections::TryReserveError;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The number of bytes that must remain free after memory is reserved for states.
///
/// Most allocations for other purposes abort the process if they fail. This amount of free memory
/// is enough for them.
const HEADROOM_BYTES: usize = 4 << 20;

/// Reserves capacity for `additional` more elements. Fails if less than `HEADROOM_BYTES` would
/// remain free.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), TryReserveError> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    // The headroom is never written to, so it takes address space but no memory.
    let mut headroom = Vec::<u8>::new();
    headroom.try_reserve_exact(HEADROOM_BYTES)?;
    list.try_reserve(additional)?;
    // This keeps the compiler from removing the unused allocation.
    black_box(&headroom);
    Ok(())
}

/// Returns true if this many bytes can be allocated now.
pub(crate) fn is_available(bytes: usize) -> bool {
    // `black_box` keeps the compiler from removing the allocation.
    reserve(black_box(&mut Vec::<u8>::new()), bytes).is_ok()
}

/// A memory limit that open recordings share. Dropping a recording frees its share of the memory.
///
/// ```
/// use std::sync::Arc;
/// use mmsim_recording::{MemoryBudget, Recording};
/// let budget = Arc::new(MemoryBudget::new(100 << 20));
/// let error = Recording::open_within("no-such.mcap".as_ref(), &budget).unwrap_err();
/// assert!(error.to_string().starts_with("no-such.mcap: cannot be read: "));
/// ```
#[derive(Debug)]
pub struct MemoryBudget {
    limit: usize,
    used: AtomicUsize,
}

impl MemoryBudget {
    /// Creates a budget of `limit` bytes.
    pub const fn new(limit: usize) -> Self {
        Self { limit, used: AtomicUsize::new(0) }
    }

    /// Returns the limit in bytes.
    pub const fn limit(&self) -> usize {
        self.limit
    }
}

impl Default for MemoryBudget {
    /// Returns a budget without a limit.
    fn default() -> Self {
        Self::new(usize::MAX)
    }
}

/// The part of a [`MemoryBudget`] that one recording uses. Dropping the share returns its memory to
/// the budget.
#[derive(Debug)]
pub(crate) struct Share {
    budget: Arc<MemoryBudget>,
    bytes: usize,
}

impl Share {
    /// Creates a share of 0 bytes.
    pub(crate) fn new(budget: &Arc<MemoryBudget>) -> Self {
        Self { budget: Arc::clone(budget), bytes: 0 }
    }

    /// Grows the share to at least `bytes`. Returns false if the budget has too little memory left.
    pub(crate) fn grow_to(&mut self, bytes: usize) -> bool {
        let more = bytes.saturating_sub(self.bytes);
        let grow = |used: usize| used.checked_add(more).filter(|&used| used <= self.budget.limit);
        let used = &self.budget.used;
        let has_room = used.fetch_update(Ordering::Relaxed, Ordering::Relaxed, grow).is_ok();
        if has_room {
            self.bytes += more;
        }
        has_room
    }

    /// Returns how much of the budget other recordings use, in bytes.
    pub(crate) fn others(&self) -> usize {
        self.budget.used.load(Ordering::Relaxed).saturating_sub(self.bytes)
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.budget.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impossible_size_is_an_error() {
        let mut list = vec![7_u8; 3];
        assert!(reserve(&mut list, usize::MAX / 4).is_err());
        assert_eq!(list, [7; 3]);
        assert!(reserve(&mut list, 1000).is_ok() && list.capacity() >= 1003);
        assert!(is_available(1 << 20) && !is_available(usize::MAX / 4));
    }

    #[test]
    fn dropped_shares_free_the_budget() {
        let budget = Arc::new(MemoryBudget::new(100));
        let (mut one, mut other) = (Share::new(&budget), Share::new(&budget));
        assert!(one.grow_to(60) && one.grow_to(50), "a share never shrinks");
        assert!(!other.grow_to(41) && other.grow_to(40));
        assert!(!one.grow_to(61) && !one.grow_to(usize::MAX));
        assert_eq!((one.others(), other.others()), (40, 60));
        drop(one);
        assert!(other.grow_to(100));
        drop(other);
        assert_eq!((budget.used.load(Ordering::Relaxed), budget.limit()), (0, 100));
    }
}
