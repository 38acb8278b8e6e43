//! Stores byte strings in large blocks of memory (slabs).

use std::collections::TryReserveError;
use std::iter;
use std::ops::Range;

use crate::memory::reserve;

/// The size of a slab in bytes.
///
/// When a large block is freed, the allocator immediately returns its memory to the system. The
/// glibc allocator always treats blocks above 32 MiB as large. The unused part of a slab takes
/// address space but no memory.
const SLAB_BYTES: usize = (32 << 20) + 4096;

/// If memory is short, the size of a new slab is halved repeatedly, but not below this number of
/// bytes.
const MIN_SLAB_BYTES: usize = 64 * 1024;

/// A list of byte strings.
#[derive(Debug, Default)]
pub(crate) struct Slabs {
    buffers: Vec<Vec<u8>>,
    locations: Vec<Location>,
    /// The memory used by the strings and their locations, in bytes.
    pub(crate) bytes: usize,
}

/// The location of a string: the index of its slab and its byte range in the slab.
type Location = (usize, Range<usize>);

impl Slabs {
    /// Returns the number of strings.
    pub(crate) const fn len(&self) -> usize {
        self.locations.len()
    }

    /// Appends a string without moving the existing strings.
    ///
    /// # Errors
    /// The system is out of memory. On error, the list stays unchanged.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<(), TryReserveError> {
        reserve(&mut self.locations, 1)?;
        if self.buffers.last().is_none_or(|slab| slab.capacity() - slab.len() < bytes.len()) {
            reserve(&mut self.buffers, 1)?;
            self.buffers.push(new_slab(bytes.len())?);
        }
        let slab = self.buffers.len() - 1;
        if let Some(last) = self.buffers.last_mut() {
            self.locations.push((slab, last.len()..last.len() + bytes.len()));
            last.extend_from_slice(bytes);
        }
        self.bytes += bytes.len() + size_of::<Location>();
        Ok(())
    }

    /// Returns the string with this index.
    pub(crate) fn get(&self, index: usize) -> Option<&[u8]> {
        let (slab, bytes) = self.locations.get(index)?;
        self.buffers.get(*slab)?.get(bytes.clone())
    }
}

/// Allocates a slab of at least `least` bytes. If memory is short, the slab is smaller than usual.
fn new_slab(least: usize) -> Result<Vec<u8>, TryReserveError> {
    let mut slab = Vec::new();
    let sizes = iter::successors(Some(SLAB_BYTES), |size| Some(size / 2));
    let mut sizes = sizes.take_while(|&size| size >= least.max(MIN_SLAB_BYTES));
    if !sizes.any(|size| reserve(&mut slab, size).is_ok()) {
        reserve(&mut slab, least)?;
    }
    Ok(slab)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_survive_across_slabs() {
        let mut slabs = Slabs::default();
        let strings = [vec![1; SLAB_BYTES - 10], vec![2; 10], vec![], vec![3; 11], vec![4; 1]];
        for (count, string) in strings.iter().enumerate() {
            assert_eq!((slabs.len(), slabs.get(count)), (count, None));
            slabs.push(string).unwrap();
        }
        assert_eq!(slabs.buffers.len(), 2);
        for (index, string) in strings.iter().enumerate() {
            assert!(slabs.get(index) == Some(string));
        }
        assert_eq!(slabs.bytes, SLAB_BYTES + 12 + 5 * size_of::<Location>());
        slabs.push(&vec![5; SLAB_BYTES + 1]).unwrap();
        assert_eq!(slabs.get(5).map(<[u8]>::len), Some(SLAB_BYTES + 1));
    }
}
