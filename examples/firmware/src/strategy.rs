//! The mouse and its strategy. To use your own strategy, change this file.

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose};
#[cfg(not(feature = "shortest-path-search"))]
pub(crate) use mmsim_solvers::FloodFill as Strategy;
#[cfg(feature = "shortest-path-search")]
pub(crate) use mmsim_solvers::ShortestPathSearch as Strategy;

/// A mouse with its strategy and its map.
pub(crate) type Mouse = mmsim_solvers::Mouse<Strategy>;

/// A mouse at the start of an unknown 16×16 maze with the goal in the centre. It is a constant, so
/// that a `static` mouse is ready when the firmware starts.
pub(crate) const NEW_MOUSE: Mouse = {
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    let map = KnownMaze::new(MazeSize::CLASSIC, start.cell, MazeSize::CLASSIC.central_cells());
    Mouse::new(Strategy::new(), map, start)
};

// Map, distances and strategy must leave most of the memory of a small chip to the rest of the
// firmware.
const _: () = assert!(size_of::<Mouse>() <= 1331);
