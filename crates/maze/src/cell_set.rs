//! A set of cells.

use core::fmt;

use crate::cell::{Cell, MazeSize};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// A set of cells of one maze, such as its goal cells or the visited ones: a bit a cell, 128
/// bytes, copied freely.
///
/// ```
/// use mmsim_maze::{Cell, CellSet};
/// let goals: CellSet = [Cell::new(7, 7), Cell::new(8, 7)].into_iter().collect();
/// assert!(goals.contains(Cell::new(8, 7)));
/// assert_eq!(goals.len(), 2);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CellSet {
    /// Bit x of row y.
    rows: [u32; SIDE],
}

impl CellSet {
    /// The set without a cell.
    pub const EMPTY: Self = Self { rows: [0; SIDE] };

    /// The set with these bits: bit x of row y.
    ///
    /// ```
    /// use mmsim_maze::{CellSet, MazeSize};
    /// let goals = MazeSize::CLASSIC.central_cells();
    /// assert_eq!(CellSet::from_rows(*goals.rows()), goals);
    /// ```
    pub const fn from_rows(rows: [u32; SIDE]) -> Self {
        Self { rows }
    }

    /// The set as bits: bit x of row y.
    pub const fn rows(&self) -> &[u32; SIDE] {
        &self.rows
    }

    /// Adds a cell. Says whether the set has grown: a cell that is in it already and one beyond
    /// 32×32 leave it as it was.
    pub fn insert(&mut self, cell: Cell) -> bool {
        let grows =
            cell.x < MazeSize::MAX_SIDE && cell.y < MazeSize::MAX_SIDE && !self.contains(cell);
        if grows {
            self.rows[usize::from(cell.y)] |= 1 << cell.x;
        }
        grows
    }

    /// Takes a cell out. Says whether it was in.
    pub fn remove(&mut self, cell: Cell) -> bool {
        let shrinks = self.contains(cell);
        if shrinks {
            self.rows[usize::from(cell.y)] &= !(1 << cell.x);
        }
        shrinks
    }

    /// Whether the cell is in the set.
    pub fn contains(&self, cell: Cell) -> bool {
        let row = self.rows.get(usize::from(cell.y)).copied().unwrap_or(0);
        row.checked_shr(u32::from(cell.x)).unwrap_or(0) & 1 == 1
    }

    /// How many cells are in it.
    pub fn len(&self) -> usize {
        self.rows.iter().map(|row| row.count_ones() as usize).sum()
    }

    /// Whether no cell is in it.
    pub fn is_empty(&self) -> bool {
        *self == Self::EMPTY
    }

    /// Its cells, row by row from the south, each row from the west.
    pub fn iter(&self) -> impl Iterator<Item = Cell> + '_ {
        (0_u8..).zip(&self.rows).flat_map(|(y, &row)| {
            let left = |row: u32| Some(row).filter(|&row| row != 0);
            let rest = core::iter::successors(left(row), move |&row| left(row & (row - 1)));
            // At most 31.
            #[allow(clippy::cast_possible_truncation)]
            rest.map(move |row| Cell { x: row.trailing_zeros() as u8, y })
        })
    }
}

impl FromIterator<Cell> for CellSet {
    fn from_iter<I: IntoIterator<Item = Cell>>(cells: I) -> Self {
        let mut set = Self::EMPTY;
        set.extend(cells);
        set
    }
}

impl Extend<Cell> for CellSet {
    fn extend<I: IntoIterator<Item = Cell>>(&mut self, cells: I) {
        for cell in cells {
            self.insert(cell);
        }
    }
}

impl fmt::Debug for CellSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn behaves_like_a_set_from_the_standard_library(
            cells in prop::collection::vec(any::<(u8, u8)>(), 0..200),
            removed in prop::collection::vec(any::<(u8, u8)>(), 0..200),
        ) {
            let of = |cells: Vec<(u8, u8)>| -> Vec<Cell> {
                cells.into_iter().map(|(x, y)| Cell::new(x % 40, y % 40)).collect()
            };
            let cells = of(cells);
            let mut set: CellSet = cells.iter().copied().collect();
            let mut twin: BTreeSet<(u8, u8)> =
                cells.iter().filter(|cell| cell.x < 32 && cell.y < 32).map(|cell| (cell.y, cell.x)).collect();
            for cell in of(removed) {
                prop_assert_eq!(set.remove(cell), twin.remove(&(cell.y, cell.x)));
            }
            prop_assert_eq!(set.len(), twin.len());
            prop_assert_eq!(set.is_empty(), twin.is_empty());
            prop_assert!(set.iter().map(|cell| (cell.y, cell.x)).eq(twin.iter().copied()));
            for x in 0..=255 {
                for y in 0..=255 {
                    prop_assert_eq!(set.contains(Cell::new(x, y)), twin.contains(&(y, x)));
                }
            }
        }
    }

    #[test]
    fn a_cell_is_added_once_and_never_beyond_32() {
        let mut set = CellSet::EMPTY;
        assert!(set.insert(Cell::new(31, 31)));
        assert!(!set.insert(Cell::new(31, 31)));
        assert!(!set.insert(Cell::new(32, 0)));
        assert!(!set.insert(Cell::new(0, 255)));
        assert_eq!(set.len(), 1);
    }
}
