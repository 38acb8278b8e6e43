//! Floods with AVX-512. The rules for `unsafe` in `x86.rs` apply here, too.
#![allow(unsafe_code)]
// Intrinsics have long names, and this file consists of them.
#![allow(clippy::wildcard_imports)]
// The feature `avx512` needs Rust 1.89; the rest of the crate does not.
#![allow(clippy::incompatible_msrv)]

use core::arch::x86_64::*;
use core::mem::transmute;

use super::plane::{BitOps, Line, ParityPlane, to_words};
use super::task::Task;
use super::x86::{Sse2, simd};

/// A vector of 128 bits with three-operand logic, which needs the AVX-512 features F and VL.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Avx512Small(Sse2);

/// A vector of 512 bits, which needs the AVX-512 features F and BW.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Avx512Large(__m512i);

#[target_feature(enable = "avx512f,avx512bw,avx512vl,bmi1,popcnt")]
pub(super) unsafe fn small_avx512<T: Task>(task: T) -> T::Output {
    task.run::<2, Avx512Small>()
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,bmi1,popcnt")]
pub(super) unsafe fn large_avx512<T: Task>(task: T) -> T::Output {
    task.run::<8, Avx512Large>()
}

impl ParityPlane<2> for Avx512Small {
    #[inline(always)]
    fn from_words(words: [u64; 2]) -> Self {
        Self(Sse2::from_words(words))
    }

    #[inline(always)]
    fn to_words(self) -> [u64; 2] {
        self.0.to_words()
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread_by_masks(&to_words(&even), &to_words(&odd), lines);
    }
}

impl BitOps for Avx512Small {
    const NONE: Self = Self(Sse2::NONE);
    const ALL: Self = Self(Sse2::ALL);

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0.and(other.0))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0.or(other.0))
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(self.0.xor(other.0))
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(self.0.without(other.0))
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        Self(self.0.up::<BITS>())
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        Self(self.0.down::<BITS>())
    }

    #[inline(always)]
    fn north(self) -> Self {
        Self(self.0.north())
    }

    #[inline(always)]
    fn south(self) -> Self {
        Self(self.0.south())
    }

    #[inline(always)]
    fn is_empty(self) -> bool {
        self.0.is_empty()
    }

    #[inline(always)]
    fn and_or(self, mask: Self, others: Self) -> Self {
        Self(Sse2(simd!(_mm_ternarylogic_epi64::<AND_OR>(self.0.0, mask.0.0, others.0.0))))
    }

    #[inline(always)]
    fn or_and(self, others: Self, mask: Self) -> Self {
        Self(Sse2(simd!(_mm_ternarylogic_epi64::<OR_AND>(self.0.0, others.0.0, mask.0.0))))
    }

    #[inline(always)]
    fn or_without(self, others: Self, mask: Self) -> Self {
        Self(Sse2(simd!(_mm_ternarylogic_epi64::<OR_WITHOUT>(self.0.0, others.0.0, mask.0.0))))
    }
}

/// Does the same as [`ParityPlane::spread`], but uses each word of a plane as a mask for 64
/// bytes.
#[inline(always)]
fn spread_by_masks<const N: usize>(
    even: &[[u64; N]; 8],
    odd: &[[u64; N]; 8],
    lines: &mut [[Line; 8]],
) {
    // Restores the order of the lines after unpacking.
    let order = simd!([
        _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
        _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4),
    ]);
    for (word, lines) in lines.iter_mut().enumerate() {
        let (even, odd) = (bytes_of(even, word), bytes_of(odd, word));
        let first = simd!(_mm512_unpacklo_epi8(even, odd));
        let second = simd!(_mm512_unpackhi_epi8(even, odd));
        let south = simd!(_mm512_permutex2var_epi64(first, order[0], second));
        let north = simd!(_mm512_permutex2var_epi64(first, order[1], second));
        *lines = simd!(transmute::<[__m512i; 2], [Line; 8]>([south, north]));
    }
}

/// Returns 64 bytes. Bit i of byte j is bit j of `planes[i][word]`.
#[inline(always)]
fn bytes_of<const N: usize>(planes: &[[u64; N]; 8], word: usize) -> __m512i {
    let mut bytes = simd!(_mm512_setzero_si512());
    for (i, plane) in planes.iter().enumerate() {
        let bit = simd!(_mm512_set1_epi8(1 << i));
        bytes = simd!(_mm512_mask_add_epi8(bytes, plane[word], bytes, bit));
    }
    bytes
}

/// Truth tables of three-operand logic: bit 4a + 2b + c is the result for the bits a, b and c.
const AND_OR: i32 = 0b1110_1010;
const OR_AND: i32 = 0b1010_1000;
const OR_WITHOUT: i32 = 0b0101_0100;

/// Returns 32 consecutive row numbers, starting at `further`, modulo 32.
const fn neighbour_rows(further: u16) -> [u16; 32] {
    let mut rows = [further; 32];
    let mut row = 1;
    while row < rows.len() {
        rows[row] = (rows[row - 1] + 1) % 32;
        row += 1;
    }
    rows
}

impl ParityPlane<8> for Avx512Large {
    #[inline(always)]
    fn from_words(words: [u64; 8]) -> Self {
        Self(simd!(transmute::<[u64; 8], __m512i>(words)))
    }

    #[inline(always)]
    fn to_words(self) -> [u64; 8] {
        simd!(transmute::<__m512i, [u64; 8]>(self.0))
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread_by_masks(&to_words(&even), &to_words(&odd), lines);
    }
}

impl BitOps for Avx512Large {
    const NONE: Self = Self(simd!(transmute::<[u64; 8], __m512i>([0; 8])));
    const ALL: Self = Self(simd!(transmute::<[u64; 8], __m512i>([u64::MAX; 8])));

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(simd!(_mm512_and_si512(self.0, other.0)))
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(simd!(_mm512_or_si512(self.0, other.0)))
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        Self(simd!(_mm512_xor_si512(self.0, other.0)))
    }

    #[inline(always)]
    fn without(self, other: Self) -> Self {
        Self(simd!(_mm512_andnot_si512(other.0, self.0)))
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        let bits = simd!(_mm_cvtsi32_si128(BITS));
        Self(simd!(_mm512_sll_epi64(self.0, bits)))
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        let bits = simd!(_mm_cvtsi32_si128(BITS));
        Self(simd!(_mm512_srl_epi64(self.0, bits)))
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

    #[inline(always)]
    fn and_or(self, mask: Self, others: Self) -> Self {
        Self(simd!(_mm512_ternarylogic_epi64::<AND_OR>(self.0, mask.0, others.0)))
    }

    #[inline(always)]
    fn or_and(self, others: Self, mask: Self) -> Self {
        Self(simd!(_mm512_ternarylogic_epi64::<OR_AND>(self.0, others.0, mask.0)))
    }

    #[inline(always)]
    fn or_without(self, others: Self, mask: Self) -> Self {
        Self(simd!(_mm512_ternarylogic_epi64::<OR_WITHOUT>(self.0, others.0, mask.0)))
    }
}
