//! Half of the cells of a maze, a bit each.

use super::bytes::{Line, interleave, spread};

/// Half of the cells of a maze, those of one colour of a chessboard, a bit each.
///
/// ```text
///   y = 1 | light dark  light dark        A step always leads to the other colour, so one half
///   y = 0 | dark  light dark  light       of the bits is all that a wave needs.
///          -------------------------
///            x = 0   1     2     3
/// ```
///
/// The cells of a row follow each other from the west, so that bit x / 2 is the cell in column x;
/// the rows follow each other from the south. A row takes 8 bits in mazes of up to 16×16 cells,
/// which `N` = 2 words hold, and 16 bits in those of up to 32×32 cells, which takes 8 words.
///
/// Shifts may carry a bit into another row. The masks of [`Board`](super::board::Board) see to that.
pub(super) trait Half<const N: usize>: Bits {
    /// The half with these words, the southernmost first.
    fn of(words: [u64; N]) -> Self;

    fn words(self) -> [u64; N];

    /// See [`spread`], which some processors have instructions for.
    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread(even, odd, lines);
    }

    /// See [`interleave`], the same.
    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        interleave(even, odd, lines);
    }
}

/// What a wave does with half of the cells.
pub(super) trait Bits: Copy {
    /// No cell.
    const NONE: Self;
    /// All bits.
    const ALL: Self;

    fn and(self, other: Self) -> Self;

    fn or(self, other: Self) -> Self;

    fn xor(self, other: Self) -> Self;

    /// Those that are not among the others.
    fn without(self, other: Self) -> Self;

    /// Each bit moved up by a few within its word.
    fn up<const BITS: i32>(self) -> Self;

    /// Each bit moved down by a few within its word.
    fn down<const BITS: i32>(self) -> Self;

    /// Each cell's bit a row further to the north.
    fn north(self) -> Self;

    /// Each cell's bit a row further to the south.
    fn south(self) -> Self;

    fn is_empty(self) -> bool;

    /// (self & mask) | others
    #[inline(always)]
    fn and_or(self, mask: Self, others: Self) -> Self {
        self.and(mask).or(others)
    }

    /// (self | others) & mask
    #[inline(always)]
    fn or_and(self, others: Self, mask: Self) -> Self {
        self.or(others).and(mask)
    }

    /// (self | others) & !mask
    #[inline(always)]
    fn or_without(self, others: Self, mask: Self) -> Self {
        self.or(others).without(mask)
    }
}

/// How many bits a row takes.
pub(super) const fn row_bits(words: usize) -> u32 {
    if words == 2 { 8 } else { 16 }
}

/// On any processor.
impl<const N: usize> Half<N> for [u64; N] {
    #[inline(always)]
    fn of(words: [u64; N]) -> Self {
        words
    }

    #[inline(always)]
    fn words(self) -> [u64; N] {
        self
    }
}

impl<const N: usize> Bits for [u64; N] {
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
