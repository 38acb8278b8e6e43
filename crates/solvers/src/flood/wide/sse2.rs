//! Floods with SSE2, which every x86-64 processor has, and with AVX2. This file is compiled only if
//! SSE2 is enabled for the target.
//!
//! Only this file, `avx512.rs` and `dispatch.rs` contain `unsafe` code. A call to an intrinsic is
//! `unsafe` unless the calling function enables the intrinsic's feature, and trait methods cannot
//! enable features. None of the intrinsics used here accesses memory through a pointer, so the only
//! requirement is that the processor supports the instruction. SSE2 is always available on x86-64.
//! Code that needs other processor features runs only inside functions that enable these features.
//! `dispatch.rs` calls such a function only if the processor supports the features.
#![allow(unsafe_code)]
// Intrinsics have long names, and this file consists of them.
#![allow(clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::mem::transmute;

use super::plane::{BitOps, ParityPlane, each, zip};
use crate::flood::steps::ByteRow;

/// A set of cells of one chessboard colour, stored in 128-bit vectors. Mazes of up to 16×16 cells
/// need one vector, and larger mazes need four.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct Sse2<const VECTORS: usize>(pub(super) [__m128i; VECTORS]);

/// Calls an intrinsic. The safety rules are at the top of this file.
macro_rules! simd {
    ($call:expr) => {
        unsafe { $call }
    };
}
#[cfg(feature = "avx512")]
pub(crate) use simd;

macro_rules! parity_plane {
    ($words:literal, $vectors:literal) => {
        impl ParityPlane for Sse2<$vectors> {
            type Words = [u64; $words];

            #[inline(always)]
            fn from_words(words: Self::Words) -> Self {
                Self(simd!(transmute::<Self::Words, [__m128i; $vectors]>(words)))
            }

            #[inline(always)]
            fn to_words(self) -> Self::Words {
                simd!(transmute::<[__m128i; $vectors], Self::Words>(self.0))
            }

            #[inline(always)]
            fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[ByteRow; 8]]) {
                interleave(even, odd, lines);
            }
        }
    };
}
parity_plane!(2, 1);
parity_plane!(8, 4);

/// Does the same as [`ParityPlane::interleave`], 16 lines at a time.
#[inline(always)]
fn interleave<const VECTORS: usize>(
    even: &[Sse2<VECTORS>; 8],
    odd: &[Sse2<VECTORS>; 8],
    lines: &mut [[ByteRow; 8]],
) {
    for (vector, lines) in lines.chunks_exact_mut(2).enumerate() {
        let mut pairs = [[NONE; 8]; 2];
        for (i, (even, odd)) in even.iter().zip(odd).enumerate() {
            pairs[0][i] = simd!(_mm_unpacklo_epi8(even.0[vector], odd.0[vector]));
            pairs[1][i] = simd!(_mm_unpackhi_epi8(even.0[vector], odd.0[vector]));
        }
        for (lines, pairs) in lines.iter_mut().zip(pairs) {
            *lines = simd!(transmute::<[__m128i; 8], [ByteRow; 8]>(transposed_pairs(pairs)));
        }
    }
}

/// Moves byte pair i of row k to byte pair k of row i.
#[inline(always)]
fn transposed_pairs([a, b, c, d, e, f, g, h]: [__m128i; 8]) -> [__m128i; 8] {
    let twos = |a, b| simd!([_mm_unpacklo_epi16(a, b), _mm_unpackhi_epi16(a, b)]);
    let fours = |a, b| simd!([_mm_unpacklo_epi32(a, b), _mm_unpackhi_epi32(a, b)]);
    let eights = |a, b| simd!([_mm_unpacklo_epi64(a, b), _mm_unpackhi_epi64(a, b)]);
    let ([ab, ab_high], [cd, cd_high]) = (twos(a, b), twos(c, d));
    let ([ef, ef_high], [gh, gh_high]) = (twos(e, f), twos(g, h));
    let half = |ab, cd, ef, gh| {
        let ([west, west_next], [east, east_next]) = (fours(ab, cd), fours(ef, gh));
        (eights(west, east), eights(west_next, east_next))
    };
    let (([a, b], [c, d]), ([e, f], [g, h])) =
        (half(ab, cd, ef, gh), half(ab_high, cd_high, ef_high, gh_high));
    [a, b, c, d, e, f, g, h]
}

const NONE: __m128i = simd!(transmute::<[u64; 2], __m128i>([0; 2]));
const ALL: __m128i = simd!(transmute::<[u64; 2], __m128i>([u64::MAX; 2]));

impl<const VECTORS: usize> Sse2<VECTORS> {
    #[inline(always)]
    fn zip(self, other: Self, both: impl Fn(__m128i, __m128i) -> __m128i) -> Self {
        Self(zip(self.0, other.0, both))
    }
}

impl<const VECTORS: usize> BitOps for Sse2<VECTORS> {
    const NONE: Self = Self([NONE; VECTORS]);
    const ALL: Self = Self([ALL; VECTORS]);

    each! {
        Self::zip:
        and = |a, b| simd!(_mm_and_si128(a, b)),
        or = |a, b| simd!(_mm_or_si128(a, b)),
        xor = |a, b| simd!(_mm_xor_si128(a, b)),
        without = |a, b| simd!(_mm_andnot_si128(b, a));
        up = |a, _| simd!(_mm_slli_epi64::<BITS>(a)),
        down = |a, _| simd!(_mm_srli_epi64::<BITS>(a))
    }

    #[inline(always)]
    fn north(mut self) -> Self {
        let mut from_south = NONE;
        for vector in &mut self.0 {
            let (row, rows) = (simd!(_mm_srli_si128::<14>(*vector)), *vector);
            *vector = if VECTORS == 1 {
                simd!(_mm_slli_si128::<1>(rows))
            } else {
                simd!(_mm_or_si128(_mm_slli_si128::<2>(rows), from_south))
            };
            from_south = row;
        }
        self
    }

    #[inline(always)]
    fn south(mut self) -> Self {
        let mut from_north = NONE;
        for vector in self.0.iter_mut().rev() {
            let (row, rows) = (simd!(_mm_slli_si128::<14>(*vector)), *vector);
            *vector = if VECTORS == 1 {
                simd!(_mm_srli_si128::<1>(rows))
            } else {
                simd!(_mm_or_si128(_mm_srli_si128::<2>(rows), from_north))
            };
            from_north = row;
        }
        self
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        let all = self.0.into_iter().fold(NONE, |all, vector| simd!(_mm_or_si128(all, vector)));
        let bytes = simd!(_mm_cmpeq_epi8(all, NONE));
        simd!(_mm_movemask_epi8(bytes)) == 0xffff
    }
}
