//! Converts the distances of a flood from bit sets to bytes.

use super::plane::{Line, ParityPlane};
use super::waves::{Flooded, Marks};

/// Writes one byte of each cell's distance: the low byte if `first` is 0, the high byte if it is 8.
/// The rows are ordered from south to north, and the cells of each row from west to east. The bytes
/// of unvisited cells have all bits set.
#[inline(always)]
pub(crate) fn write<H: ParityPlane>(flooded: &Flooded<H>, first: usize, lines: &mut [[Line; 8]]) {
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
