//! Fallible allocation of memory for states.

use std::collections::TryReserveError;
use std::hint::black_box;

/// Memory in bytes that must remain free after an allocation for states.
///
/// Everything else in the process has a bounded size, but most of it is allocated infallibly, so
/// running out of memory there would abort the process.
const HEADROOM_BYTES: usize = 4 << 20;

/// Reserves capacity for `additional` more elements if the headroom remains free.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), TryReserveError> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    // No page of it is touched, so this costs address space only.
    let mut headroom = Vec::<u8>::new();
    headroom.try_reserve_exact(HEADROOM_BYTES)?;
    list.try_reserve(additional)?;
    // Otherwise the compiler may remove the unused allocation.
    black_box(&headroom);
    Ok(())
}

/// Returns whether this many bytes can be allocated now.
pub(crate) fn is_available(bytes: usize) -> bool {
    let mut list = Vec::<u8>::new();
    let reserved = reserve(&mut list, bytes);
    black_box(&list);
    reserved.is_ok()
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
}
