//! Floods with SSE2, which every x86-64 processor has, and with AVX2. This file is only compiled if
//! the compiler may use SSE2.
//!
//! Only this file, `avx512.rs` and `dispatch.rs` contain `unsafe` code. Intrinsics need `unsafe`
//! outside functions that enable their feature, and trait methods cannot enable features. None of
//! the intrinsics used here accesses memory through a pointer, so the only requirement is that the
//! processor has the instruction. SSE2 is always available on x86-64. Code for other features is
//! only reached through functions that enable these features. `dispatch.rs` calls such a function
//! only if the processor supports its features.
#![allow(unsafe_code)]
// Intrinsics have long names, and this file consists of them.
#![allow(clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::mem::transmute;

use super::plane::{BitOps, Line, ParityPlane};
use super::task::Task;

/// A vector of 128 bits.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(super) struct Sse2(pub(super) __m128i);

/// Four vectors of 128 bits.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(super) struct Sse2Large([__m128i; 4]);

/// Runs a task on SSE2 planes, for which the compiler selects AVX2 instructions.
#[target_feature(enable = "avx2,bmi1,popcnt")]
pub(super) unsafe fn small_avx2<T: Task>(task: T) -> T::Output {
    task.run::<2, Sse2>()
}

#[target_feature(enable = "avx2,bmi1,popcnt")]
pub(super) unsafe fn large_avx2<T: Task>(task: T) -> T::Output {
    task.run::<8, Sse2Large>()
}

/// Calls an intrinsic. The safety rules are at the top of this file.
macro_rules! simd {
    ($call:expr) => {
        unsafe { $call }
    };
}
#[cfg(feature = "avx512")]
pub(super) use simd;

impl ParityPlane<2> for Sse2 {
    #[inline(always)]
    fn from_words(words: [u64; 2]) -> Self {
        Self(simd!(transmute::<[u64; 2], __m128i>(words)))
    }

    #[inline(always)]
    fn to_words(self) -> [u64; 2] {
        simd!(transmute::<__m128i, [u64; 2]>(self.0))
    }

    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        let parts = |planes| simd!(transmute::<[Self; 8], [[__m128i; 1]; 8]>(planes));
        interleave(&parts(*even), &parts(*odd), lines);
    }
}

/// Does the same as [`ParityPlane::interleave`], 16 lines at a time.
#[inline(always)]
fn interleave<const PARTS: usize>(
    even: &[[__m128i; PARTS]; 8],
    odd: &[[__m128i; PARTS]; 8],
    lines: &mut [[Line; 8]],
) {
    for (part, lines) in lines.chunks_exact_mut(2).enumerate() {
        let mut pairs = [[Sse2::NONE.0; 8]; 2];
        for (i, (even, odd)) in even.iter().zip(odd).enumerate() {
            pairs[0][i] = simd!(_mm_unpacklo_epi8(even[part], odd[part]));
            pairs[1][i] = simd!(_mm_unpackhi_epi8(even[part], odd[part]));
        }
        for (lines, pairs) in lines.iter_mut().zip(pairs) {
            *lines = simd!(transmute::<[__m128i; 8], [Line; 8]>(transposed_pairs(pairs)));
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

impl BitOps for Sse2 {
    const NONE: Self = Self(simd!(transmute::<[u64; 2], __m128i>([0; 2])));
    const ALL: Self = Self(simd!(transmute::<[u64; 2], __m128i>([u64::MAX; 2])));

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(simd!(_mm_and_si128(self.0, other.0)))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(simd!(_mm_or_si128(self.0, other.0)))
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(simd!(_mm_xor_si128(self.0, other.0)))
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(simd!(_mm_andnot_si128(other.0, self.0)))
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        Self(simd!(_mm_slli_epi64::<BITS>(self.0)))
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        Self(simd!(_mm_srli_epi64::<BITS>(self.0)))
    }

    #[inline(always)]
    fn north(self) -> Self {
        Self(simd!(_mm_slli_si128::<1>(self.0)))
    }

    #[inline(always)]
    fn south(self) -> Self {
        Self(simd!(_mm_srli_si128::<1>(self.0)))
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        let bytes = simd!(_mm_cmpeq_epi8(self.0, _mm_setzero_si128()));
        simd!(_mm_movemask_epi8(bytes)) == 0xffff
    }
}

impl ParityPlane<8> for Sse2Large {
    #[inline(always)]
    fn from_words(words: [u64; 8]) -> Self {
        Self(simd!(transmute::<[u64; 8], [__m128i; 4]>(words)))
    }

    #[inline(always)]
    fn to_words(self) -> [u64; 8] {
        simd!(transmute::<[__m128i; 4], [u64; 8]>(self.0))
    }

    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        let parts = |planes| simd!(transmute::<[Self; 8], [[__m128i; 4]; 8]>(planes));
        interleave(&parts(*even), &parts(*odd), lines);
    }
}

impl Sse2Large {
    #[inline(always)]
    fn zip(mut self, other: Self, both: impl Fn(__m128i, __m128i) -> __m128i) -> Self {
        for (one, other) in self.0.iter_mut().zip(other.0) {
            *one = both(*one, other);
        }
        self
    }
}

impl BitOps for Sse2Large {
    const NONE: Self = Self([Sse2::NONE.0; 4]);
    const ALL: Self = Self([Sse2::ALL.0; 4]);

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self.zip(other, |a, b| simd!(_mm_and_si128(a, b)))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.zip(other, |a, b| simd!(_mm_or_si128(a, b)))
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self.zip(other, |a, b| simd!(_mm_xor_si128(a, b)))
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        self.zip(other, |a, b| simd!(_mm_andnot_si128(b, a)))
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        self.zip(self, |a, _| simd!(_mm_slli_epi64::<BITS>(a)))
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        self.zip(self, |a, _| simd!(_mm_srli_epi64::<BITS>(a)))
    }

    #[inline(always)]
    fn north(self) -> Self {
        let [a, b, c, _] = self.0;
        let from_south = Self([Sse2::NONE.0, a, b, c]);
        self.zip(from_south, |row, south| {
            simd!(_mm_or_si128(_mm_slli_si128::<2>(row), _mm_srli_si128::<14>(south)))
        })
    }

    #[inline(always)]
    fn south(self) -> Self {
        let [_, b, c, d] = self.0;
        let from_north = Self([b, c, d, Sse2::NONE.0]);
        self.zip(from_north, |row, north| {
            simd!(_mm_or_si128(_mm_srli_si128::<2>(row), _mm_slli_si128::<14>(north)))
        })
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        let [a, b, c, d] = self.0.map(Sse2);
        a.or(b).or(c.or(d)).is_empty()
    }
}
