//! What there is to know of a maze before anybody runs in it.

use mmsim_maze::{CellSet, Maze};

use crate::flood::Distances;

/// What there is to know of a maze before anybody runs in it.
///
/// ```
/// use mmsim_solvers::MazeFacts;
/// let maze = "o---o---o---o\n| S   G |   |\no---o---o---o\n".parse()?;
/// let facts = MazeFacts::new(&maze);
/// assert_eq!((facts.shortest_path, facts.reachable_cells), (Some(1), 2));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MazeFacts {
    /// Steps from the start to the nearest goal cell, `None` where none can be reached.
    pub shortest_path: Option<u16>,
    /// Cells that can be reached from the start, itself included.
    pub reachable_cells: usize,
}

impl MazeFacts {
    /// The facts of this maze.
    pub fn new(maze: &Maze) -> Self {
        let start = maze.start().cell;
        let from_start: CellSet = [start].into_iter().collect();
        Self {
            shortest_path: Distances::flood(maze.walls(), maze.goals()).at(start),
            reachable_cells: Distances::flood(maze.walls(), &from_start).reachable_cells(),
        }
    }
}
