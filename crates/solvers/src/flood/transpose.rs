//! Transposition of bit planes into one byte per cell.

use super::plane::ParityPlane;

/// The bytes of 16 adjacent cells of a row, from the west.
pub(super) type Line = [u8; 16];

/// Writes one byte per cell. Bit i of a byte comes from plane i of the even or odd columns.
#[inline(always)]
pub(super) fn spread<const N: usize, H: ParityPlane<N>>(
    mut even: [H; 8],
    mut odd: [H; 8],
    lines: &mut [[Line; 8]],
) {
    transpose_bits(&mut even);
    transpose_bits(&mut odd);
    H::interleave(&even, &odd, lines);
}

/// Merges the bytes of even and odd columns into lines. Byte j of element i belongs to line j and
/// to the i-th even or odd column.
#[inline(always)]
pub(super) fn interleave<const N: usize, H: ParityPlane<N>>(
    even: &[H; 8],
    odd: &[H; 8],
    lines: &mut [[Line; 8]],
) {
    let (even, odd) = (to_words(even), to_words(odd));
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

/// Returns the words of each plane.
#[inline(always)]
pub(super) fn to_words<const N: usize, H: ParityPlane<N>>(planes: &[H; 8]) -> [[u64; N]; 8] {
    // `map` of arrays and `zip` are not always inlined.
    let mut words = [[0; N]; 8];
    for (i, plane) in planes.iter().enumerate() {
        words[i] = plane.to_words();
    }
    words
}

/// Moves bit i of byte j of plane k to bit k of byte j of plane i.
#[inline(always)]
fn transpose_bits<const N: usize, H: ParityPlane<N>>(planes: &mut [H; 8]) {
    macro_rules! swap {
        ($bits:literal, $mask:literal, $($low:literal $high:literal),*) => { $(
            let differing =
                planes[$low].down::<$bits>().xor(planes[$high]).and(H::from_words([$mask; N]));
            planes[$high] = planes[$high].xor(differing);
            planes[$low] = planes[$low].xor(differing.up::<$bits>());
        )* };
    }
    swap!(1, 0x5555_5555_5555_5555, 0 1, 2 3, 4 5, 6 7);
    swap!(2, 0x3333_3333_3333_3333, 0 2, 1 3, 4 6, 5 7);
    swap!(4, 0x0f0f_0f0f_0f0f_0f0f, 0 4, 1 5, 2 6, 3 7);
}

/// Moves byte i of word k to byte k of word i.
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
