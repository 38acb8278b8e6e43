//! The distances of a flood, one byte per cell.

use super::plane::ParityPlane;
use super::transpose::Line;
use super::waves::{Flooded, Marks};

/// Writes 8 bits of each distance, from bit `first` on, as one byte per cell, row by row from the
/// south-west. In unvisited cells all bits are set.
#[inline(always)]
pub(super) fn write<const N: usize, H: ParityPlane<N>>(
    flooded: &Flooded<H>,
    first: usize,
    lines: &mut [[Line; 8]],
) {
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
