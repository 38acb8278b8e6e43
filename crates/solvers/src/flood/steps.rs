//! The memory for the distances in a maze.

use mmsim_maze::{Cell, MazeSize};

/// The maximum side length of a maze in cells.
pub(crate) const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The maximum side length of a small maze in cells. In a small maze, a set of cells of one
/// chessboard colour fits into two 64-bit words, and a distance fits into a byte.
pub(crate) const SMALL_SIDE: usize = 16;

/// The number of cells of the largest small maze.
pub(crate) const SMALL_AREA: usize = SMALL_SIDE * SMALL_SIDE;

/// The number of cells for which [`Steps::Large`] has memory, which is 0 if all mazes are small.
pub(super) const LARGE_AREA: usize = if SIDE > SMALL_SIDE { MazeSize::MAX_AREA } else { 0 };

/// Returns true if neither side of the maze is longer than [`SMALL_SIDE`] cells.
pub(super) const fn is_small(size: MazeSize) -> bool {
    // The compiler removes the code for larger mazes if there are none.
    SIDE == SMALL_SIDE
        || size.width() as usize <= SMALL_SIDE && size.height() as usize <= SMALL_SIDE
}

/// The bytes of 16 adjacent cells in a row, from west to east.
pub(crate) type ByteRow = [u8; 16];

/// The internal value for the distance of a cell that cannot reach a target.
pub(crate) const UNREACHABLE: u16 = u16::MAX;

const UNREACHABLE_BYTE: u8 = u8::MAX;

/// The distances of all cells.
// The large variant is not boxed, because there may be no allocator.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Steps {
    /// The distances in a maze of up to 16×16 cells.
    Small(SmallSteps),
    /// The distances in a larger maze, stored as rows of 32 cells from south to north.
    Large([u16; LARGE_AREA]),
}

impl Steps {
    /// Returns the distances in a maze in which no cell can reach a target.
    pub(super) const fn unreachable(size: MazeSize) -> Self {
        if is_small(size) {
            let rows = [[[UNREACHABLE_BYTE; SMALL_SIDE]; 8]; SMALL_SIDE / 8];
            Self::Small(SmallSteps { rows, all_reached: false })
        } else {
            Self::Large([UNREACHABLE; LARGE_AREA])
        }
    }

    /// Returns the distance of the cell (`x`, `y`), which must be inside the maze, or
    /// [`UNREACHABLE`].
    #[inline]
    pub(super) fn at(&self, x: usize, y: usize) -> u16 {
        match self {
            Self::Small(steps) => steps.at(y * SMALL_SIDE + x),
            Self::Large(steps) => large_at(steps, y * SIDE + x),
        }
    }

    /// Returns the distances of a cell's neighbours, in the order of
    /// [`Heading::ALL`](mmsim_maze::Heading::ALL). The values for neighbours outside the maze are
    /// arbitrary.
    #[inline]
    pub(super) fn around(&self, cell: Cell) -> [u16; 4] {
        let (x, y) = (usize::from(cell.x), usize::from(cell.y));
        match self {
            Self::Small(steps) => {
                neighbours(y * SMALL_SIDE + x, SMALL_SIDE).map(|index| steps.at(index))
            }
            Self::Large(steps) => {
                neighbours(y * SIDE + x, SIDE).map(|index| large_at(steps, index))
            }
        }
    }
}

/// Returns the indices of the neighbours of the cell at `index`, where `row` is the number of cells
/// per row.
fn neighbours(index: usize, row: usize) -> [usize; 4] {
    [index + row, index + 1, index.wrapping_sub(row), index.wrapping_sub(1)]
}

#[inline(always)]
#[allow(clippy::trivially_copy_pass_by_ref)] // depends on the feature `half-size`
fn large_at(steps: &[u16; LARGE_AREA], index: usize) -> u16 {
    // In two checks, so that the compiler can remove the second one.
    steps.get(index % MazeSize::MAX_AREA).copied().unwrap_or(UNREACHABLE)
}

/// The distances in a maze of up to 16×16 cells, with one byte per cell.
#[derive(Clone, Debug)]
// The bytes are at the start of the memory, where the fewest instructions find them.
#[repr(C, align(4))]
pub(super) struct SmallSteps {
    /// The rows of 16 cells, from south to north.
    pub(super) rows: [[ByteRow; 8]; SMALL_SIDE / 8],
    /// True if the byte 255 is a distance; otherwise, it is `UNREACHABLE_BYTE`. A shortest path can
    /// only have a length of 255 steps if it visits all of 16×16 cells.
    pub(super) all_reached: bool,
}

impl SmallSteps {
    /// Returns the bytes of all cells. The result is never `None`.
    #[inline(always)]
    pub(super) fn bytes(&mut self) -> Option<&mut [u8; SMALL_AREA]> {
        self.rows.as_flattened_mut().as_flattened_mut().first_chunk_mut()
    }

    #[inline]
    fn at(&self, index: usize) -> u16 {
        let bytes = self.rows.as_flattened().as_flattened();
        let steps = bytes[index % bytes.len()];
        let is_reached = steps != UNREACHABLE_BYTE || self.all_reached;
        if is_reached { steps.into() } else { UNREACHABLE }
    }
}

impl PartialEq for SmallSteps {
    fn eq(&self, other: &Self) -> bool {
        // `all_reached` has a meaning only for the byte 255.
        (0..SMALL_AREA).all(|index| self.at(index) == other.at(index))
    }
}

impl Eq for SmallSteps {}
