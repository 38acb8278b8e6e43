//! The lengths of messages and the positions of the fields in a state, and buffers for messages.
//!
//! The fields of a state are, in sequence: the letter `S`, x, y, the heading, the order of the
//! weights, the weights, the order of the walls, and the walls.

use core::ops::Range;

use mmsim_maze::MazeSize;

/// The length in bytes of a state for a maze of the [largest](MazeSize::LARGEST) size: 2,054 with the
/// feature `half-size`, otherwise 518.
pub const MAX_STATE_BYTES: usize = state_bytes(MazeSize::LARGEST);

/// Returns the length in bytes of a state for a maze of this size, such as 518 for 16×16 cells.
pub const fn state_bytes(size: MazeSize) -> usize {
    walls(size.area()).end
}

pub(crate) const LETTER: usize = 0;
pub(crate) const X: usize = 1;
pub(crate) const Y: usize = 2;
pub(crate) const HEADING: usize = 3;
pub(crate) const WEIGHTS_ORDER: usize = 4;
const WEIGHTS: usize = 5;

pub(crate) const fn weights(area: usize) -> Range<usize> {
    WEIGHTS..WEIGHTS + area
}

pub(crate) const fn walls_order(area: usize) -> usize {
    weights(area).end
}

pub(crate) const fn walls(area: usize) -> Range<usize> {
    let start = walls_order(area) + 1;
    start..start + area
}

/// The length of a walls request in bytes. A walls request has the same layout as the first fields
/// of a state: letter, x, y and heading.
pub(crate) const WALLS_REQUEST_BYTES: usize = HEADING + 1;

/// The maximum length of an annotations request in bytes. Clients send longer annotations as
/// several requests.
pub const MAX_ANNOTATIONS_BYTES: usize = 4096;

/// The error for a buffer that is too short for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a buffer of at least {expected} bytes, found {found}")]
pub struct BufferTooSmall {
    /// The length of the message in bytes.
    pub expected: usize,
    /// The length of the buffer in bytes.
    pub found: usize,
}

/// Returns the first `length` bytes of the buffer.
pub(crate) fn front_of(buffer: &mut [u8], length: usize) -> Result<&mut [u8], BufferTooSmall> {
    let found = buffer.len();
    buffer.get_mut(..length).ok_or(BufferTooSmall { expected: length, found })
}

/// Copies a message into the buffer and returns the length of the message.
pub(crate) fn write_bytes(buffer: &mut [u8], message: &[u8]) -> Result<usize, BufferTooSmall> {
    front_of(buffer, message.len())?.copy_from_slice(message);
    Ok(message.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_have_the_documented_layout() {
        assert_eq!([LETTER, X, Y, HEADING, WEIGHTS_ORDER], [0, 1, 2, 3, 4]);
        assert_eq!((weights(6), walls_order(6), walls(6)), (5..11, 11, 12..18));
        let size = |width, height| MazeSize::new(width, height).unwrap();
        let bytes = [size(1, 1), size(2, 3), size(16, 16), size(32, 32)].map(state_bytes);
        assert_eq!(bytes, [8, 18, 518, 2054]);
        assert_eq!((MAX_STATE_BYTES, WALLS_REQUEST_BYTES), (2054, 4));
    }

    #[test]
    fn messages_fill_the_front_of_the_buffer() {
        let mut buffer = [9; 4];
        assert_eq!(front_of(&mut buffer, 0), Ok(&mut [][..]));
        assert_eq!(front_of(&mut buffer, 4), Ok(&mut [9; 4][..]));
        assert_eq!(write_bytes(&mut buffer, b"ab"), Ok(2));
        assert_eq!(buffer, [b'a', b'b', 9, 9]);
        let error = write_bytes(&mut buffer, b"abcde").unwrap_err();
        assert_eq!(error, BufferTooSmall { expected: 5, found: 4 });
        insta::assert_snapshot!(error, @"expected a buffer of at least 5 bytes, found 4");
        assert_eq!(buffer, [b'a', b'b', 9, 9]);
    }
}
