//! Reads single fields from the bytes of a state.

use mmsim_maze::{Cell, Heading, MazeSize, Pose};

use crate::error::RequestError;
use crate::layout::{self, state_bytes};
use crate::matrix::{CellWalls, Matrix, Order};

/// A message `S` whose fields are decoded on demand.
///
/// Creating a `StateMessage` is cheaper than decoding a [`State`](crate::State), because it checks
/// only the letter and the length. Each method checks only the field that it reads.
///
/// ```
/// use mmsim_protocol::{Cell, Heading, MazeSize, StateMessage};
/// let message = StateMessage::new(b"S\x01\x00EC\x07\x09F\x0d\x1f", MazeSize::new(2, 1)?)?;
/// assert_eq!(message.pose()?.heading, Heading::East);
/// assert_eq!(message.weight(Cell::new(0, 0)), Some(7));
/// assert!(message.cell_walls(Cell::new(0, 0)).unwrap().wall(Heading::West));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMessage<'a> {
    size: MazeSize,
    bytes: &'a [u8],
}

impl<'a> StateMessage<'a> {
    /// Creates a view of a message to a simulator whose maze has this size.
    ///
    /// # Errors
    /// The message does not begin with `S`, or its length does not fit the size of the maze.
    pub const fn new(bytes: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        if bytes.len() == state_bytes(size) && bytes[layout::LETTER] == b'S' {
            Ok(Self { size, bytes })
        } else {
            Err(RequestError::StateLength { size, found: bytes.len() })
        }
    }

    /// Returns the whole message.
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Returns the size of the maze.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// Returns the pose of the mouse.
    ///
    /// # Errors
    /// The heading is invalid, or the cell is outside the maze.
    pub fn pose(&self) -> Result<Pose, RequestError> {
        let [x, y, heading] =
            [layout::X, layout::Y, layout::HEADING].map(|index| self.bytes[index]);
        decode_pose(x, y, heading, self.size)
    }

    /// Returns the weight of one cell, or `None` if the cell is outside the maze or the order of
    /// the weights is invalid.
    pub fn weight(&self, cell: Cell) -> Option<u8> {
        self.weights().ok()?.at(cell)
    }

    /// Returns the flags of one cell, or `None` if the cell is outside the maze or the order of the
    /// walls is invalid.
    pub fn cell_walls(&self, cell: Cell) -> Option<CellWalls> {
        self.walls().ok()?.at(cell).map(CellWalls)
    }

    /// Returns the matrix of weights.
    ///
    /// # Errors
    /// The order is invalid.
    pub fn weights(&self) -> Result<Matrix<'a>, RequestError> {
        let area = self.size.area();
        let order = Order::decode(self.bytes[layout::WEIGHTS_ORDER], "weights")?;
        Ok(Matrix::from_bytes(order, self.size, &self.bytes[layout::weights(area)]))
    }

    /// Returns the matrix of walls.
    ///
    /// # Errors
    /// The order is invalid.
    pub fn walls(&self) -> Result<Matrix<'a>, RequestError> {
        let area = self.size.area();
        let order = Order::decode(self.bytes[layout::walls_order(area)], "walls")?;
        Ok(Matrix::from_bytes(order, self.size, &self.bytes[layout::walls(area)]))
    }
}

pub(crate) const fn heading_byte(heading: Heading) -> u8 {
    heading.letter() as u8
}

/// Decodes the pose in a walls request or a state.
pub(crate) fn decode_pose(x: u8, y: u8, heading: u8, size: MazeSize) -> Result<Pose, RequestError> {
    let heading = Heading::ALL
        .into_iter()
        .find(|&candidate| heading_byte(candidate) == heading)
        .ok_or(RequestError::Heading { found: heading })?;
    let cell = Cell::new(x, y);
    if size.contains(cell) {
        Ok(Pose { cell, heading })
    } else {
        Err(RequestError::Outside { cell, size })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: [u8; 10] = *b"S\x01\x00EC\x07\x09F\x0d\x1f";

    fn small() -> MazeSize {
        MazeSize::new(2, 1).unwrap()
    }

    #[test]
    fn each_field_is_read_by_itself() {
        let message = StateMessage::new(&SMALL, small()).unwrap();
        let [west, east, outside] = [0, 1, 2].map(|x| Cell::new(x, 0));
        assert_eq!((message.size(), message.bytes()), (small(), &SMALL[..]));
        assert_eq!(message.pose(), Ok(Pose::new(east, Heading::East)));
        assert_eq!(
            [west, east, outside].map(|cell| message.weight(cell)),
            [Some(7), Some(9), None]
        );
        let walls = [west, east, outside].map(|cell| message.cell_walls(cell));
        assert_eq!(walls, [Some(CellWalls(0x0d)), Some(CellWalls(0x1f)), None]);
    }

    #[test]
    fn an_invalid_field_leaves_the_others_readable() {
        let with = |index: usize, byte| {
            let mut bytes = SMALL;
            bytes[index] = byte;
            bytes
        };
        let bytes = with(layout::HEADING, b'?');
        let message = StateMessage::new(&bytes, small()).unwrap();
        assert!(message.pose().is_err() && message.weights().is_ok() && message.walls().is_ok());
        let bytes = with(layout::WEIGHTS_ORDER, b'?');
        let message = StateMessage::new(&bytes, small()).unwrap();
        assert!(message.pose().is_ok() && message.weights().is_err() && message.walls().is_ok());
        assert_eq!(message.weight(Cell::new(0, 0)), None);
        assert!(StateMessage::new(&with(layout::LETTER, b'W'), small()).is_err());
        assert!(StateMessage::new(&SMALL[..9], small()).is_err());
    }
}
