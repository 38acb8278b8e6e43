//! The matrices of a state, with one byte per cell.

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Unknown};

use crate::error::RequestError;

/// A matrix with one byte per cell of a maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix<'a> {
    order: Order,
    size: MazeSize,
    bytes: &'a [u8],
}

/// The order of the cells in a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Row by row from the south: cell (x, y) has the index y × width + x.
    C,
    /// Column by column from the west: cell (x, y) has the index x × height + y.
    F,
}

impl Order {
    /// Returns the index of `cell` in a matrix of this size, or `None` if the cell is outside the
    /// maze.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, MazeSize, Order};
    /// let size = MazeSize::new(5, 3)?;
    /// assert_eq!(Order::C.index(Cell::new(2, 1), size), Some(7));
    /// assert_eq!(Order::F.index(Cell::new(2, 1), size), Some(7));
    /// assert_eq!(Order::C.index(Cell::new(4, 0), size), Some(4));
    /// assert_eq!(Order::F.index(Cell::new(4, 0), size), Some(12));
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub const fn index(self, cell: Cell, size: MazeSize) -> Option<usize> {
        let (x, y) = (cell.x as usize, cell.y as usize);
        match self {
            _ if !size.contains(cell) => None,
            Self::C => Some(y * size.width() as usize + x),
            Self::F => Some(x * size.height() as usize + y),
        }
    }

    pub(crate) const fn byte(self) -> u8 {
        match self {
            Self::C => b'C',
            Self::F => b'F',
        }
    }

    pub(crate) fn decode(byte: u8, matrix: &'static str) -> Result<Self, RequestError> {
        match byte {
            b'C' => Ok(Self::C),
            b'F' => Ok(Self::F),
            found => Err(RequestError::Order { matrix, found }),
        }
    }
}

impl<'a> Matrix<'a> {
    /// Creates a matrix. Returns `None` if the number of bytes differs from the number of cells.
    pub fn new(order: Order, size: MazeSize, bytes: &'a [u8]) -> Option<Self> {
        (bytes.len() == size.area()).then_some(Self { order, size, bytes })
    }

    /// Creates a matrix without checking the number of bytes.
    pub(crate) const fn from_bytes(order: Order, size: MazeSize, bytes: &'a [u8]) -> Self {
        Self { order, size, bytes }
    }

    /// Returns the size of the maze.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// Returns the order of the bytes.
    pub const fn order(&self) -> Order {
        self.order
    }

    /// Returns the bytes in the order of the matrix.
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Returns the byte of `cell`, or `None` if the cell is outside the maze.
    pub fn at(&self, cell: Cell) -> Option<u8> {
        self.bytes.get(self.order.index(cell, self.size)?).copied()
    }
}

/// The flags of one cell in a state: one for a visited cell, and one for each wall that the mouse
/// believes to be present.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct CellWalls(pub u8);

impl CellWalls {
    const VISITED: u8 = 1;

    /// Returns the flags of `cell` in this map. Unknown walls are encoded like absent walls.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, CellWalls, Heading, KnownMaze, MazeSize};
    /// let size = MazeSize::CLASSIC;
    /// let map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
    /// let corner = CellWalls::known(&map, Cell::new(0, 0));
    /// assert!(corner.wall(Heading::South) && corner.wall(Heading::West) && !corner.visited());
    /// assert_eq!(corner.0, 4 | 8);
    /// ```
    pub fn known(map: &KnownMaze, cell: Cell) -> Self {
        let visited = if map.visited().contains(cell) { Self::VISITED } else { 0 };
        let certain = map.walls(Unknown::Open);
        let present = |&heading: &Heading| certain.has(cell, heading);
        let walls = Heading::ALL.into_iter().filter(present).map(Self::flag);
        Self(walls.fold(visited, |byte, flag| byte | flag))
    }

    /// Returns true if the mouse has visited the cell.
    pub const fn visited(self) -> bool {
        self.0 & Self::VISITED != 0
    }

    /// Returns true if the mouse believes that there is a wall on this side of the cell.
    pub const fn wall(self, heading: Heading) -> bool {
        self.0 & Self::flag(heading) != 0
    }

    const fn flag(heading: Heading) -> u8 {
        match heading {
            Heading::East => 2,
            Heading::South => 4,
            Heading::West => 8,
            Heading::North => 16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_outside_the_maze_have_no_index() {
        let size = MazeSize::new(3, 2).unwrap();
        for order in [Order::C, Order::F] {
            for outside in [(3, 0), (0, 2), (3, 2), (2, 2), (3, 1), (255, 255)] {
                let cell = Cell::new(outside.0, outside.1);
                assert_eq!(order.index(cell, size), None, "{cell} in {order:?}");
            }
        }
    }

    #[test]
    fn a_matrix_has_one_byte_per_cell() {
        let size = MazeSize::new(2, 1).unwrap();
        assert!(Matrix::new(Order::C, size, &[1, 2]).is_some());
        assert!(Matrix::new(Order::C, size, &[1, 2, 3]).is_none());
    }
}
