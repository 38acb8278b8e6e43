//! Floods without vector instructions.

use super::plane::{BitOps, ParityPlane, each, zip};

impl<const N: usize> ParityPlane for [u64; N] {
    type Words = Self;

    #[inline(always)]
    fn from_words(words: Self) -> Self {
        words
    }

    #[inline(always)]
    fn to_words(self) -> Self {
        self
    }
}

impl<const N: usize> BitOps for [u64; N] {
    const NONE: Self = [0; N];
    const ALL: Self = [u64::MAX; N];

    each! {
        zip: and = |a, b| a & b, or = |a, b| a | b, xor = |a, b| a ^ b, without = |a, b| a & !b;
        up = |word, _| word << BITS, down = |word, _| word >> BITS
    }

    #[inline(always)]
    fn north(self) -> Self {
        let row = Self::ROW_BITS;
        let mut moved = [0; N];
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved = self[i] << row | if i > 0 { self[i - 1] >> (64 - row) } else { 0 };
        }
        moved
    }

    #[inline(always)]
    fn south(self) -> Self {
        let row = Self::ROW_BITS;
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
