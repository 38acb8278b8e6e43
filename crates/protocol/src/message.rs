//! Decodes the fields of a state on demand.

use mmsim_maze::{Cell, Heading, MazeSize, Pose};

use crate::error::RequestError;
use crate::layout::{self, state_bytes};
use crate::matrix::{Matrix, Order};

/// A state message (`S`) whose fields are decoded on demand.
///
/// Creating a `StateMessage` is cheaper than decoding a [`State`](crate::State), because only the
/// letter and the length are checked. Each method checks only the field that it reads.
///
/// ```
/// use mmsim_protocol::{Cell, Heading, MazeSize, StateMessage};
/// let message = StateMessage::new(b"S\x01\x00EC\x07\x09F\x0d\x1f", MazeSize::new(2, 1)?)?;
/// assert_eq!(message.pose()?.heading, Heading::East);
/// assert_eq!(message.weights()?.at(Cell::new(0, 0)), Some(7));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMessage<'a> {
    size: MazeSize,
    bytes: &'a [u8],
}

impl<'a> StateMessage<'a> {
    /// Creates a view of a state message for a maze of this size.
    ///
    /// # Errors
    /// Returns an error if the message does not begin with `S` or has the wrong length for a maze
    /// of this size.
    pub const fn new(bytes: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        if bytes.len() == state_bytes(size) && bytes[layout::LETTER] == b'S' {
            Ok(Self { size, bytes })
        } else {
            Err(RequestError::StateLength { size, found: bytes.len() })
        }
    }

    /// Returns the pose of the mouse.
    ///
    /// # Errors
    /// Returns an error if the heading is invalid or the cell is outside the maze.
    pub fn pose(&self) -> Result<Pose, RequestError> {
        let [x, y, heading] =
            [layout::X, layout::Y, layout::HEADING].map(|index| self.bytes[index]);
        decode_pose(x, y, heading, self.size)
    }

    /// Returns the matrix of weights.
    ///
    /// # Errors
    /// Returns an error if the order is invalid.
    pub fn weights(&self) -> Result<Matrix<'a>, RequestError> {
        let area = self.size.area();
        let order = Order::decode(self.bytes[layout::WEIGHTS_ORDER], "weights")?;
        Ok(Matrix { order, size: self.size, bytes: &self.bytes[layout::weights(area)] })
    }

    /// Returns the matrix of walls.
    ///
    /// # Errors
    /// Returns an error if the order is invalid.
    pub fn walls(&self) -> Result<Matrix<'a>, RequestError> {
        let area = self.size.area();
        let order = Order::decode(self.bytes[layout::walls_order(area)], "walls")?;
        Ok(Matrix { order, size: self.size, bytes: &self.bytes[layout::walls(area)] })
    }
}

pub(crate) const fn heading_byte(heading: Heading) -> u8 {
    heading.letter() as u8
}

/// Decodes the pose in a walls request or a state.
pub(crate) fn decode_pose(x: u8, y: u8, letter: u8, size: MazeSize) -> Result<Pose, RequestError> {
    let heading = Heading::from_letter(letter.into());
    let heading = heading.ok_or(RequestError::Heading { found: letter })?;
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
        assert_eq!(message.pose(), Ok(Pose::new(Cell::new(1, 0), Heading::East)));
        let matrix = |order, bytes| Matrix::new(order, small(), bytes).unwrap();
        assert_eq!(message.weights(), Ok(matrix(Order::C, &[7, 9])));
        assert_eq!(message.walls(), Ok(matrix(Order::F, &[0x0d, 0x1f])));
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
        assert_eq!(message.pose(), Err(RequestError::Heading { found: b'?' }));
        assert!(message.weights().is_ok() && message.walls().is_ok());
        let bytes = with(layout::WEIGHTS_ORDER, b'?');
        let message = StateMessage::new(&bytes, small()).unwrap();
        let error = RequestError::Order { matrix: "weights", found: b'?' };
        assert_eq!(message.weights(), Err(error));
        assert!(message.pose().is_ok() && message.walls().is_ok());
        let bytes = with(layout::walls_order(2), b'?');
        let message = StateMessage::new(&bytes, small()).unwrap();
        let error = RequestError::Order { matrix: "walls", found: b'?' };
        assert_eq!(message.walls(), Err(error));
        assert!(message.pose().is_ok() && message.weights().is_ok());
    }

    #[test]
    fn a_message_has_the_letter_and_the_length_of_a_state() {
        let size = small();
        let error = |found| Err(RequestError::StateLength { size, found });
        let mut other = SMALL;
        other[layout::LETTER] = b'W';
        assert_eq!(StateMessage::new(&other, size), error(10));
        assert_eq!(StateMessage::new(&SMALL[..9], size), error(9));
        assert_eq!(StateMessage::new(&[b'S'; 11], size), error(11));
        assert_eq!(StateMessage::new(b"", size), error(0));
    }

    #[test]
    fn a_pose_is_a_cell_of_the_maze_and_a_letter() {
        let size = MazeSize::new(3, 2).unwrap();
        for (heading, letter) in Heading::ALL.into_iter().zip(*b"NESW") {
            assert_eq!(heading_byte(heading), letter);
            let pose = Pose::new(Cell::new(2, 1), heading);
            assert_eq!(decode_pose(2, 1, letter, size), Ok(pose));
        }
        for found in [0, b'n', 0xce, 0xff] {
            assert_eq!(decode_pose(0, 0, found, size), Err(RequestError::Heading { found }));
        }
        for cell in [Cell::new(3, 0), Cell::new(0, 2), Cell::new(1, 2)] {
            let outside = Err(RequestError::Outside { cell, size });
            assert_eq!(decode_pose(cell.x, cell.y, b'N', size), outside);
        }
    }
}
