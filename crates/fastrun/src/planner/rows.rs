//! Sets of cells as lines of bits, so that one operation works on all cells of a line.

use core::array::from_fn;
use core::ops::{BitAnd, BitOr, Not};

/// A line of up to 16 or 32 cells, with one bit for each.
pub(super) trait Line:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    const BITS: u32;
    const NONE: Self;
    /// Holds four lines side by side, the first one in the lowest bits.
    type Four: Four;

    fn from_low_bits(bits: u32) -> Self;
    fn to_bits(self) -> u32;
    fn trailing_ones(self) -> u32;
    fn shl(self, count: u32) -> Self;
    fn shr(self, count: u32) -> Self;
    fn reversed(self) -> Self;
    /// Returns the first `count` bits of four lines, beginning with bit `first`.
    fn cut(lines: [Self; 4], first: u32, count: u32) -> Self::Four;
}

/// Eight lines, in two groups of four.
#[derive(Clone, Copy)]
pub(super) struct Eight<F>(pub(super) F, pub(super) F);

impl<F: Four> Eight<F> {
    /// Removes the lowest bit, and returns the number of its line and its position in the line.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(usize, u32)> {
        if let Some(found) = self.0.pop() {
            return Some(found);
        }
        self.1.pop().map(|(line, position)| (line + 4, position))
    }
}

/// Four lines side by side.
pub(super) trait Four: Copy {
    /// Removes the lowest bit, and returns the number of its line and its position in the line.
    fn pop(&mut self) -> Option<(usize, u32)>;
}

macro_rules! line {
    ($line:ty, $four:ty) => {
        impl Line for $line {
            const BITS: u32 = <$line>::BITS;
            const NONE: Self = 0;
            type Four = $four;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn from_low_bits(bits: u32) -> Self {
                bits as Self
            }

            #[inline(always)]
            fn to_bits(self) -> u32 {
                self.into()
            }

            #[inline(always)]
            fn trailing_ones(self) -> u32 {
                <$line>::trailing_ones(self)
            }

            #[inline(always)]
            fn shl(self, count: u32) -> Self {
                self << count
            }

            #[inline(always)]
            fn shr(self, count: u32) -> Self {
                self >> count
            }

            #[inline(always)]
            fn reversed(self) -> Self {
                self.reverse_bits()
            }

            #[inline(always)]
            fn cut(lines: [Self; 4], first: u32, count: u32) -> $four {
                const EACH: $four = <$four>::MAX / (<$line>::MAX as $four);
                let [a, b, c, d] = lines.map(<$four>::from);
                let bits = Self::BITS;
                let all = a | b << bits | c << (2 * bits) | d << (3 * bits);
                (all >> first) & (EACH * ((1 << count) - 1))
            }
        }

        impl Four for $four {
            #[inline(always)]
            fn pop(&mut self) -> Option<(usize, u32)> {
                if *self == 0 {
                    return None;
                }
                let bit = self.trailing_zeros();
                *self &= *self - 1;
                Some(((bit / <$line>::BITS) as usize, bit % <$line>::BITS))
            }
        }
    };
}

line!(u16, u64);
line!(u32, u128);

/// A set of cells, as `N` lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<L, const N: usize>(pub(super) [L; N]);

impl<L: Line, const N: usize> Rows<L, N> {
    pub(super) const NONE: Self = Self([L::NONE; N]);

    pub(super) fn from_rows(rows: &[u32; 32]) -> Self {
        Self(from_fn(|line| L::from_low_bits(rows[line])))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.iter().fold(L::NONE, |all, &line| all | line).to_bits() == 0
    }

    #[inline(always)]
    fn map(self, change: impl Fn(L) -> L) -> Self {
        Self(self.0.map(change))
    }

    /// Returns for each cell the bit of the cell `count` places further on in its line.
    #[inline(always)]
    pub(super) fn ahead(self, count: u32) -> Self {
        self.map(|line| line.shr(count))
    }

    /// Returns for each cell the bit of the cell before it in its line.
    #[inline(always)]
    pub(super) fn behind(self) -> Self {
        self.map(|line| line.shl(1))
    }

    /// Returns for each cell the bit of the cell in the next line.
    #[inline(always)]
    pub(super) fn above(self) -> Self {
        let mut lines = [L::NONE; N];
        lines[..N - 1].copy_from_slice(&self.0[1..]);
        Self(lines)
    }

    /// Returns for each cell the bit of the cell in the line before.
    #[inline(always)]
    pub(super) fn below(self) -> Self {
        let mut lines = [L::NONE; N];
        lines[1..].copy_from_slice(&self.0[..N - 1]);
        Self(lines)
    }

    /// Reverses the order of the cells in each line.
    #[inline(always)]
    pub(super) fn reversed(self) -> Self {
        self.map(L::reversed)
    }

    /// Exchanges rows and columns (Warren, Hacker's Delight, section 7-3).
    #[inline(always)]
    pub(super) fn transposed(mut self) -> Self {
        let mut width = L::BITS / 2;
        while width > 0 {
            let (mask, step) = (alternating::<L>(width), width as usize);
            for block in (0..N).step_by(2 * step) {
                for low in block..block + step {
                    let (a, b) = (self.0[low], self.0[low + step]);
                    self.0[low] = (a & mask) | (b & mask).shl(width);
                    self.0[low + step] = (a.shr(width) & mask) | (b & !mask);
                }
            }
            width /= 2;
        }
        self
    }
}

/// Returns a mask of alternating groups of `width` clear and set bits, the lowest ones set.
#[inline(always)]
fn alternating<L: Line>(width: u32) -> L {
    L::from_low_bits(match width {
        16 => 0x0000_FFFF,
        8 => 0x00FF_00FF,
        4 => 0x0F0F_0F0F,
        2 => 0x3333_3333,
        _ => 0x5555_5555,
    })
}

impl<L: Line, const N: usize> BitAnd for Rows<L, N> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(from_fn(|line| self.0[line] & other.0[line]))
    }
}

impl<L: Line, const N: usize> BitOr for Rows<L, N> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(from_fn(|line| self.0[line] | other.0[line]))
    }
}

impl<L: Line, const N: usize> Not for Rows<L, N> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        self.map(|line| !line)
    }
}
