//! A maze as a chessboard: where one can go from cells of one colour to those of the other.

use core::array::from_fn;

use mmsim_maze::{CellSet, Walls};

use super::half::Half;

const SIDE: usize = mmsim_maze::MazeSize::MAX_SIDE as usize;

/// Cells of both colours. (0, 0) is dark, as a1 is.
#[derive(Clone, Copy)]
pub(super) struct Chequered<H> {
    pub(super) dark: H,
    pub(super) light: H,
}

/// The ways into each cell of one colour, all of which come from cells of the other colour.
#[derive(Clone, Copy)]
pub(super) struct Ways<H> {
    /// From the cell with the same bit: the western and the eastern of each two columns.
    same: H,
    /// Where a step east leads to another bit.
    east: H,
    /// Where a step west does.
    west: H,
    north: H,
    south: H,
}

/// The ways of a maze.
#[derive(Clone, Copy)]
pub(super) struct Board<H> {
    pub(super) into_dark: Ways<H>,
    pub(super) into_light: Ways<H>,
}

impl<H> Ways<H> {
    /// Those of `cells`' neighbours that are among `wanted`.
    #[inline(always)]
    pub(super) fn from<const N: usize>(&self, cells: H, wanted: H) -> H
    where
        H: Half<N>,
    {
        // Three operations one after another after the shifts, where a processor has these.
        let same = cells.and(self.same);
        let across = cells.down::<1>().and(self.west);
        let along = cells.up::<1>().and_or(self.east, same);
        let across = cells.north().and_or(self.north, across);
        cells.south().and_or(self.south, along).or_and(across, wanted)
    }
}

impl<H> Board<H> {
    #[inline(always)]
    pub(super) fn of<const N: usize>(walls: &Walls) -> Self
    where
        H: Half<N>,
    {
        let (width, height) = (walls.size().width(), usize::from(walls.size().height()));
        let columns = u32::MAX >> (u32::BITS - u32::from(width));
        let open = |rows: &[u32; SIDE], columns: u32, height: usize| -> [u32; SIDE] {
            from_fn(|y| if y < height { !rows[y] & columns } else { 0 })
        };
        let [inner, between] = split(&open(walls.east_rows(), columns >> 1, height));
        let north = chequered(split::<N>(&open(walls.north_rows(), columns, height - 1)));
        let even = even_rows::<N>();
        let (from_light, from_dark) = (between.and(even), between.without(even));
        let of = H::of;
        Self {
            into_light: Ways {
                same: of(inner),
                west: of(from_light),
                east: of(from_dark.up::<1>()),
                north: of(north.dark.north()),
                south: of(north.light),
            },
            into_dark: Ways {
                same: of(inner),
                east: of(from_light.up::<1>()),
                west: of(from_dark),
                north: of(north.light.north()),
                south: of(north.dark),
            },
        }
    }
}

impl<H> Chequered<H> {
    #[inline(always)]
    pub(super) fn of<const N: usize>(cells: &CellSet) -> Self
    where
        H: Half<N>,
    {
        let Chequered { dark, light } = chequered(split::<N>(cells.rows()));
        Self { dark: H::of(dark), light: H::of(light) }
    }
}

/// The rows with even numbers.
#[inline(always)]
pub(super) fn even_rows<const N: usize>() -> [u64; N] {
    [if N == 2 { 0x00ff_00ff_00ff_00ff } else { 0x0000_ffff_0000_ffff }; N]
}

/// Even and odd columns become dark and light cells, and the other way round.
#[inline(always)]
pub(super) fn chequered<const N: usize, H: Half<N>>([even, odd]: [H; 2]) -> Chequered<H> {
    let swapped = even.xor(odd).without(H::of(even_rows()));
    Chequered { dark: even.xor(swapped), light: odd.xor(swapped) }
}

/// Rows of bits, bit x of row y, as their even and their odd columns.
#[inline(always)]
fn split<const N: usize>(rows: &[u32; SIDE]) -> [[u64; N]; 2] {
    // Two rows of 16 bits or one of 32.
    let pair = |i: usize| {
        let bits =
            if N == 2 { rows[2 * i] & 0xffff | rows[2 * i + 1] << 16 } else { rows[i] };
        unshuffle(bits)
    };
    let pairs: [u32; SIDE] = from_fn(|i| if i < 4 * N { pair(i) } else { 0 });
    let even = |i: usize| u64::from(pairs[i] & 0xffff);
    let odd = |i: usize| u64::from(pairs[i] >> 16);
    [
        from_fn(|i| even(4 * i) | even(4 * i + 1) << 16 | even(4 * i + 2) << 32 | even(4 * i + 3) << 48),
        from_fn(|i| odd(4 * i) | odd(4 * i + 1) << 16 | odd(4 * i + 2) << 32 | odd(4 * i + 3) << 48),
    ]
}

/// Even bits to the lower half, odd ones to the upper half.
///
/// After Warren, Hacker's Delight, 2nd edition, 7-2.
#[inline(always)]
const fn unshuffle(bits: u32) -> u32 {
    let bits = swap(bits, 0x2222_2222, 1);
    let bits = swap(bits, 0x0c0c_0c0c, 2);
    let bits = swap(bits, 0x00f0_00f0, 4);
    swap(bits, 0x0000_ff00, 8)
}

/// The way back from [`unshuffle`].
#[inline(always)]
pub(super) const fn shuffle(bits: u32) -> u32 {
    let bits = swap(bits, 0x0000_ff00, 8);
    let bits = swap(bits, 0x00f0_00f0, 4);
    let bits = swap(bits, 0x0c0c_0c0c, 2);
    swap(bits, 0x2222_2222, 1)
}

/// Swaps the bits of a mask with those `distance` above them.
#[inline(always)]
const fn swap(bits: u32, mask: u32, distance: u32) -> u32 {
    let differing = (bits ^ bits >> distance) & mask;
    bits ^ differing ^ differing << distance
}
