//! Memory for states: fallible allocation, and a limit shared by several recordings.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The number of bytes that must remain free after memory is reserved for states.
///
/// Most allocations for other purposes abort the process if they fail. This amount of free memory
/// is enough for them, including 8 MiB for the thread that compresses recordings.
const HEADROOM_BYTES: u64 = 16 << 20;

/// There is not enough free memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("out of memory")]
pub struct OutOfMemory;

/// Reserves capacity for `additional` more elements. Fails under the same conditions as
/// [`check_headroom`], or if the allocation fails.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), OutOfMemory> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    check_headroom(additional.saturating_mul(size_of::<T>()))?;
    list.try_reserve(additional).map_err(|_| OutOfMemory)
}

/// Returns true if this many bytes can be allocated now.
pub(crate) fn is_available(bytes: usize) -> bool {
    // `black_box` keeps the compiler from removing the allocation.
    reserve(black_box(&mut Vec::<u8>::new()), bytes).is_ok()
}

/// Fails if an allocation of this many bytes would leave less than `HEADROOM_BYTES` under the
/// limits of this process.
///
/// Allocating the headroom for a moment would be simpler, but would take the memory from other
/// threads.
pub(crate) fn check_headroom(bytes: usize) -> Result<(), OutOfMemory> {
    let needed = HEADROOM_BYTES.saturating_add(bytes as u64);
    if free_within_limits().is_none_or(|free| free >= needed) { Ok(()) } else { Err(OutOfMemory) }
}

/// Returns the memory in bytes that this process can still allocate under its resource limits,
/// such as `ulimit -v`. Returns `None` if it has no such limits.
#[cfg(target_os = "linux")]
pub fn free_within_limits() -> Option<u64> {
    use rustix::process::{Resource, getrlimit};

    let limits = [Resource::As, Resource::Data].map(|limit| getrlimit(limit).current);
    if limits == [None; 2] {
        return None;
    }
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let used = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
    };
    let free = |(limit, key): (Option<u64>, _)| Some(limit?.saturating_sub(used(key)?));
    limits.into_iter().zip(["VmSize:", "VmData:"]).filter_map(free).min()
}

/// Returns `None`, because only Linux reports how much of a limit is in use.
#[cfg(not(target_os = "linux"))]
pub const fn free_within_limits() -> Option<u64> {
    None
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
