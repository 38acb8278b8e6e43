//! Bitboards, which store the openings (sides without a wall) of a maze. The cells are coloured
//! like a chessboard, so each opening joins a dark cell and a light cell.

use mmsim_maze::{Cell, CellSet, MazeSize, Row, Walls};

use super::plane::{BitOps, ParityPlane, Words};
use crate::flood::steps::SIDE;

/// One value for the dark cells of a maze and one for its light cells. The cells are coloured like
/// a chessboard, and the cell (0, 0) is dark, like the square a1.
#[derive(Clone, Copy)]
pub(crate) struct ByColour<T> {
    pub(crate) dark: T,
    pub(crate) light: T,
}

/// A set of cells, stored as one bit set for each chessboard colour.
pub(crate) type CellPlanes<H> = ByColour<H>;

/// The openings (sides without a wall) of a maze, grouped by the chessboard colour of the cell that
/// they lead into.
pub(crate) type Bitboard<H> = ByColour<Openings<H>>;

/// The open sides through which the cells of one chessboard colour can be entered.
#[derive(Clone, Copy)]
pub(crate) struct Openings<B> {
    /// The cells that can be entered from the cell of the opposite colour at the same bit position.
    /// The cells (2k, y) and (2k + 1, y) share a bit position.
    same: B,
    /// The cells in even columns that can be entered by a step east.
    east: B,
    /// The cells in odd columns that can be entered by a step west.
    west: B,
    /// The cells that can be entered by a step north.
    north: B,
    /// The cells that can be entered by a step south.
    south: B,
}

impl<B: BitOps> Openings<B> {
    /// Returns the cells of `wanted` that can be entered from `cells`.
    #[inline(always)]
    pub(crate) fn from(&self, cells: B, wanted: B) -> B {
        let [along, across] = self.along_and_across(cells);
        along.or_and(across, wanted)
    }

    /// Returns the wave that follows `wave`: the cells that can be entered from `wave` and are not
    /// in the preceding wave, `before`. If all cells of a wave have the same chessboard colour,
    /// every open neighbour of the wave belongs to the preceding or to the following wave, so
    /// earlier waves need not be excluded.
    #[inline(always)]
    pub(crate) fn onward(&self, wave: B, before: B) -> B {
        let [along, across] = self.along_and_across(wave);
        along.or_without(across, before)
    }

    /// Returns two sets whose union is the set of cells that can be entered from `cells`.
    #[inline(always)]
    fn along_and_across(&self, cells: B) -> [B; 2] {
        // With three-operand logic, only three operations after the shifts depend on each other.
        // The union of the two sets is one of these operations.
        let same = cells.and(self.same);
        let across = cells.down::<1>().and(self.west);
        let along = cells.up::<1>().and_or(self.east, same);
        let across = cells.north().and_or(self.north, across);
        [cells.south().and_or(self.south, along), across]
    }

    /// Returns the openings that are not in `other`.
    #[inline(always)]
    pub(crate) fn without(self, other: Self) -> Self {
        Self {
            same: self.same.without(other.same),
            east: self.east.without(other.east),
            west: self.west.without(other.west),
            north: self.north.without(other.north),
            south: self.south.without(other.south),
        }
    }
}

impl<H: ParityPlane> Bitboard<H> {
    #[inline(always)]
    pub(crate) fn from_walls(walls: &Walls) -> Self {
        let [inner, between]: [H; 2] = split(&open::<H>(walls.east_rows()));
        let north: CellPlanes<H> = by_colour(split(&open::<H>(walls.north_rows())));
        let even: H = even_rows();
        let (from_light, from_dark) = (between.and(even), between.without(even));
        Self {
            light: Openings {
                same: inner,
                west: from_light,
                east: from_dark.up::<1>(),
                north: north.dark.north(),
                south: north.light,
            },
            dark: Openings {
                same: inner,
                east: from_light.up::<1>(),
                west: from_dark,
                north: north.light.north(),
                south: north.dark,
            },
        }
    }
}

impl<T> ByColour<T> {
    /// Returns the values for the dark and the light cells, in that order if `near_is_dark` is
    /// true, and in the opposite order otherwise.
    #[inline(always)]
    pub(crate) fn near_and_far(self, near_is_dark: bool) -> [T; 2] {
        let Self { dark, light } = self;
        if near_is_dark { [dark, light] } else { [light, dark] }
    }

    /// Inverse of [`near_and_far`](Self::near_and_far).
    #[inline(always)]
    pub(crate) fn from_near_and_far([near, far]: [T; 2], near_is_dark: bool) -> Self {
        let (dark, light) = if near_is_dark { (near, far) } else { (far, near) };
        Self { dark, light }
    }
}

impl<H: ParityPlane> CellPlanes<H> {
    #[inline(always)]
    pub(crate) fn from_cells(cells: &CellSet) -> Self {
        by_colour(split(cells.rows()))
    }

    /// Creates a set of the given cells that are inside a maze of the given size.
    #[inline(always)]
    pub(crate) fn from_cells_inside(cells: &CellSet, size: MazeSize) -> Self {
        let columns = Row::MAX >> (Row::BITS - u32::from(size.width()));
        let mut rows = *cells.rows();
        for (y, row) in rows.iter_mut().enumerate().take(H::ROWS) {
            *row &= if y < size.height().into() { columns } else { 0 };
        }
        by_colour(split(&rows))
    }

    /// Creates a set of one cell.
    #[inline(always)]
    pub(crate) fn from_cell(cell: Cell) -> Self {
        let mut words = H::Words::repeat(0);
        let bit = usize::from(cell.y) * H::ROW_BITS + usize::from(cell.x / 2);
        if usize::from(cell.x / 2) < H::ROW_BITS {
            // Each word is written completely, so that the plane can be loaded as a whole.
            for (i, word) in words.as_mut().iter_mut().enumerate() {
                *word = u64::from(i == bit / 64) << (bit % 64);
            }
        }
        let (plane, none) = (H::from_words(words), H::NONE);
        if is_dark(cell) {
            Self { dark: plane, light: none }
        } else {
            Self { dark: none, light: plane }
        }
    }

    /// Returns the first cell of the set, or `None` if the set is empty. The dark cells of the
    /// chessboard pattern come before the light cells. Cells of the same colour are ordered from
    /// south to north, and in each row from west to east.
    #[inline(always)]
    pub(crate) fn first_cell(self) -> Option<Cell> {
        let first = |plane: H| {
            let words = plane.to_words();
            let words = words.as_ref();
            let word = words.iter().position(|&word| word != 0)?;
            Some(64 * word + words[word].trailing_zeros() as usize)
        };
        let (bit, light) = match first(self.dark) {
            Some(bit) => (bit, 0),
            None => (first(self.light)?, 1),
        };
        let (y, half_x) = (bit / H::ROW_BITS, bit % H::ROW_BITS);
        // At most 31.
        #[allow(clippy::cast_possible_truncation)]
        Some(Cell::new((2 * half_x + ((y + light) & 1)) as u8, y as u8))
    }

    /// Returns the cells in even columns and the cells in odd columns.
    #[inline(always)]
    pub(crate) fn columns(self) -> [H; 2] {
        // `by_colour` is its own inverse: it swaps the two planes in odd rows.
        let CellPlanes { dark, light } = by_colour([self.dark, self.light]);
        [dark, light]
    }
}

/// Returns true if the cell is dark, in a chessboard pattern in which (0, 0) is dark.
pub(crate) const fn is_dark(cell: Cell) -> bool {
    (cell.x ^ cell.y) & 1 == 0
}

/// Returns a bit set in which exactly the bits of the even rows are set.
#[inline(always)]
pub(crate) fn even_rows<H: ParityPlane>() -> H {
    let word = if H::IS_SMALL { 0x00ff_00ff_00ff_00ff } else { 0x0000_ffff_0000_ffff };
    H::from_words(H::Words::repeat(word))
}

/// Regroups the cells in even and odd columns by their chessboard colour.
#[inline(always)]
fn by_colour<H: ParityPlane>([even, odd]: [H; 2]) -> CellPlanes<H> {
    let swapped = even.xor(odd).without(even_rows());
    CellPlanes { dark: even.xor(swapped), light: odd.xor(swapped) }
}

/// Inverts rows of walls, so that each set bit stands for a side without a wall.
#[inline(always)]
fn open<H: ParityPlane>(walls: &[Row; SIDE]) -> [Row; SIDE] {
    let mut open = [0; SIDE];
    for y in 0..H::ROWS {
        open[y] = !walls[y];
    }
    open
}

/// Splits a set of cells into the cells in even columns and the cells in odd columns. Bit x of
/// `rows[y]` stands for the cell (x, y).
#[inline(always)]
#[allow(clippy::useless_conversion)] // depends on the feature `half-size`
fn split<H: ParityPlane>(rows: &[Row; SIDE]) -> [H; 2] {
    let mut planes = [H::Words::repeat(0); 2];
    // The compiler turns these loops over rows into vector instructions. `zip` is not always
    // inlined.
    if H::IS_SMALL {
        let mut columns = [[[0; 8]; 2]; 2];
        let [even, odd] = &mut columns;
        let (even, odd) = (even.as_flattened_mut(), odd.as_flattened_mut());
        for y in 0..16 {
            let bits = unshuffle(rows[y].into());
            even[y] = (bits & 0xff) as u8;
            odd[y] = (bits >> 16 & 0xff) as u8;
        }
        for (i, columns) in columns.iter().enumerate() {
            for (word, rows) in columns.iter().enumerate() {
                planes[i].as_mut()[word] = u64::from_le_bytes(*rows);
            }
        }
    } else {
        let mut columns = [[[0; 4]; SIDE / 4]; 2];
        let [even, odd] = &mut columns;
        let (even, odd) = (even.as_flattened_mut(), odd.as_flattened_mut());
        for y in 0..SIDE {
            let bits = unshuffle(rows[y].into());
            even[y] = (bits & 0xffff) as u16;
            odd[y] = (bits >> 16) as u16;
        }
        for (i, columns) in columns.iter().enumerate() {
            for (word, &[a, b, c, d]) in columns.iter().enumerate() {
                let [a, b, c, d] = [u64::from(a), u64::from(b), u64::from(c), u64::from(d)];
                planes[i].as_mut()[word] = a | b << 16 | c << 32 | d << 48;
            }
        }
    }
    let [even, odd] = planes;
    [H::from_words(even), H::from_words(odd)]
}

/// Interleaves the cells in even columns with the cells in odd columns, and returns them as rows of
/// bits. Inverse of [`split`].
#[inline(always)]
// Depends on the feature `half-size`.
#[allow(clippy::cast_possible_truncation, clippy::unnecessary_cast)]
pub(crate) fn rows<H: ParityPlane>([even, odd]: [H; 2]) -> [Row; SIDE] {
    let (even, odd) = (even.to_words(), odd.to_words());
    let mut rows = [0; SIDE];
    if H::IS_SMALL {
        let mut columns = [[[0; 8]; 2]; 2];
        for (columns, plane) in columns.iter_mut().zip([even, odd]) {
            for (rows, word) in columns.iter_mut().zip(plane.as_ref()) {
                *rows = word.to_le_bytes();
            }
        }
        let [even, odd] = &columns;
        let (even, odd) = (even.as_flattened(), odd.as_flattened());
        for y in 0..16 {
            rows[y] = shuffle(u32::from(even[y]) | u32::from(odd[y]) << 16) as Row;
        }
    } else {
        let mut columns = [[[0; 4]; SIDE / 4]; 2];
        for (columns, plane) in columns.iter_mut().zip([even, odd]) {
            for (rows, &word) in columns.iter_mut().zip(plane.as_ref()) {
                *rows = [word, word >> 16, word >> 32, word >> 48].map(|row| (row & 0xffff) as u16);
            }
        }
        let [even, odd] = &columns;
        let (even, odd) = (even.as_flattened(), odd.as_flattened());
        for y in 0..SIDE {
            rows[y] = shuffle(u32::from(even[y]) | u32::from(odd[y]) << 16) as Row;
        }
    }
    rows
}

/// Moves the even bits to the lower half of the word and the odd bits to the upper half.
///
/// The algorithm is from section 7-2 of Warren, Hacker's Delight, 2nd edition.
#[inline(always)]
const fn unshuffle(bits: u32) -> u32 {
    let bits = swap(bits, 0x2222_2222, 1);
    let bits = swap(bits, 0x0c0c_0c0c, 2);
    let bits = swap(bits, 0x00f0_00f0, 4);
    swap(bits, 0x0000_ff00, 8)
}

/// Inverse of [`unshuffle`].
#[inline(always)]
const fn shuffle(bits: u32) -> u32 {
    let bits = swap(bits, 0x0000_ff00, 8);
    let bits = swap(bits, 0x00f0_00f0, 4);
    let bits = swap(bits, 0x0c0c_0c0c, 2);
    swap(bits, 0x2222_2222, 1)
}

/// Swaps the bits selected by `mask` with the bits that are `distance` positions higher.
#[inline(always)]
const fn swap(bits: u32, mask: u32, distance: u32) -> u32 {
    let differing = (bits ^ bits >> distance) & mask;
    bits ^ differing ^ differing << distance
}
