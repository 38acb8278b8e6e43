//! The distances in a small maze, with one byte per cell.

use mmsim_maze::{CellSet, Walls};

use super::UNREACHABLE;
use super::bytes::waves;
use super::bytes::waves::OpenSides;
use super::wide::plane::{Line, ParityPlane, SMALL_SIDE};
use super::wide::spread;
use super::wide::waves::Flooded;

/// The distances in a maze of up to 16×16 cells.
#[derive(Clone, Debug)]
// The bytes are at the start of the memory, where the fewest instructions find them.
#[repr(C, align(4))]
pub(super) struct SmallSteps {
    /// The rows of 16 cells, from south to north.
    lines: [[Line; 8]; SMALL_SIDE / 8],
    /// True if the byte 255 is a distance; otherwise, it is `UNREACHABLE_BYTE`. A shortest path can
    /// only have a length of 255 steps if it visits all of 16×16 cells.
    all_reached: bool,
}

impl PartialEq for SmallSteps {
    fn eq(&self, other: &Self) -> bool {
        // `all_reached` has a meaning only for the byte 255.
        (0..SMALL_SIDE * SMALL_SIDE).all(|index| self.raw(index) == other.raw(index))
    }
}

impl Eq for SmallSteps {}

const UNREACHABLE_BYTE: u8 = u8::MAX;

impl SmallSteps {
    /// The distances in a maze in which no cell can reach a target.
    pub(super) const UNREACHABLE: Self = {
        let lines = [[[UNREACHABLE_BYTE; SMALL_SIDE]; 8]; SMALL_SIDE / 8];
        Self { lines, all_reached: false }
    };

    #[inline(always)]
    pub(super) fn from_flooded<H: ParityPlane>(flooded: &Flooded<H>) -> Self {
        let mut lines = [[[0; SMALL_SIDE]; 8]; SMALL_SIDE / 8];
        spread::write(flooded, 0, &mut lines);
        Self { lines, all_reached: flooded.is_full() }
    }

    /// Floods a maze with one byte per cell. Overwrites `sides`, whose contents do not matter.
    pub(super) fn flood_on_bytes(
        &mut self,
        walls: &Walls,
        targets: &CellSet,
        sides: &mut OpenSides,
    ) {
        if let Some(bytes) = self.bytes() {
            self.all_reached = waves::flood(walls, targets, sides, bytes);
        }
    }

    /// Returns the bytes of all cells. The result is never `None`.
    #[inline(always)]
    pub(super) fn bytes(&mut self) -> Option<&mut [u8; waves::AREA]> {
        self.lines.as_flattened_mut().as_flattened_mut().first_chunk_mut()
    }

    /// Returns the distance of the cell at `index`, or [`UNREACHABLE`] if the cell cannot reach a
    /// target.
    #[inline]
    pub(super) fn raw(&self, index: usize) -> u16 {
        let bytes = self.lines.as_flattened().as_flattened();
        let steps = bytes[index % bytes.len()];
        let is_reached = steps != UNREACHABLE_BYTE || self.all_reached;
        if is_reached { steps.into() } else { UNREACHABLE }
    }
}
