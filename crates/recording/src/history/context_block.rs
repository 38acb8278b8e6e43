//! Copies of the stored contexts and updates of a block.
//!
//! ```text
//! updates  for each update: index of the state in the block (1 byte), length (4 bytes), bytes
//! ```

use mmsim_maze::MazeSize;

use crate::context::Context;
use crate::history::compressor::decompress;
use crate::memory::{OutOfMemory, reserve};

/// The data from which the contexts in a block are computed.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContextBlock {
    /// The context before the first state. Empty if nothing has changed since the start of the run.
    pub(crate) context: Data,
    pub(crate) updates: UpdateData,
}

/// The updates in a block, in one or more parts. Decompressed updates have one part.
#[derive(Clone, Debug, Default)]
pub(crate) struct UpdateData(pub(crate) Vec<Data>);

/// A copy of stored data, which is compressed unless its length is `length`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Data {
    bytes: Vec<u8>,
    /// The uncompressed length in bytes.
    length: usize,
}

impl Data {
    pub(crate) fn new(bytes: &[u8], length: usize) -> Result<Self, OutOfMemory> {
        let mut copy = Vec::new();
        reserve(&mut copy, bytes.len())?;
        copy.extend_from_slice(bytes);
        Ok(Self { bytes: copy, length })
    }

    fn unpack(self) -> Result<Self, OutOfMemory> {
        Ok(Self { bytes: decompress(self.bytes, self.length)?, ..self })
    }
}

impl ContextBlock {
    /// Decompresses the data.
    pub(crate) fn unpack(self) -> Result<Self, OutOfMemory> {
        Ok(Self { context: self.context.unpack()?, updates: self.updates.unpack()? })
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.context.bytes.len() + self.updates.0.iter().map(|part| part.bytes.len()).sum::<usize>()
    }

    /// Returns the context before the first state. The block must be decompressed.
    pub(crate) fn first(&self, size: MazeSize) -> Option<Context> {
        match &*self.context.bytes {
            [] => Some(Context::new(size)),
            bytes => Context::decode(bytes, size),
        }
    }

    /// Returns the updates of the states. The block must be decompressed.
    pub(crate) fn updates(&self) -> Updates<'_> {
        self.updates.iter()
    }
}

impl UpdateData {
    /// Decompresses the updates.
    pub(crate) fn unpack(self) -> Result<Self, OutOfMemory> {
        let mut bytes = Vec::new();
        reserve(&mut bytes, self.0.iter().map(|part| part.length).sum())?;
        for part in self.0 {
            bytes.extend_from_slice(&part.unpack()?.bytes);
        }
        let length = bytes.len();
        Ok(Self(vec![Data { bytes, length }]))
    }

    /// Iterates over the updates. They must be decompressed.
    pub(crate) fn iter(&self) -> Updates<'_> {
        Updates(self.0.first().map_or(&[], |data| &data.bytes))
    }
}

/// The updates in a block that have not been read yet.
#[derive(Clone, Debug)]
pub(crate) struct Updates<'a>(&'a [u8]);

impl<'a> Updates<'a> {
    /// Returns the update before the state `index` of the block. Skips the updates of earlier
    /// states.
    pub(crate) fn seek(&mut self, index: usize) -> &'a [u8] {
        while let Some(&at) = self.0.first()
            && usize::from(at) <= index
            && let Some((at, update)) = self.next()
        {
            if at == index {
                return update;
            }
        }
        &[]
    }
}

impl<'a> Iterator for Updates<'a> {
    /// The index of a state in the block, and the bytes of its update.
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        let (&[index, a, b, c, d], rest) = self.0.split_first_chunk()?;
        let length = usize::try_from(u32::from_le_bytes([a, b, c, d])).ok()?;
        let (update, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some((index.into(), update))
    }
}
