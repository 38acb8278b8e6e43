//! Floods with AVX-512. The rules for `unsafe` code at the top of `sse2.rs` also apply to this file.
#![allow(unsafe_code)]
// Intrinsics have long names, and this file consists of them.
#![allow(clippy::wildcard_imports)]
// The `avx512` feature needs Rust 1.89; the rest of the crate does not.
#![allow(clippy::incompatible_msrv)]

use core::arch::x86_64::*;
use core::mem::transmute;

use super::plane::{BitOps, ParityPlane, Words, each, to_words};
use super::sse2::{Sse2, simd};
use crate::flood::steps::ByteRow;

/// A 128-bit vector, whose three-operand logic requires the AVX-512 features F and VL.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Avx512Small(Sse2<1>);

/// A 512-bit vector, whose operations require the AVX-512 features F and BW.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Avx512Large(__m512i);

impl ParityPlane for Avx512Small {
    type Words = [u64; 2];

    #[inline(always)]
    fn from_words(words: Self::Words) -> Self {
        Self(Sse2::from_words(words))
    }

    #[inline(always)]
    fn to_words(self) -> Self::Words {
        self.0.to_words()
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[ByteRow; 8]]) {
        spread_by_masks(&even, &odd, lines);
    }
}

impl Avx512Small {
    #[inline(always)]
    fn ternary<const TABLE: i32>(self, b: Self, c: Self) -> Self {
        let (Sse2([a]), Sse2([b]), Sse2([c])) = (self.0, b.0, c.0);
        Self(Sse2([simd!(_mm_ternarylogic_epi64::<TABLE>(a, b, c))]))
    }
}

/// Defines the operations on three sets by truth tables. Bit 4a + 2b + c of a table is the result for
/// the bits a, b and c.
macro_rules! ternary_ops {
    () => {
        ternary_ops!(and_or 0b1110_1010, or_and 0b1010_1000, or_without 0b0101_0100);
    };
    ($($operation:ident $table:literal),*) => { $(
        #[inline(always)]
        fn $operation(self, b: Self, c: Self) -> Self {
            self.ternary::<$table>(b, c)
        }
    )* };
}

/// Forwards operations to the inner SSE2 vector.
macro_rules! forward {
    ($($operation:ident($($other:ident)?)),*) => { $(
        #[inline(always)]
        fn $operation(self $(, $other: Self)?) -> Self {
            Self(self.0.$operation($($other.0)?))
        }
    )* };
}

impl BitOps for Avx512Small {
    const NONE: Self = Self(Sse2::NONE);
    const ALL: Self = Self(Sse2::ALL);

    forward!(and(other), or(other), xor(other), without(other), north(), south());

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        Self(self.0.up::<BITS>())
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        Self(self.0.down::<BITS>())
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    ternary_ops!();
}

/// Implements [`ParityPlane::spread`] with masked instructions, in which each bit of a 64-bit word
/// selects one of 64 bytes.
#[inline(always)]
fn spread_by_masks<H: ParityPlane>(even: &[H; 8], odd: &[H; 8], lines: &mut [[ByteRow; 8]]) {
    let (even, odd) = (to_words(even), to_words(odd));
    // Restores the order of the lines after unpacking.
    let order = simd!([
        _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
        _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4),
    ]);
    for (word, lines) in lines.iter_mut().enumerate() {
        let (even, odd) = (bytes_of(&even, word), bytes_of(&odd, word));
        let first = simd!(_mm512_unpacklo_epi8(even, odd));
        let second = simd!(_mm512_unpackhi_epi8(even, odd));
        let south = simd!(_mm512_permutex2var_epi64(first, order[0], second));
        let north = simd!(_mm512_permutex2var_epi64(first, order[1], second));
        *lines = simd!(transmute::<[__m512i; 2], [ByteRow; 8]>([south, north]));
    }
}

/// Returns 64 bytes, in which bit i of byte j is bit j of `planes[i][word]`.
#[inline(always)]
fn bytes_of<W: Words>(planes: &[W; 8], word: usize) -> __m512i {
    let mut bytes = simd!(_mm512_setzero_si512());
    for (i, plane) in planes.iter().enumerate() {
        let bit = simd!(_mm512_set1_epi8(1 << i));
        bytes = simd!(_mm512_mask_add_epi8(bytes, plane.as_ref()[word], bytes, bit));
    }
    bytes
}

/// Returns the row numbers from `further` to 31, followed by those from 0 to `further` - 1.
const fn neighbour_rows(further: u16) -> [u16; 32] {
    let mut rows = [further; 32];
    let mut row = 1;
    while row < rows.len() {
        rows[row] = (rows[row - 1] + 1) % 32;
        row += 1;
    }
    rows
}

impl ParityPlane for Avx512Large {
    type Words = [u64; 8];

    #[inline(always)]
    fn from_words(words: Self::Words) -> Self {
        Self(simd!(transmute::<Self::Words, __m512i>(words)))
    }

    #[inline(always)]
    fn to_words(self) -> Self::Words {
        simd!(transmute::<__m512i, Self::Words>(self.0))
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[ByteRow; 8]]) {
        spread_by_masks(&even, &odd, lines);
    }
}

impl Avx512Large {
    #[inline(always)]
    fn zip(self, other: Self, both: impl Fn(__m512i, __m512i) -> __m512i) -> Self {
        Self(both(self.0, other.0))
    }

    #[inline(always)]
    fn ternary<const TABLE: i32>(self, b: Self, c: Self) -> Self {
        Self(simd!(_mm512_ternarylogic_epi64::<TABLE>(self.0, b.0, c.0)))
    }
}

impl BitOps for Avx512Large {
    const NONE: Self = Self(simd!(transmute::<[u64; 8], __m512i>([0; 8])));
    const ALL: Self = Self(simd!(transmute::<[u64; 8], __m512i>([u64::MAX; 8])));

    each! {
        Self::zip:
        and = |a, b| simd!(_mm512_and_si512(a, b)),
        or = |a, b| simd!(_mm512_or_si512(a, b)),
        xor = |a, b| simd!(_mm512_xor_si512(a, b)),
        without = |a, b| simd!(_mm512_andnot_si512(b, a));
        up = |a, _| simd!(_mm512_sll_epi64(a, _mm_cvtsi32_si128(BITS))),
        down = |a, _| simd!(_mm512_srl_epi64(a, _mm_cvtsi32_si128(BITS)))
    }

    #[inline(always)]
    fn north(self) -> Self {
        let rows = simd!(transmute::<[u16; 32], __m512i>(neighbour_rows(31)));
        Self(simd!(_mm512_maskz_permutexvar_epi16(!1, rows, self.0)))
    }

    #[inline(always)]
    fn south(self) -> Self {
        let rows = simd!(transmute::<[u16; 32], __m512i>(neighbour_rows(1)));
        Self(simd!(_mm512_maskz_permutexvar_epi16(!0 >> 1, rows, self.0)))
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        simd!(_mm512_test_epi64_mask(self.0, self.0)) == 0
    }

    ternary_ops!();
}
