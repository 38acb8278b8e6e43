//! The positions of the fields in a state: the letter, x, y, the heading, the order of the weights,
//! the weights, the order of the walls, and the walls.

use core::ops::Range;

use mmsim_maze::MazeSize;

/// The length in bytes of the longest state, which is a state of a 32×32 maze.
pub const MAX_STATE_BYTES: usize = state_bytes(MazeSize::HALF_SIZE);

/// Returns the length of a state in bytes for a maze of this size: 518 for 16×16 cells.
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

/// The length of a walls request in bytes. The pose has the same position as in a state.
pub(crate) const WALLS_REQUEST_BYTES: usize = HEADING + 1;
