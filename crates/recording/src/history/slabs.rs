//! Stores byte strings in large blocks of memory (slabs).

use std::ops::Range;

use memmap2::MmapMut;

use crate::memory::{OutOfMemory, check_headroom, reserve};

/// The minimum size of a slab in bytes.
const SLAB_BYTES: usize = 1 << 20;

/// A list of byte strings.
#[derive(Debug, Default)]
pub(crate) struct Slabs {
    /// The slabs. They are mapped because the system then gets their memory back when the list is
    /// dropped, whereas an allocator may keep it for a single thread.
    mappings: Vec<MmapMut>,
    /// The number of bytes used in the newest slab.
    used: usize,
    locations: Vec<Location>,
    /// The memory used by the strings and their locations, in bytes.
    pub(crate) bytes: usize,
}

/// The location of a string: the index of its slab and its byte range in the slab.
type Location = (usize, Range<usize>);

impl Slabs {
    /// The memory for the location of a string, in bytes.
    pub(crate) const LOCATION_BYTES: usize = size_of::<Location>();

    /// Returns the number of strings.
    pub(crate) const fn len(&self) -> usize {
        self.locations.len()
    }

    /// Appends a string without moving the existing strings.
    ///
    /// # Errors
    /// The system is out of memory. On error, the list stays unchanged.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<(), OutOfMemory> {
        reserve(&mut self.locations, 1)?;
        if self.mappings.last().is_none_or(|slab| slab.len() - self.used < bytes.len()) {
            let size = bytes.len().max(SLAB_BYTES);
            check_headroom(size)?;
            reserve(&mut self.mappings, 1)?;
            self.mappings.push(MmapMut::map_anon(size).map_err(|_| OutOfMemory)?);
            self.used = 0;
        }
        let range = self.used..self.used + bytes.len();
        let target = self.mappings.last_mut().and_then(|slab| slab.get_mut(range.clone()));
        target.ok_or(OutOfMemory)?.copy_from_slice(bytes);
        self.used = range.end;
        self.locations.push((self.mappings.len() - 1, range));
        self.bytes += bytes.len() + size_of::<Location>();
        Ok(())
    }

    /// Returns the string with this index.
    pub(crate) fn get(&self, index: usize) -> Option<&[u8]> {
        let (slab, range) = self.locations.get(index)?;
        self.mappings.get(*slab)?.get(range.clone())
    }
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
        assert_eq!(slabs.mappings.len(), 2);
        for (index, string) in strings.iter().enumerate() {
            assert!(slabs.get(index) == Some(string));
        }
        assert_eq!(slabs.bytes, SLAB_BYTES + 12 + 5 * size_of::<Location>());
        slabs.push(&vec![5; SLAB_BYTES + 1]).unwrap();
        assert_eq!(slabs.get(5).map(<[u8]>::len), Some(SLAB_BYTES + 1));
    }
}
