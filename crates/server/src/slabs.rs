//! Byte strings of any length, kept close together in large pieces of memory.

use std::collections::TryReserveError;
use std::iter;

use crate::memory::reserve;

/// Bytes of a piece. Every allocator takes a piece of this size from the system and gives it back
/// as soon as it is free, which it does not with small ones: glibc's does so above 32 MiB for sure.
/// What is not used of it is only an address.
const PIECE_BYTES: usize = (32 << 20) + 4096;

/// Where there is no room for a piece of that size, smaller ones are taken, down to this one.
const MIN_PIECE_BYTES: usize = 64 * 1024;

/// A list of byte strings.
#[derive(Debug, Default)]
pub(crate) struct Slabs {
    pieces: Vec<Vec<u8>>,
    places: Vec<Place>,
    bytes: usize,
}

/// Where a string is.
#[derive(Clone, Copy, Debug)]
struct Place {
    piece: usize,
    start: usize,
    length: usize,
}

impl Slabs {
    pub(crate) const fn new() -> Self {
        Self { pieces: Vec::new(), places: Vec::new(), bytes: 0 }
    }

    /// How many strings there are.
    pub(crate) const fn len(&self) -> usize {
        self.places.len()
    }

    /// How many bytes the strings have, with what it takes to find them.
    pub(crate) const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Adds a string. None of those before it moves.
    ///
    /// # Errors
    /// There is no memory left for it. Nothing changes then.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> Result<(), TryReserveError> {
        reserve(&mut self.places, 1)?;
        if self.pieces.last().is_none_or(|piece| piece.capacity() - piece.len() < bytes.len()) {
            reserve(&mut self.pieces, 1)?;
            self.pieces.push(piece(bytes.len())?);
        }
        let piece = self.pieces.len() - 1;
        if let Some(last) = self.pieces.last_mut() {
            self.places.push(Place { piece, start: last.len(), length: bytes.len() });
            last.extend_from_slice(bytes);
        }
        self.bytes += bytes.len() + size_of::<Place>();
        Ok(())
    }

    /// The string with this index.
    pub(crate) fn get(&self, index: usize) -> Option<&[u8]> {
        let &Place { piece, start, length } = self.places.get(index)?;
        self.pieces.get(piece)?.get(start..start + length)
    }
}

/// A piece with room for at least so many bytes, as large as there is memory.
fn piece(least: usize) -> Result<Vec<u8>, TryReserveError> {
    let mut piece = Vec::new();
    let larger = iter::successors(Some(PIECE_BYTES), |size| Some(size / 2));
    let larger = larger.take_while(|&size| size >= least.max(MIN_PIECE_BYTES));
    for size in larger {
        if reserve(&mut piece, size).is_ok() {
            return Ok(piece);
        }
    }
    reserve(&mut piece, least)?;
    Ok(piece)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_kept_across_slabs() {
        let mut slabs = Slabs::new();
        let strings = [vec![1; PIECE_BYTES - 10], vec![2; 10], vec![], vec![3; 11], vec![4; 1]];
        for (count, string) in strings.iter().enumerate() {
            assert_eq!((slabs.len(), slabs.get(count)), (count, None));
            slabs.push(string).unwrap();
        }
        assert_eq!(slabs.pieces.len(), 2);
        for (index, string) in strings.iter().enumerate() {
            assert!(slabs.get(index) == Some(string));
        }
        assert_eq!(slabs.bytes(), PIECE_BYTES + 12 + 5 * size_of::<Place>());
        slabs.push(&vec![5; PIECE_BYTES + 1]).unwrap();
        assert_eq!(slabs.get(5).map(<[u8]>::len), Some(PIECE_BYTES + 1));
    }
}
