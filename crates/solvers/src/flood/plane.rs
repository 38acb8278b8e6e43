//! Parity planes, which store the cells of one chessboard colour with one bit per cell.

use mmsim_maze::MazeSize;

use super::transpose::{Line, interleave, spread};

/// The longest side of a maze in cells.
pub(super) const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The longest side of a small maze, whose planes take two words each.
pub(super) const SMALL_SIDE: usize = 16;

/// Returns true if the planes of a maze of this size take two words instead of eight.
pub(super) const fn is_small(size: MazeSize) -> bool {
    size.width() as usize <= SMALL_SIDE && size.height() as usize <= SMALL_SIDE
}

/// A set of cells of one chessboard colour, with one bit per cell.
///
/// ```text
///   y = 1 | light dark  light dark        A step always leads to the other colour, so a wave
///   y = 0 | dark  light dark  light       needs only half of the bits.
///          -------------------------
///            x = 0   1     2     3
/// ```
///
/// Rows are stored from south to north. Bit x / 2 of a row is the cell in column x. In mazes of up
/// to 16×16 cells, a row takes 8 bits and a plane takes `N` = 2 words. In larger mazes, a row takes
/// 16 bits and a plane takes 8 words.
///
/// Shifts may carry bits into another row, but the masks of [`Bitboard`](super::bitboard::Bitboard)
/// remove such bits.
pub(super) trait ParityPlane<const N: usize>: BitOps {
    /// Creates a plane from words in the order from south to north.
    fn from_words(words: [u64; N]) -> Self;

    fn to_words(self) -> [u64; N];

    /// Calls [`spread`], or uses special instructions for the same result.
    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread(even, odd, lines);
    }

    /// Calls [`interleave`], or uses special instructions for the same result.
    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        interleave(even, odd, lines);
    }
}

/// The bit operations of a wave.
pub(super) trait BitOps: Copy {
    /// No cell.
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

/// Returns the number of bits per row in a plane of `words` words.
pub(super) const fn row_bits(words: usize) -> u32 {
    if words == 2 { 8 } else { 16 }
}

/// The portable implementation.
impl<const N: usize> ParityPlane<N> for [u64; N] {
    #[inline(always)]
    fn from_words(words: [u64; N]) -> Self {
        words
    }

    #[inline(always)]
    fn to_words(self) -> [u64; N] {
        self
    }
}

impl<const N: usize> BitOps for [u64; N] {
    const NONE: Self = [0; N];
    const ALL: Self = [u64::MAX; N];

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        zip(self, other, |a, b| a & b)
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        zip(self, other, |a, b| a | b)
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        zip(self, other, |a, b| a ^ b)
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        zip(self, other, |a, b| a & !b)
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        zip(self, self, |word, _| word << BITS)
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        zip(self, self, |word, _| word >> BITS)
    }

    #[inline(always)]
    fn north(self) -> Self {
        let row = row_bits(N);
        let mut moved = [0; N];
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved = self[i] << row | if i > 0 { self[i - 1] >> (64 - row) } else { 0 };
        }
        moved
    }

    #[inline(always)]
    fn south(self) -> Self {
        let row = row_bits(N);
        let mut moved = [0; N];
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved = self[i] >> row | if i + 1 < N { self[i + 1] << (64 - row) } else { 0 };
        }
        moved
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.iter().fold(0, |all, word| all | word) == 0
    }
}

#[inline(always)]
fn zip<const N: usize>(mut a: [u64; N], b: [u64; N], both: impl Fn(u64, u64) -> u64) -> [u64; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a = both(*a, b);
    }
    a
}
