//! A maze as a chessboard: where one can go from cells of one colour to those of the other.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

use super::half::{Bits, Half, row_bits};
use super::waves::{Flooded, Marks};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// Cells of both colours. (0, 0) is dark, as a1 is.
#[derive(Clone, Copy)]
pub(super) struct Chequered<B> {
    pub(super) dark: B,
    pub(super) light: B,
}

/// The ways into each cell of one colour, all of which come from cells of the other colour.
#[derive(Clone, Copy)]
pub(super) struct Ways<B> {
    /// From the cell with the same bit: the western and the eastern of each two columns.
    same: B,
    /// Where a step east leads to another bit.
    east: B,
    /// Where a step west does.
    west: B,
    north: B,
    south: B,
}

/// The ways of a maze.
#[derive(Clone, Copy)]
pub(super) struct Board<B> {
    pub(super) into_dark: Ways<B>,
    pub(super) into_light: Ways<B>,
}

impl<B: Bits> Ways<B> {
    /// Those of `cells`' neighbours that are among `wanted`.
    #[inline(always)]
    pub(super) fn from(&self, cells: B, wanted: B) -> B {
        let [along, across] = self.along_and_across(cells);
        along.or_and(across, wanted)
    }

    /// The wave after `wave`: its neighbours that were not in the wave `before` it. Waves of one
    /// colour need to know no more: each neighbour is a step nearer or a step further.
    #[inline(always)]
    pub(super) fn onward(&self, wave: B, before: B) -> B {
        let [along, across] = self.along_and_across(wave);
        along.or_without(across, before)
    }

    /// All neighbours of these cells, in two parts.
    #[inline(always)]
    fn along_and_across(&self, cells: B) -> [B; 2] {
        // Three operations one after another after the shifts, where a processor has these, with the
        // one that puts both together.
        let same = cells.and(self.same);
        let across = cells.down::<1>().and(self.west);
        let along = cells.up::<1>().and_or(self.east, same);
        let across = cells.north().and_or(self.north, across);
        [cells.south().and_or(self.south, along), across]
    }

    /// Those that are not among the others.
    #[inline(always)]
    pub(super) fn without(self, other: Self) -> Self {
        Self {
            same: self.same.without(other.same),
            east: self.east.without(other.east),
            west: self.west.without(other.west),
            north: self.north.without(other.north),
            south: self.south.without(other.south),
        }
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
        let [inner, between]: [H; 2] = split(&open::<N>(walls.east_rows(), columns >> 1, height));
        let north: Chequered<H> =
            chequered(split(&open::<N>(walls.north_rows(), columns, height - 1)));
        let even = H::of(even_rows());
        let (from_light, from_dark) = (between.and(even), between.without(even));
        Self {
            into_light: Ways {
                same: inner,
                west: from_light,
                east: from_dark.up::<1>(),
                north: north.dark.north(),
                south: north.light,
            },
            into_dark: Ways {
                same: inner,
                east: from_light.up::<1>(),
                west: from_dark,
                north: north.light.north(),
                south: north.dark,
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
        chequered(split(cells.rows()))
    }

    /// The half in which a cell is that cell alone, the other one is empty.
    #[inline(always)]
    pub(super) fn from_cell<const N: usize>(cell: Cell) -> Self
    where
        H: Half<N>,
    {
        let mut words = [0; N];
        if let Some((place, bit)) = place::<N>(cell) {
            // Not written to one of them, which could not be read as a whole at once.
            for (i, word) in words.iter_mut().enumerate() {
                *word = u64::from(i == place) << bit;
            }
        }
        let (half, none) = (H::of(words), H::NONE);
        if is_dark(cell) {
            Self { dark: half, light: none }
        } else {
            Self { dark: none, light: half }
        }
    }
}

/// Whether a cell is of the colour of (0, 0).
pub(super) const fn is_dark(cell: Cell) -> bool {
    (cell.x ^ cell.y) & 1 == 0
}

/// In which word of its half a cell is and at which bit; `None` if there is no room for it.
#[inline(always)]
pub(super) fn place<const N: usize>(cell: Cell) -> Option<(usize, usize)> {
    let bit = usize::from(cell.y) * row_bits(N) as usize + usize::from(cell.x / 2);
    let is_inside = u32::from(cell.x / 2) < row_bits(N);
    Some((bit / 64, bit % 64)).filter(|&(word, _)| is_inside && word < N)
}

impl<H> Chequered<H> {
    /// Those of a maze of this size.
    #[inline(always)]
    pub(super) fn inside<const N: usize>(self, size: MazeSize) -> Self
    where
        H: Half<N>,
    {
        let columns = u32::MAX >> (u32::BITS - u32::from(size.width()));
        let cells = open::<N>(&[0; SIDE], columns, size.height().into());
        let Self { dark, light } = chequered(split(&cells));
        Self { dark: self.dark.and(dark), light: self.light.and(light) }
    }

    /// The southernmost of its cells, and of those the westernmost; of a dark and a light one the
    /// dark one. `None` if there is none.
    #[inline(always)]
    pub(super) fn first_cell<const N: usize>(self) -> Option<Cell>
    where
        H: Half<N>,
    {
        let first = |half: H| {
            let words = half.words();
            let word = words.iter().position(|&word| word != 0)?;
            Some(64 * word + words[word].trailing_zeros() as usize)
        };
        let (bit, light) = match first(self.dark) {
            Some(bit) => (bit, 0),
            None => (first(self.light)?, 1),
        };
        let row = row_bits(N) as usize;
        let (y, half_x) = (bit / row, bit % row);
        // At most 31.
        #[allow(clippy::cast_possible_truncation)]
        Some(Cell::new((2 * half_x + ((y + light) & 1)) as u8, y as u8))
    }

    /// Even and odd columns.
    #[inline(always)]
    pub(super) fn columns<const N: usize>(self) -> [H; 2]
    where
        H: Half<N>,
    {
        // The same that makes them chequered.
        let Chequered { dark, light } = chequered([self.dark, self.light]);
        [dark, light]
    }
}

/// The rows with even numbers.
#[inline(always)]
pub(super) fn even_rows<const N: usize>() -> [u64; N] {
    [if N == 2 { 0x00ff_00ff_00ff_00ff } else { 0x0000_ffff_0000_ffff }; N]
}

/// Even and odd columns become dark and light cells.
#[inline(always)]
fn chequered<const N: usize, H: Half<N>>([even, odd]: [H; 2]) -> Chequered<H> {
    let swapped = even.xor(odd).without(H::of(even_rows()));
    Chequered { dark: even.xor(swapped), light: odd.xor(swapped) }
}

/// Something of the cells of both colours as that of even and odd columns.
#[inline(always)]
pub(super) fn columns<const N: usize, H: Half<N>>(
    flooded: &Flooded<H>,
    of: impl Fn(&Marks<H>) -> H,
) -> [H; 2] {
    let [even, odd] = [H::of(even_rows()), H::ALL.without(H::of(even_rows()))];
    let (near, far) = (of(&flooded.near), of(&flooded.far));
    let swapped = near.xor(far).and(if flooded.near_is_dark { odd } else { even });
    [near.xor(swapped), far.xor(swapped)]
}

/// Sides without a wall, of so many rows and of these columns only.
#[inline(always)]
fn open<const N: usize>(walls: &[u32; SIDE], columns: u32, height: usize) -> [u32; SIDE] {
    // All rows that there are, then none: where to begin to read decides how many there are.
    static ROWS: [u32; 2 * SIDE] = {
        let mut rows = [0; 2 * SIDE];
        rows.split_at_mut(SIDE).0.copy_from_slice(&[u32::MAX; SIDE]);
        rows
    };
    let rows = &ROWS[SIDE - height.min(SIDE)..][..SIDE];
    let mut open = [0; SIDE];
    for y in 0..row_count(N) {
        open[y] = !walls[y] & columns & rows[y];
    }
    open
}

/// How many rows a half has room for.
const fn row_count(words: usize) -> usize {
    if words == 2 { 16 } else { SIDE }
}

/// Rows of bits, bit x of row y, as their even and their odd columns.
#[inline(always)]
fn split<const N: usize, H: Half<N>>(rows: &[u32; SIDE]) -> [H; 2] {
    let mut halves = [[0; N]; 2];
    // Loops over rows, without a word for what a row does not need, become vector instructions.
    // `zip` is not always inlined.
    if N == 2 {
        let mut columns = [[0; 16]; 2];
        for y in 0..16 {
            let bits = unshuffle(rows[y]);
            columns[0][y] = (bits & 0xff) as u8;
            columns[1][y] = (bits >> 16 & 0xff) as u8;
        }
        for (i, columns) in columns.iter().enumerate() {
            for (word, rows) in columns.as_chunks::<8>().0.iter().enumerate() {
                halves[i][word] = u64::from_le_bytes(*rows);
            }
        }
    } else {
        let mut columns = [[0; SIDE]; 2];
        for y in 0..SIDE {
            let bits = unshuffle(rows[y]);
            columns[0][y] = (bits & 0xffff) as u16;
            columns[1][y] = (bits >> 16) as u16;
        }
        for (i, columns) in columns.iter().enumerate() {
            for (word, &[a, b, c, d]) in columns.as_chunks::<4>().0.iter().enumerate() {
                let [a, b, c, d] = [u64::from(a), u64::from(b), u64::from(c), u64::from(d)];
                halves[i][word] = a | b << 16 | c << 32 | d << 48;
            }
        }
    }
    let [even, odd] = halves;
    [H::of(even), H::of(odd)]
}

/// The way back: even and odd columns as rows of bits.
#[inline(always)]
pub(super) fn rows<const N: usize, H: Half<N>>([even, odd]: [H; 2]) -> [u32; SIDE] {
    let (even, odd) = (even.words(), odd.words());
    let mut rows = [0; SIDE];
    if N == 2 {
        let mut columns = [[0; 16]; 2];
        for (columns, half) in columns.iter_mut().zip([even, odd]) {
            for (rows, word) in columns.as_chunks_mut::<8>().0.iter_mut().zip(half) {
                *rows = word.to_le_bytes();
            }
        }
        for y in 0..16 {
            rows[y] = shuffle(u32::from(columns[0][y]) | u32::from(columns[1][y]) << 16);
        }
    } else {
        let mut columns = [[0; SIDE]; 2];
        for (columns, half) in columns.iter_mut().zip([even, odd]) {
            for (rows, word) in columns.as_chunks_mut::<4>().0.iter_mut().zip(half) {
                *rows = [word, word >> 16, word >> 32, word >> 48].map(|row| (row & 0xffff) as u16);
            }
        }
        for y in 0..SIDE {
            rows[y] = shuffle(u32::from(columns[0][y]) | u32::from(columns[1][y]) << 16);
        }
    }
    rows
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
const fn shuffle(bits: u32) -> u32 {
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
