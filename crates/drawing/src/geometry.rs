//! Positions and sizes in a drawing.

use mmsim_maze::{Cell, MazeSize};

/// The width of a cell, in units.
pub(crate) const PITCH: u32 = 20;

/// The margin around the maze, in units.
pub(crate) const MARGIN: u32 = 2;

/// A rectangle, given by the coordinates of its west, north, east and south edges, in units.
pub(crate) type Area = [i32; 4];

/// Returns the width and height of the drawing of a maze, in units.
pub(crate) fn units(size: MazeSize) -> (u32, u32) {
    let length = |cells: u8| u32::from(cells) * PITCH + 2 * MARGIN;
    (length(size.width()), length(size.height()))
}

/// Returns the area of the cell with this north-west corner.
pub(crate) fn cell_area((x, y): (u32, u32)) -> Area {
    let (west, north, pitch) = (x.cast_signed(), y.cast_signed(), PITCH.cast_signed());
    [west, north, west + pitch, north + pitch]
}

/// Returns the bounding box of two areas.
pub(crate) fn around(one: Area, other: Area) -> Area {
    [one[0].min(other[0]), one[1].min(other[1]), one[2].max(other[2]), one[3].max(other[3])]
}

/// Returns the north-west corner of a cell, in units.
pub(crate) fn corner(size: MazeSize, cell: Cell) -> (u32, u32) {
    let row = u32::from(size.height()) - 1 - u32::from(cell.y);
    (u32::from(cell.x) * PITCH, row * PITCH)
}

/// Returns the centre of a cell, in units.
pub(crate) fn centre(size: MazeSize, cell: Cell) -> (u32, u32) {
    let (x, y) = corner(size, cell);
    (x + PITCH / 2, y + PITCH / 2)
}
