//! Sets of cells, and values for cells.

use core::array::from_fn;
use core::fmt;
use core::ops::{BitAnd, BitOr, Index, IndexMut, Sub};

use crate::cell::{Cell, MazeSize};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// A row of cells or walls, with bit x for column x: 32 bits with the feature `half-size`, otherwise
/// 16 bits.
#[cfg(feature = "half-size")]
pub type Row = u32;
/// A row of cells or walls, with bit x for column x: 32 bits with the feature `half-size`, otherwise
/// 16 bits.
#[cfg(not(feature = "half-size"))]
pub type Row = u16;

/// A set of cells in a maze, such as the goal cells or the visited cells. The set stores one bit for
/// each cell, in 128 bytes with the feature `half-size`, otherwise in 32 bytes.
///
/// ```
/// use mmsim_maze::{Cell, CellSet};
/// let goals: CellSet = [Cell::new(7, 7), Cell::new(8, 7)].into_iter().collect();
/// assert!(goals.contains(Cell::new(8, 7)));
/// assert_eq!(goals.len(), 2);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct CellSet {
    /// Bit x of `rows[y]` stands for the cell (x, y).
    rows: [Row; SIDE],
}

impl CellSet {
    /// The empty set.
    pub const EMPTY: Self = Self { rows: [0; SIDE] };

    /// Creates a set from bits: bit x of `rows[y]` stands for the cell (x, y).
    ///
    /// ```
    /// use mmsim_maze::{CellSet, MazeSize};
    /// let goals = MazeSize::CLASSIC.central_cells();
    /// assert_eq!(CellSet::from_rows(*goals.rows()), goals);
    /// ```
    pub const fn from_rows(rows: [Row; SIDE]) -> Self {
        Self { rows }
    }

    /// Returns the set as bits: bit x of element y stands for the cell (x, y).
    pub const fn rows(&self) -> &[Row; SIDE] {
        &self.rows
    }

    /// Adds `cell` to the set, and returns true if the set did not contain it before. A cell
    /// outside the [largest](MazeSize::LARGEST) possible maze is not added, and the method returns
    /// false.
    pub fn insert(&mut self, cell: Cell) -> bool {
        let grows =
            cell.x < MazeSize::MAX_SIDE && cell.y < MazeSize::MAX_SIDE && !self.contains(cell);
        if grows {
            self.rows[usize::from(cell.y)] |= 1 << cell.x;
        }
        grows
    }

    /// Removes `cell` from the set, and returns true if the set contained it.
    pub fn remove(&mut self, cell: Cell) -> bool {
        let shrinks = self.contains(cell);
        if shrinks {
            self.rows[usize::from(cell.y)] &= !(1 << cell.x);
        }
        shrinks
    }

    /// Returns true if the set contains `cell`.
    pub fn contains(&self, cell: Cell) -> bool {
        let row = self.rows.get(usize::from(cell.y)).copied().unwrap_or(0);
        row.checked_shr(u32::from(cell.x)).unwrap_or(0) & 1 == 1
    }

    /// Returns the number of cells in the set.
    pub fn len(&self) -> usize {
        self.rows.iter().map(|row| row.count_ones() as usize).sum()
    }

    /// Returns true if the set is empty.
    pub fn is_empty(&self) -> bool {
        *self == Self::EMPTY
    }

    /// Returns an iterator over the cells, row by row from south to north, each row from west to
    /// east.
    pub const fn iter(&self) -> CellSetIter<'_> {
        CellSetIter { rows: &self.rows, y: 0, row: self.rows[0] }
    }
}

/// An iterator over the cells of a [`CellSet`].
#[derive(Clone, Debug)]
#[must_use]
pub struct CellSetIter<'a> {
    rows: &'a [Row; SIDE],
    y: u8,
    /// The cells of row `y` that the iterator has not returned yet.
    row: Row,
}

impl Iterator for CellSetIter<'_> {
    type Item = Cell;

    #[allow(clippy::cast_possible_truncation)]
    fn next(&mut self) -> Option<Cell> {
        while self.row == 0 {
            self.row = *self.rows.get(usize::from(self.y) + 1)?;
            self.y += 1;
        }
        // The result is at most 31.
        let x = self.row.trailing_zeros() as u8;
        self.row &= self.row - 1;
        Some(Cell { x, y: self.y })
    }
}

impl<'a> IntoIterator for &'a CellSet {
    type Item = Cell;
    type IntoIter = CellSetIter<'a>;

    fn into_iter(self) -> CellSetIter<'a> {
        self.iter()
    }
}

/// Returns the union of two sets.
impl BitOr for CellSet {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self::from_rows(from_fn(|y| self.rows[y] | other.rows[y]))
    }
}

/// Returns the intersection of two sets.
impl BitAnd for CellSet {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self::from_rows(from_fn(|y| self.rows[y] & other.rows[y]))
    }
}

/// Returns the cells of the first set that are not in the second set.
impl Sub for CellSet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::from_rows(from_fn(|y| self.rows[y] & !other.rows[y]))
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

/// A value for each cell of the largest maze, stored without allocation.
///
/// Indexing panics if the cell is outside the largest maze.
///
/// ```
/// use mmsim_maze::{Cell, CellMap};
/// let mut visits = CellMap::new(0);
/// visits[Cell::new(7, 8)] += 1;
/// assert_eq!((visits[Cell::new(7, 8)], visits[Cell::new(8, 7)]), (1, 0));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CellMap<T>([[T; SIDE]; SIDE]);

impl<T: Copy> CellMap<T> {
    /// Creates a map that has the same value for each cell.
    pub const fn new(value: T) -> Self {
        Self([[value; SIDE]; SIDE])
    }
}

impl<T> Index<Cell> for CellMap<T> {
    type Output = T;

    fn index(&self, cell: Cell) -> &T {
        &self.0[usize::from(cell.y)][usize::from(cell.x)]
    }
}

impl<T> IndexMut<Cell> for CellMap<T> {
    fn index_mut(&mut self, cell: Cell) -> &mut T {
        &mut self.0[usize::from(cell.y)][usize::from(cell.x)]
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
            let to_cells = |cells: Vec<(u8, u8)>| -> Vec<Cell> {
                cells.into_iter().map(|(x, y)| Cell::new(x % 40, y % 40)).collect()
            };
            let cells = to_cells(cells);
            let mut set: CellSet = cells.iter().copied().collect();
            let mut twin: BTreeSet<(u8, u8)> =
                cells.iter().filter(|cell| cell.x < 32 && cell.y < 32).map(|cell| (cell.y, cell.x)).collect();
            let other: CellSet = to_cells(removed.clone()).into_iter().collect();
            for cell in set.iter().chain(&other) {
                prop_assert_eq!((set | other).contains(cell), set.contains(cell) || other.contains(cell));
                prop_assert_eq!((set & other).contains(cell), set.contains(cell) && other.contains(cell));
                prop_assert_eq!((set - other).contains(cell), set.contains(cell) && !other.contains(cell));
            }
            prop_assert_eq!((set | other).len() + (set & other).len(), set.len() + other.len());
            for cell in to_cells(removed) {
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
    fn only_new_cells_within_32x32_are_inserted() {
        let mut set = CellSet::EMPTY;
        assert!(set.insert(Cell::new(31, 31)));
        assert!(!set.insert(Cell::new(31, 31)));
        assert!(!set.insert(Cell::new(32, 0)));
        assert!(!set.insert(Cell::new(0, 255)));
        assert_eq!(set.len(), 1);
    }

    #[test]
    fn operators_combine_sets() {
        let set = |columns: &[u8]| columns.iter().map(|&x| Cell::new(x, 3)).collect::<CellSet>();
        let (first, second) = (set(&[1, 2]), set(&[2, 3]));
        assert_eq!(first | second, set(&[1, 2, 3]));
        assert_eq!(first & second, set(&[2]));
        assert_eq!(first - second, set(&[1]));
        assert_eq!(CellSet::default(), CellSet::EMPTY);
        assert!(CellSet::EMPTY.is_empty() && !first.is_empty());
    }

    #[test]
    fn cells_are_bits_of_rows() {
        let mut rows = [0; SIDE];
        (rows[2], rows[31]) = (0b1010, 1 << 31);
        let set = CellSet::from_rows(rows);
        assert_eq!(set.rows(), &rows);
        let cells = [(1, 2), (3, 2), (31, 31)].map(|(x, y)| Cell::new(x, y));
        assert!(set.iter().eq(cells));
        assert!((&set).into_iter().eq(cells));
        let mut extended = CellSet::EMPTY;
        extended.extend(cells);
        assert_eq!(extended, set);
        assert!(extended.remove(cells[1]) && !extended.remove(cells[1]));
        let text = "{Cell { x: 1, y: 2 }, Cell { x: 31, y: 31 }}";
        assert_eq!(format!("{extended:?}"), text);
    }

    #[test]
    fn each_cell_has_its_own_value() {
        let mut map = CellMap::new(None);
        for cell in MazeSize::LARGEST.cells() {
            assert_eq!(map[cell].replace(cell), None);
        }
        assert!(MazeSize::LARGEST.cells().all(|cell| map[cell] == Some(cell)));
    }
}
