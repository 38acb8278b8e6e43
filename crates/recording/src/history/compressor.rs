//! Compresses blocks of a history.

use zstd::bulk::{Compressor, Decompressor};
use zstd::zstd_safe::compress_bound;

use crate::memory::{OutOfMemory, reserve};

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
