//! Layout of a state with A cells: `S` x y heading order weights order walls.

use core::ops::Range;

use mmsim_maze::MazeSize;

/// Length of the longest state, which is that of a 32×32 maze, in bytes.
pub const MAX_STATE_BYTES: usize = state_bytes(MazeSize::HALF_SIZE);

/// Returns the length of a state of a maze of this size in bytes: 518 for 16×16.
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

/// Length of a walls request in bytes: `W` x y heading, at the same offsets.
pub(crate) const WALLS_REQUEST_BYTES: usize = HEADING + 1;
