//! Conversion of the distances of a flood to one byte per cell.

use super::plane::{Line, ParityPlane};
use super::waves::{Flooded, Marks};

/// Writes one byte per cell, which holds the bits `first` to `first` + 7 of the cell's distance.
/// The rows are ordered from south to north, and the cells of each row from west to east. The bytes
/// of unvisited cells have all bits set.
#[inline(always)]
pub(super) fn write<H: ParityPlane>(flooded: &Flooded<H>, first: usize, lines: &mut [[Line; 8]]) {
    let (mut even, mut odd) = ([H::NONE; 8], [H::NONE; 8]);
    for i in 0..8 {
        let plane = |marks: &Marks<H>| match marks.planes.get(first + i) {
            Some(plane) => plane.or(marks.unvisited),
            None => marks.unvisited,
        };
        [even[i], odd[i]] = flooded.columns(plane);
    }
    H::spread(even, odd, lines);
}
