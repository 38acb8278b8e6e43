//! Facts about a maze that do not depend on a strategy.

use mmsim_maze::Maze;

use crate::flood::{Distances, only};

/// Facts about a maze that do not depend on a strategy.
///
/// ```
/// use mmsim_solvers::MazeFacts;
/// let maze = "o---o---o---o\n| S   G |   |\no---o---o---o\n".parse()?;
/// let facts = MazeFacts::new(&maze);
/// assert_eq!((facts.shortest_path, facts.reachable_cells), (Some(1), 2));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MazeFacts {
    /// The number of steps from the start to the nearest goal cell, or `None` if the goal is
    /// unreachable.
    pub shortest_path: Option<u16>,
    /// The number of cells that can be reached from the start, including the start.
    pub reachable_cells: usize,
}

impl MazeFacts {
    /// Computes the facts about a maze.
    #[must_use]
    pub fn new(maze: &Maze) -> Self {
        let start = maze.start().cell;
        Self {
            shortest_path: Distances::flood(maze.walls(), maze.goals()).at(start),
            reachable_cells: Distances::flood(maze.walls(), &only(start)).reachable_cells(),
        }
    }
}
