//! From bit planes to numbers: bit i of each distance becomes the distances one after another.

use super::board::columns;
use super::half::Half;
use super::waves::{Flooded, Marks};

/// The distance bytes of 16 cells that follow each other from the west.
pub(super) type Line = [u8; 16];

/// Writes 8 bits of each distance, from bit `first` on, a byte a cell, row by row from the
/// south-west, all bits set where no wave has come to.
#[inline(always)]
pub(super) fn write<const N: usize, H: Half<N>>(
    flooded: &Flooded<H>,
    first: usize,
    bytes: &mut [u8],
) {
    let (mut even, mut odd) = ([H::NONE; 8], [H::NONE; 8]);
    for i in 0..8 {
        let plane = |marks: &Marks<H>| match marks.planes.get(first + i) {
            Some(plane) => plane.or(marks.dry),
            None => marks.dry,
        };
        [even[i], odd[i]] = columns(flooded, plane);
    }
    H::spread(even, odd, bytes.as_chunks_mut().0.as_chunks_mut().0);
}

/// Bit i of each byte from the i-th plane of even and of odd columns.
#[inline(always)]
pub(super) fn spread<const N: usize, H: Half<N>>(
    mut even: [H; 8],
    mut odd: [H; 8],
    lines: &mut [[Line; 8]],
) {
    transpose_bits(&mut even);
    transpose_bits(&mut odd);
    H::interleave(&even, &odd, lines);
}

/// Lines of bytes from those of even and of odd columns: byte j of half i is that of the i-th of
/// these columns in line j.
#[inline(always)]
pub(super) fn interleave<const N: usize, H: Half<N>>(
    even: &[H; 8],
    odd: &[H; 8],
    lines: &mut [[Line; 8]],
) {
    let (even, odd) = (words_of(even), words_of(odd));
    for (word, lines) in lines.iter_mut().enumerate() {
        let pair = |i: usize| [even[i][word], odd[i][word]];
        let ([a, b], [c, d], [e, f], [g, h]) = (pair(0), pair(1), pair(2), pair(3));
        let west = transposed_bytes([a, b, c, d, e, f, g, h]);
        let ([a, b], [c, d], [e, f], [g, h]) = (pair(4), pair(5), pair(6), pair(7));
        let east = transposed_bytes([a, b, c, d, e, f, g, h]);
        for (line, (west, east)) in lines.iter_mut().zip(west.into_iter().zip(east)) {
            *line = (u128::from(west) | u128::from(east) << 64).to_le_bytes();
        }
    }
}

/// The words of each plane.
#[inline(always)]
pub(super) fn words_of<const N: usize, H: Half<N>>(planes: &[H; 8]) -> [[u64; N]; 8] {
    // Neither `map` of arrays nor `zip` is always inlined.
    let mut words = [[0; N]; 8];
    for (i, plane) in planes.iter().enumerate() {
        words[i] = plane.words();
    }
    words
}

/// Bit i of byte j of plane k becomes bit k of byte j of plane i.
#[inline(always)]
fn transpose_bits<const N: usize, H: Half<N>>(planes: &mut [H; 8]) {
    macro_rules! swap {
        ($bits:literal, $mask:literal, $($low:literal $high:literal),*) => { $(
            let differing =
                planes[$low].down::<$bits>().xor(planes[$high]).and(H::of([$mask; N]));
            planes[$high] = planes[$high].xor(differing);
            planes[$low] = planes[$low].xor(differing.up::<$bits>());
        )* };
    }
    swap!(1, 0x5555_5555_5555_5555, 0 1, 2 3, 4 5, 6 7);
    swap!(2, 0x3333_3333_3333_3333, 0 2, 1 3, 4 6, 5 7);
    swap!(4, 0x0f0f_0f0f_0f0f_0f0f, 0 4, 1 5, 2 6, 3 7);
}

/// Byte i of word k becomes byte k of word i.
#[inline(always)]
fn transposed_bytes(mut words: [u64; 8]) -> [u64; 8] {
    macro_rules! swap {
        ($bits:literal, $mask:literal, $($low:literal $high:literal),*) => { $(
            let differing = (words[$low] >> $bits ^ words[$high]) & $mask;
            words[$high] ^= differing;
            words[$low] ^= differing << $bits;
        )* };
    }
    swap!(8, 0x00ff_00ff_00ff_00ff, 0 1, 2 3, 4 5, 6 7);
    swap!(16, 0x0000_ffff_0000_ffff, 0 2, 1 3, 4 6, 5 7);
    swap!(32, 0x0000_0000_ffff_ffff, 0 4, 1 5, 2 6, 3 7);
    words
}
