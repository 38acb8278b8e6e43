//! Memory for states, asked for in such a way that a refusal can be answered.

use std::collections::TryReserveError;
use std::hint::black_box;

/// Bytes that must be left for everything else when states take more. What else a process holds is
/// bounded, and much of it is allocated where failing would end the process.
const HEADROOM_BYTES: usize = 4 << 20;

/// Makes room for this many more elements, as long as the headroom is left beside them.
pub(crate) fn reserve<T>(list: &mut Vec<T>, additional: usize) -> Result<(), TryReserveError> {
    if list.capacity() - list.len() >= additional {
        return Ok(());
    }
    // The system only counts it; no page of it is touched.
    let mut headroom = Vec::<u8>::new();
    headroom.try_reserve_exact(HEADROOM_BYTES)?;
    list.try_reserve(additional)?;
    // Otherwise the compiler may leave out an allocation that nobody uses.
    black_box(&headroom);
    Ok(())
}

/// Returns whether this many bytes could be allocated now.
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
    fn more_than_there_can_be_is_refused() {
        let mut list = vec![7_u8; 3];
        assert!(reserve(&mut list, usize::MAX / 4).is_err());
        assert_eq!(list, [7; 3]);
        assert!(reserve(&mut list, 1000).is_ok() && list.capacity() >= 1003);
        assert!(is_available(1 << 20) && !is_available(usize::MAX / 4));
    }
}
