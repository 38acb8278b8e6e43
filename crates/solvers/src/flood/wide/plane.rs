//! Parity planes (sets of cells of one chessboard colour, with one bit per cell) and their
//! conversion to one byte per cell.

use crate::flood::steps::{ByteRow, SIDE, SMALL_SIDE};

/// A set of cells of one chessboard colour, with one bit per cell.
///
/// ```text
///   y = 1 | light dark  light dark        A step always leads to the other colour, so a wave
///   y = 0 | dark  light dark  light       needs only half of the bits.
///          -------------------------
///            x = 0   1     2     3
/// ```
///
/// Rows are stored from south to north. Bit ⌊x / 2⌋ of a row stands for the cell in column x. In
/// mazes of up to 16×16 cells, a row takes 8 bits and the set takes 2 words. In larger mazes, a row
/// takes 16 bits and the set takes 8 words.
///
/// A shift may move a bit from the end of a row into another row. A flood then clears the bit,
/// because no cell can be entered through an outer wall.
pub(crate) trait ParityPlane: BitOps {
    /// The 64-bit words that store the bits, from south to north.
    type Words: Words;

    /// True if the type is for mazes of up to 16×16 cells.
    const IS_SMALL: bool = size_of::<Self::Words>() == size_of::<[u64; 2]>();
    /// The number of rows.
    const ROWS: usize = if Self::IS_SMALL { SMALL_SIDE } else { SIDE };
    /// The number of bits per row.
    const ROW_BITS: usize = Self::ROWS / 2;

    fn from_words(words: Self::Words) -> Self;

    fn to_words(self) -> Self::Words;

    /// Writes one byte per cell. Bit i of the byte is the bit of the cell in `even[i]` if the cell
    /// is in an even column, otherwise in `odd[i]`.
    #[inline(always)]
    fn spread(mut even: [Self; 8], mut odd: [Self; 8], lines: &mut [[ByteRow; 8]]) {
        transpose_bits(&mut even);
        transpose_bits(&mut odd);
        Self::interleave(&even, &odd, lines);
    }

    /// Merges the bytes of the cells in even and odd columns: byte j of `even[i]` becomes element
    /// 2i of line j, and byte j of `odd[i]` becomes element 2i + 1 of line j.
    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[ByteRow; 8]]) {
        let (even, odd) = (to_words(even), to_words(odd));
        for (word, lines) in lines.iter_mut().enumerate() {
            let pair = |i: usize| [even[i].as_ref()[word], odd[i].as_ref()[word]];
            let ([a, b], [c, d], [e, f], [g, h]) = (pair(0), pair(1), pair(2), pair(3));
            let west = transposed_bytes([a, b, c, d, e, f, g, h]);
            let ([a, b], [c, d], [e, f], [g, h]) = (pair(4), pair(5), pair(6), pair(7));
            let east = transposed_bytes([a, b, c, d, e, f, g, h]);
            for (line, (west, east)) in lines.iter_mut().zip(west.into_iter().zip(east)) {
                *line = (u128::from(west) | u128::from(east) << 64).to_le_bytes();
            }
        }
    }
}

/// An array of words.
pub(crate) trait Words: Copy + AsRef<[u64]> + AsMut<[u64]> {
    /// Creates an array filled with copies of `word`.
    fn repeat(word: u64) -> Self;
}

impl<const N: usize> Words for [u64; N] {
    #[inline(always)]
    fn repeat(word: u64) -> Self {
        [word; N]
    }
}

/// The bit operations that a flood needs.
pub(crate) trait BitOps: Copy {
    /// No bits.
    const NONE: Self;
    /// All bits.
    const ALL: Self;

    fn and(self, other: Self) -> Self;

    fn or(self, other: Self) -> Self;

    fn xor(self, other: Self) -> Self;

    /// Computes `self & !other`.
    fn without(self, other: Self) -> Self;

    /// Shifts each word towards higher bits.
    fn up<const BITS: i32>(self) -> Self;

    /// Shifts each word towards lower bits.
    fn down<const BITS: i32>(self) -> Self;

    /// Moves all bits one row to the north.
    fn north(self) -> Self;

    /// Moves all bits one row to the south.
    fn south(self) -> Self;

    fn is_empty(self) -> bool;

    /// Computes `(self & mask) | others`.
    #[inline(always)]
    fn and_or(self, mask: Self, others: Self) -> Self {
        self.and(mask).or(others)
    }

    /// Computes `(self | others) & mask`.
    #[inline(always)]
    fn or_and(self, others: Self, mask: Self) -> Self {
        self.or(others).and(mask)
    }

    /// Computes `(self | others) & !mask`.
    #[inline(always)]
    fn or_without(self, others: Self, mask: Self) -> Self {
        self.or(others).without(mask)
    }
}

/// Defines the operations of [`BitOps`] that combine words or vectors one by one. `$zip` applies a
/// function to all words or vectors of two sets. The functions for `up` and `down` use `BITS`.
macro_rules! each {
    ($zip:path: $($operation:ident = $both:expr),*; $($shift:ident = $shifted:expr),*) => {
        $(
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                $zip(self, other, $both)
            }
        )*
        $(
            #[inline(always)]
            fn $shift<const BITS: i32>(self) -> Self {
                $zip(self, self, $shifted)
            }
        )*
    };
}
pub(crate) use each;

/// Combines the elements of two arrays of at most 8 elements, pair by pair.
#[inline(always)]
pub(crate) fn zip<T: Copy, const N: usize>(
    mut a: [T; N],
    b: [T; N],
    both: impl Fn(T, T) -> T,
) -> [T; N] {
    const { assert!(N <= 8) };
    // Written out, because the compiler takes much longer for thousands of short loops.
    macro_rules! at {
        ($($i:literal)*) => { $(
            if $i < N {
                a[$i] = both(a[$i], b[$i]);
            }
        )* };
    }
    at!(0 1 2 3 4 5 6 7);
    a
}

/// Returns the 64-bit words of each bit set.
#[inline(always)]
pub(crate) fn to_words<H: ParityPlane>(planes: &[H; 8]) -> [H::Words; 8] {
    // `map` of arrays and `zip` are not always inlined.
    let mut words = [H::Words::repeat(0); 8];
    for (i, plane) in planes.iter().enumerate() {
        words[i] = plane.to_words();
    }
    words
}

/// Moves bit i of byte j of `planes[k]` to bit k of byte j of `planes[i]`.
#[inline(always)]
fn transpose_bits<H: ParityPlane>(planes: &mut [H; 8]) {
    macro_rules! swap {
        ($bits:literal, $mask:literal, $($low:literal $high:literal),*) => { $(
            let mask = H::from_words(H::Words::repeat($mask));
            let differing = planes[$low].down::<$bits>().xor(planes[$high]).and(mask);
            planes[$high] = planes[$high].xor(differing);
            planes[$low] = planes[$low].xor(differing.up::<$bits>());
        )* };
    }
    swap!(1, 0x5555_5555_5555_5555, 0 1, 2 3, 4 5, 6 7);
    swap!(2, 0x3333_3333_3333_3333, 0 2, 1 3, 4 6, 5 7);
    swap!(4, 0x0f0f_0f0f_0f0f_0f0f, 0 4, 1 5, 2 6, 3 7);
}

/// Moves byte i of `words[k]` to byte k of `words[i]`.
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
