//! The matrices of a state, with one byte per cell.

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Sides, Unknown};

use crate::error::RequestError;

/// A matrix with one byte per cell of a maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix<'a> {
    pub(crate) order: Order,
    pub(crate) size: MazeSize,
    pub(crate) bytes: &'a [u8],
}

/// The order of the cells in a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Order {
    /// Row by row from the south: cell (x, y) has the index y × width + x.
    C = b'C',
    /// Column by column from the west: cell (x, y) has the index x × height + y.
    F = b'F',
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
        match self {
            Self::F if size.contains(cell) => {
                Some(cell.x as usize * size.height() as usize + cell.y as usize)
            }
            _ => size.index(cell),
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

    /// Returns the byte of `cell`, or `None` if the cell is outside the maze.
    pub fn at(&self, cell: Cell) -> Option<u8> {
        self.bytes.get(self.order.index(cell, self.size)?).copied()
    }
}

/// The flags of one cell in a state. One flag is set if the mouse has visited the cell. For each
/// side, another flag is set if the mouse believes that the side has a wall.
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
        Self(Self::from_sides(map.walls(Unknown::Open).sides(cell)).0 | visited)
    }

    /// Returns the flags of walls on these sides, without the flag of a visited cell.
    pub const fn from_sides(sides: Sides) -> Self {
        // Only the bit of north differs.
        Self(sides.bits() & 0b1110 | (sides.bits() & 1) << 4)
    }

    /// Returns true if the mouse has visited the cell.
    pub const fn visited(self) -> bool {
        self.0 & Self::VISITED != 0
    }

    /// Returns true if the mouse believes that this side of the cell has a wall.
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
    use mmsim_maze::WallState;

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
    fn cells_are_ordered_by_row_or_by_column() {
        let size = MazeSize::new(3, 2).unwrap();
        for (order, cells) in [
            (Order::C, [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]),
            (Order::F, [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]),
        ] {
            let bytes = [10, 11, 12, 13, 14, 15];
            let matrix = Matrix::new(order, size, &bytes).unwrap();
            for (index, (x, y)) in cells.into_iter().enumerate() {
                let cell = Cell::new(x, y);
                assert_eq!(order.index(cell, size), Some(index), "{cell} in {order:?}");
                assert_eq!(matrix.at(cell), Some(bytes[index]), "{cell} in {order:?}");
            }
            assert_eq!(matrix.at(Cell::new(3, 0)), None);
        }
    }

    #[test]
    fn orders_are_single_letters() {
        assert_eq!([Order::C as u8, Order::F as u8], *b"CF");
        for byte in 0..=u8::MAX {
            let expected = match byte {
                b'C' => Ok(Order::C),
                b'F' => Ok(Order::F),
                found => Err(RequestError::Order { matrix: "walls", found }),
            };
            assert_eq!(Order::decode(byte, "walls"), expected);
        }
    }

    #[test]
    fn a_matrix_has_one_byte_per_cell() {
        let size = MazeSize::new(2, 1).unwrap();
        assert!(Matrix::new(Order::C, size, &[1, 2]).is_some());
        assert!(Matrix::new(Order::C, size, &[1]).is_none());
        assert!(Matrix::new(Order::C, size, &[1, 2, 3]).is_none());
    }

    #[test]
    fn each_flag_is_one_bit() {
        use Heading::{East, North, South, West};
        for byte in 0..=u8::MAX {
            let flags = CellWalls(byte);
            let bits = [1, 2, 4, 8, 16].map(|bit| byte / bit % 2 == 1);
            let walls = [East, South, West, North].map(|heading| flags.wall(heading));
            assert_eq!((flags.visited(), walls), (bits[0], [bits[1], bits[2], bits[3], bits[4]]));
        }
    }

    #[test]
    fn the_flags_of_sides_are_those_of_their_walls() {
        for sides in (0..16).map(Sides::from_bits) {
            let flags = CellWalls::from_sides(sides);
            assert!(!flags.visited());
            for heading in Heading::ALL {
                assert_eq!(flags.wall(heading), sides.has(heading), "{sides:?} {heading}");
            }
        }
    }

    #[test]
    fn certain_walls_and_visited_cells_are_flagged() {
        let (size, cell) = (MazeSize::new(3, 3).unwrap(), Cell::new(1, 1));
        let mut map = KnownMaze::new(size, cell, size.central_cells());
        assert_eq!(CellWalls::known(&map, cell), CellWalls(0));
        for (heading, flag) in Heading::ALL.into_iter().zip([16, 2, 4, 8]) {
            let mut map = map.clone();
            map.set_wall(cell, heading, WallState::Present);
            assert_eq!(CellWalls::known(&map, cell), CellWalls(flag));
            map.set_wall(cell, heading, WallState::Absent);
            assert_eq!(CellWalls::known(&map, cell), CellWalls(0));
        }
        map.visit(cell);
        assert_eq!(CellWalls::known(&map, cell), CellWalls(1));
        assert_eq!(CellWalls::known(&map, Cell::new(0, 0)), CellWalls(4 | 8));
        assert_eq!(CellWalls::known(&map, Cell::new(2, 2)), CellWalls(2 | 16));
    }
}
