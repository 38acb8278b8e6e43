//! Floods with what x86-64 processors offer: SSE2, which all of them have, AVX2 and AVX-512 where they
//! are. This file is there only where the compiler may use SSE2.
//!
//! The only file with `unsafe`. Intrinsics ask for it outside of functions that name their feature,
//! and methods of traits cannot name one. None of those here reads or writes memory through a
//! pointer, so that all there is to see to is that the processor knows the instruction. SSE2 is there,
//! see above. Values of the other types are made and used within the functions that are marked with
//! their features, which [`run_with`] calls after it has asked the processor.
#![allow(unsafe_code)]
// Intrinsics have long names, and are what this file is about.
#![allow(clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::mem::transmute;

use mmsim_maze::MazeSize;

use super::bytes::{Line, words_of};
use super::half::{Bits, Half};
use super::is_small;
use super::processor::{Instructions, Task, large, small};

/// 128 bits.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Sse2(__m128i);

/// Four times 128 bits.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Sse2Large([__m128i; 4]);

/// 128 bits with three-way logic, which takes the features F and VL.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Avx512Small(Sse2);

/// 512 bits, which take the features F and BW.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Avx512Large(__m512i);

/// Does this with these instructions, or with lesser ones if they are not there.
pub(super) fn run_with<T: Task>(instructions: Instructions, task: T, size: MazeSize) -> T::Output {
    use Instructions::{Avx2, Avx512, Portable, Sse2};
    let is_available = |some: Instructions| some.is_available();
    // One call, so that what it gives is made where it goes.
    let run: unsafe fn(T) -> T::Output = match (instructions, is_small(size)) {
        (Portable, true) => small,
        (Portable, false) => large,
        (Avx512, true) if is_available(Avx512) => small_avx512,
        (Avx512, false) if is_available(Avx512) => large_avx512,
        (Avx512 | Avx2, true) if is_available(Avx2) => small_avx2,
        (Avx512 | Avx2, false) if is_available(Avx2) => large_avx2,
        (Avx512 | Avx2 | Sse2, true) => T::run::<2, self::Sse2>,
        (Avx512 | Avx2 | Sse2, false) => T::run::<8, Sse2Large>,
    };
    // SAFETY: the processor has what it needs, which was just seen for all but SSE2.
    unsafe { run(task) }
}

/// With the same halves as SSE2: the compiler does the rest.
#[target_feature(enable = "avx2,bmi1,popcnt")]
fn small_avx2<T: Task>(task: T) -> T::Output {
    task.run::<2, Sse2>()
}

#[target_feature(enable = "avx2,bmi1,popcnt")]
fn large_avx2<T: Task>(task: T) -> T::Output {
    task.run::<8, Sse2Large>()
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,bmi1,popcnt")]
fn small_avx512<T: Task>(task: T) -> T::Output {
    task.run::<2, Avx512Small>()
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,bmi1,popcnt")]
fn large_avx512<T: Task>(task: T) -> T::Output {
    task.run::<8, Avx512Large>()
}

/// An intrinsic, see the head of this file.
macro_rules! simd {
    ($call:expr) => {
        unsafe { $call }
    };
}

impl Half<2> for Sse2 {
    #[inline(always)]
    fn of(words: [u64; 2]) -> Self {
        Self(simd!(transmute::<[u64; 2], __m128i>(words)))
    }

    #[inline(always)]
    fn words(self) -> [u64; 2] {
        simd!(transmute::<__m128i, [u64; 2]>(self.0))
    }

    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        let parts = |halves| simd!(transmute::<[Self; 8], [[__m128i; 1]; 8]>(halves));
        interleave(&parts(*even), &parts(*odd), lines);
    }
}

/// As [`super::bytes::interleave`] does it, 16 lines at a time.
#[inline(always)]
fn interleave<const PARTS: usize>(
    even: &[[__m128i; PARTS]; 8],
    odd: &[[__m128i; PARTS]; 8],
    lines: &mut [[Line; 8]],
) {
    for (part, lines) in lines.as_chunks_mut::<2>().0.iter_mut().enumerate() {
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

/// Pair i of bytes of row k becomes pair k of row i.
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

impl Bits for Sse2 {
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

impl Half<8> for Sse2Large {
    #[inline(always)]
    fn of(words: [u64; 8]) -> Self {
        Self(simd!(transmute::<[u64; 8], [__m128i; 4]>(words)))
    }

    #[inline(always)]
    fn words(self) -> [u64; 8] {
        simd!(transmute::<[__m128i; 4], [u64; 8]>(self.0))
    }

    #[inline(always)]
    fn interleave(even: &[Self; 8], odd: &[Self; 8], lines: &mut [[Line; 8]]) {
        let parts = |halves| simd!(transmute::<[Self; 8], [[__m128i; 4]; 8]>(halves));
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

impl Bits for Sse2Large {
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

impl Half<2> for Avx512Small {
    #[inline(always)]
    fn of(words: [u64; 2]) -> Self {
        Self(Sse2::of(words))
    }

    #[inline(always)]
    fn words(self) -> [u64; 2] {
        self.0.words()
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread_by_masks(&words_of(&even), &words_of(&odd), lines);
    }
}

impl Bits for Avx512Small {
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

/// As [`super::bytes::spread`] does it, with a plane's word as the mask of 64 bytes.
#[inline(always)]
fn spread_by_masks<const N: usize>(
    even: &[[u64; N]; 8],
    odd: &[[u64; N]; 8],
    lines: &mut [[Line; 8]],
) {
    // What unpacking has parted into first and second lines comes together again.
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

/// The bytes whose bits are those of this word of each plane.
#[inline(always)]
fn bytes_of<const N: usize>(planes: &[[u64; N]; 8], word: usize) -> __m512i {
    let mut bytes = simd!(_mm512_setzero_si512());
    for (i, plane) in planes.iter().enumerate() {
        let bit = simd!(_mm512_set1_epi8(1 << i));
        bytes = simd!(_mm512_mask_add_epi8(bytes, plane[word], bytes, bit));
    }
    bytes
}

/// What three bits a, b and c give: bit 4a + 2b + c.
const AND_OR: i32 = 0b1110_1010;
const OR_AND: i32 = 0b1010_1000;
const OR_WITHOUT: i32 = 0b0101_0100;

/// For each row of 32 the one so many rows further to the north, round and round.
const fn neighbour_rows(further: u16) -> [u16; 32] {
    let mut rows = [further; 32];
    let mut row = 1;
    while row < rows.len() {
        rows[row] = (rows[row - 1] + 1) % 32;
        row += 1;
    }
    rows
}

impl Half<8> for Avx512Large {
    #[inline(always)]
    fn of(words: [u64; 8]) -> Self {
        Self(simd!(transmute::<[u64; 8], __m512i>(words)))
    }

    #[inline(always)]
    fn words(self) -> [u64; 8] {
        simd!(transmute::<__m512i, [u64; 8]>(self.0))
    }

    #[inline(always)]
    fn spread(even: [Self; 8], odd: [Self; 8], lines: &mut [[Line; 8]]) {
        spread_by_masks(&words_of(&even), &words_of(&odd), lines);
    }
}

impl Bits for Avx512Large {
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
