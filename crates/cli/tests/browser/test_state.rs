//! States of a client, encoded and decoded as docs/protocol.md specifies, independently of
//! `mmsim-protocol`.

use mmsim_maze::{Cell, MazeSize};

/// The bit in a cell's byte that marks the cell as visited.
pub(crate) const VISITED: u8 = 1;

/// For each heading: its letter, its offset in x and y, and the bit for the wall on that side.
pub(crate) const SIDES: [(char, i8, i8, u8); 4] =
    [('N', 0, 1, 16), ('E', 1, 0, 2), ('S', 0, -1, 4), ('W', -1, 0, 8)];

/// A state of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TestState {
    pub(crate) size: MazeSize,
    pub(crate) cell: Cell,
    pub(crate) heading: char,
    /// The weights of the cells. The weight of cell (x, y) is at index y · width + x, as in
    /// `walls`.
    pub(crate) weights: Vec<u8>,
    pub(crate) walls: Vec<u8>,
}

impl TestState {
    /// Returns a different state for each number. Weights and walls vary so much that each matrix
    /// differs from its transpose.
    pub(crate) fn new(number: usize, size: MazeSize) -> Self {
        let seed = u8::try_from(number * 37 % 251).unwrap();
        let mix = |cell: Cell, by: u8| {
            let mixed = cell.x.wrapping_mul(29).wrapping_add(cell.y.wrapping_mul(111));
            mixed.wrapping_add(seed).wrapping_mul(by).rotate_left(u32::from(cell.x) % 7)
        };
        let (width, height) = (usize::from(size.width()), usize::from(size.height()));
        let part = |of: usize| u8::try_from(of).unwrap();
        Self {
            size,
            cell: Cell::new(part(number % width), part(number / width % height)),
            heading: ['E', 'N', 'W', 'S'][number % 4],
            weights: size.cells().map(|cell| mix(cell, 1)).collect(),
            // There are few walls and no unused bits.
            walls: size.cells().map(|cell| mix(cell, 13) & mix(cell, 7) & 31).collect(),
        }
    }

    pub(crate) fn index(&self, cell: Cell) -> usize {
        self.size.index(cell).unwrap()
    }

    /// Returns true for outer walls, and for walls that the client reports in at least one of the
    /// two adjacent cells.
    pub(crate) fn has_wall(&self, cell: Cell, side: char) -> bool {
        let turn = SIDES.iter().position(|&(letter, ..)| letter == side).unwrap();
        let (_, dx, dy, bit) = SIDES[turn];
        let there = neighbour(self.size, cell, (dx, dy));
        let has_bit = |cell: Cell, bit: u8| self.walls[self.index(cell)] & bit != 0;
        has_bit(cell, bit) || there.is_none_or(|there| has_bit(there, SIDES[(turn + 2) % 4].3))
    }

    /// Encodes the state. `weights` and `walls` specify the order of each matrix: `C` (row by row
    /// from the south) or `F` (column by column from the west).
    pub(crate) fn message(&self, weights: char, walls: char) -> Vec<u8> {
        let mut message = vec![b'S', self.cell.x, self.cell.y, letter(self.heading)];
        for (order, matrix) in [(weights, &self.weights), (walls, &self.walls)] {
            message.push(letter(order));
            let start = message.len();
            message.resize(start + matrix.len(), 0);
            for cell in self.size.cells() {
                message[start + offset(order, self.size, cell)] = matrix[self.index(cell)];
            }
        }
        message
    }

    pub(crate) fn decode(message: &[u8], size: MazeSize) -> Self {
        let matrix = |sent: &[u8]| {
            let order = char::from(sent[0]);
            size.cells().map(|cell| sent[1 + offset(order, size, cell)]).collect()
        };
        Self {
            size,
            cell: Cell::new(message[1], message[2]),
            heading: char::from(message[3]),
            weights: matrix(&message[4..]),
            walls: matrix(&message[5 + size.area()..]),
        }
    }
}

fn letter(letter: char) -> u8 {
    u8::try_from(letter).unwrap()
}

/// Returns the index of a cell's byte in a matrix.
fn offset(order: char, size: MazeSize, cell: Cell) -> usize {
    let (x, y) = (usize::from(cell.x), usize::from(cell.y));
    match order {
        'C' => y * usize::from(size.width()) + x,
        'F' => x * usize::from(size.height()) + y,
        _ => panic!("{order}"),
    }
}

/// Returns the neighbouring cell, or `None` outside the maze.
pub(crate) fn neighbour(size: MazeSize, cell: Cell, (dx, dy): (i8, i8)) -> Option<Cell> {
    let there = Cell::new(cell.x.checked_add_signed(dx)?, cell.y.checked_add_signed(dy)?);
    size.contains(there).then_some(there)
}
