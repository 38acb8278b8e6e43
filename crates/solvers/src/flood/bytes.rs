//! The flood with one byte per cell, for small mazes on processors with 32-bit registers.

use mmsim_maze::CellSet;

use super::steps::SMALL_AREA;
use waves::OpenSides;

pub(super) mod exploration;
pub(super) mod waves;

/// Memory for floods and for the selection of the cell to explore next, so that they need less of
/// the stack. Its contents do not matter.
#[derive(Clone, Debug)]
pub(crate) struct FloodMemory {
    pub(crate) sides: OpenSides,
    pub(super) from_start: [u8; SMALL_AREA],
    candidates: CellSet,
}

impl FloodMemory {
    pub(crate) const NEW: Self =
        Self { sides: OpenSides::NONE, from_start: [0; SMALL_AREA], candidates: CellSet::EMPTY };
}
