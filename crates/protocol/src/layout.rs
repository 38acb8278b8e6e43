//! The positions of the fields in a state. The fields are, in sequence: the letter `S`, x, y,
//! the heading, the order of the weights, the weights, the order of the walls, and the walls.

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
}
