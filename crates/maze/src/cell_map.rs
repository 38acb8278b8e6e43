//! Values for cells.

use core::ops::{Index, IndexMut};

use crate::cell::{Cell, MazeSize};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

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
    use super::*;

    #[test]
    fn each_cell_has_its_own_value() {
        let mut map = CellMap::new(None);
        for cell in MazeSize::LARGEST.cells() {
            assert_eq!(map[cell].replace(cell), None);
        }
        assert!(MazeSize::LARGEST.cells().all(|cell| map[cell] == Some(cell)));
    }
}
