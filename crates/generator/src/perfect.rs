//! Perfect mazes, and open mazes derived from them.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls, WyRand};

use crate::tree;

/// The start cell of every maze.
pub(crate) const START: Cell = Cell::new(0, 0);

/// Returns the walls of a perfect maze.
pub(crate) fn perfect(size: MazeSize, rng: &mut WyRand) -> Walls {
    let room = size.central_cells();
    let mut walls = closed_around(size, &room);
    let mut free: CellSet = size.cells().filter(|&cell| !room.contains(cell)).collect();
    // The start is a dead end unless the maze is a single row or column.
    if size.width() > 1 && size.height() > 1 && free.remove(START) {
        walls.set(START, Heading::North, false);
    }
    tree::uniform(&mut walls, room, &free, rng);
    walls
}

/// Returns the walls of an open maze: a perfect maze with most walls removed.
pub(crate) fn open(size: MazeSize, rng: &mut WyRand) -> Walls {
    /// The probability, in tenths, that a wall remains.
    const REMAINING_TENTHS: u32 = 3;
    let mut walls = perfect(size, rng);
    for wall in size.walls().filter(|wall| wall.cell != START) {
        if rng.below(10) >= REMAINING_TENTHS {
            walls.set(wall.cell, wall.heading, false);
        }
    }
    walls
}

/// Returns a maze with all walls except those inside the goal room.
pub(crate) fn closed_around(size: MazeSize, room: &CellSet) -> Walls {
    let mut walls = Walls::closed(size);
    for cell in room {
        for heading in Heading::ALL {
            if cell.neighbour(heading).is_some_and(|next| room.contains(next)) {
                walls.set(cell, heading, false);
            }
        }
    }
    walls
}
