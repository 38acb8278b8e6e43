//! Stores byte strings in large blocks of memory (slabs), and compresses them.

use std::ops::Range;

use memmap2::MmapMut;
use zstd::bulk::{Compressor, Decompressor};
use zstd::zstd_safe::compress_bound;

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

/// The zstd compression level of blocks. With level 1, states of real searches take about 10 bytes
/// each. Higher levels are slower and do not save memory.
const LEVEL: i32 = 1;

/// A compressor with its output buffer. Both are created when the first block is compressed.
#[derive(Default)]
pub(crate) struct BlockCompressor {
    compressor: Option<Compressor<'static>>,
    buffer: Vec<u8>,
}

impl BlockCompressor {
    /// Compresses a block. Returns the block itself if compression fails or saves no memory.
    pub(crate) fn compress<'b>(&'b mut self, block: &'b [u8]) -> &'b [u8] {
        let is_compressed = self.fill_buffer(block).is_some() && self.buffer.len() < block.len();
        if is_compressed { &self.buffer } else { block }
    }

    fn fill_buffer(&mut self, block: &[u8]) -> Option<()> {
        self.buffer.clear();
        reserve(&mut self.buffer, compress_bound(block.len())).ok()?;
        if self.compressor.is_none() {
            self.compressor = Some(Compressor::new(LEVEL).ok()?);
        }
        self.compressor.as_mut()?.compress_to_buffer(block, &mut self.buffer).ok().map(drop)
    }
}

/// Decompresses a block of `length` bytes. A block that already has this length is not compressed.
pub(crate) fn decompress(block: Vec<u8>, length: usize) -> Result<Vec<u8>, OutOfMemory> {
    if block.len() == length {
        return Ok(block);
    }
    let mut bytes = Vec::new();
    reserve(&mut bytes, length)?;
    let mut decompressor = Decompressor::new().map_err(|_| OutOfMemory)?;
    decompressor.decompress_to_buffer(&block, &mut bytes).map_err(|_| OutOfMemory)?;
    Ok(bytes)
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

    #[test]
    fn blocks_survive_compression() {
        let mut compressor = BlockCompressor::default();
        let noise = (0..300_u32).flat_map(|n| (n.wrapping_mul(0x9e37_79b9) ^ n).to_be_bytes());
        for block in [vec![], vec![7], vec![7; 100], vec![7; 1 << 20], noise.collect()] {
            let packed = compressor.compress(&block).to_vec();
            assert!(packed.len() <= block.len());
            assert!(decompress(packed, block.len()).unwrap() == block);
        }
        assert!(compressor.compress(&[7; 100]).len() < 50);
    }
}
