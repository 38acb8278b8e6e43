//! The true maze.

use crate::cell::{Cell, MazeSize, Pose};
use crate::cell_set::CellSet;
use crate::heading::Heading;
use crate::symmetry::Symmetry;
use crate::walls::Walls;

/// The true maze: all walls, the start and the goal. Only a simulator knows the true maze; a mouse
/// has a [`KnownMaze`](crate::KnownMaze).
///
/// [`Display`](core::fmt::Display) writes a maze as a text picture, which [`str::parse`] can read.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Maze {
    walls: Walls,
    start: Cell,
    goals: CellSet,
}

/// The error for a start or goal outside the maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} at {cell} is outside the maze of {size} cells")]
#[non_exhaustive]
pub struct MazeError {
    /// Either `start` or `goal`.
    pub what: &'static str,
    /// The cell that is outside the maze.
    pub cell: Cell,
    /// The size of the maze.
    pub size: MazeSize,
}

impl Maze {
    /// Creates a maze. If `goals` is empty, the central cells ([`MazeSize::central_cells`]) become
    /// the goal.
    ///
    /// # Errors
    /// Returns an error if the start or a goal is outside the maze.
    pub fn new(walls: Walls, start: Cell, goals: CellSet) -> Result<Self, MazeError> {
        let size = walls.size();
        let outside = |cell: &Cell| !size.contains(*cell);
        if outside(&start) {
            return Err(MazeError { what: "start", cell: start, size });
        }
        if let Some(cell) = goals.iter().find(outside) {
            return Err(MazeError { what: "goal", cell, size });
        }
        let goals = if goals.is_empty() { size.central_cells() } else { goals };
        Ok(Self { walls, start, goals })
    }

    /// Returns the size.
    pub const fn size(&self) -> MazeSize {
        self.walls.size()
    }

    /// Returns the walls.
    pub const fn walls(&self) -> &Walls {
        &self.walls
    }

    /// Returns the pose in which a mouse starts: in the start cell, heading north.
    pub const fn start(&self) -> Pose {
        Pose::new(self.start, Heading::North)
    }

    /// Returns the goal cells (at least one). A mouse has reached the goal when it is in any goal
    /// cell.
    pub const fn goals(&self) -> &CellSet {
        &self.goals
    }

    /// Returns the maze after a rotation or reflection. The start moves with its cell, and the mouse
    /// still starts heading north.
    #[must_use]
    pub fn transformed(&self, symmetry: Symmetry) -> Self {
        let moved = |cell| symmetry.cell(cell, self.size());
        let mut walls = Walls::open(symmetry.size(self.size()));
        for cell in self.size().cells() {
            for heading in Heading::ALL.into_iter().filter(|&heading| self.walls.has(cell, heading))
            {
                let Some(beyond) = self.size().neighbour(cell, heading) else { continue };
                let is_moved = |&to: &Heading| moved(cell).neighbour(to) == Some(moved(beyond));
                if let Some(to) = Heading::ALL.into_iter().find(is_moved) {
                    walls.set(moved(cell), to, true);
                }
            }
        }
        Self { walls, start: moved(self.start), goals: self.goals.iter().map(moved).collect() }
    }

    /// Returns the inner posts that no wall touches. Each post is identified by the cell to its
    /// north-east. Contest rules allow only the central post of a maze to stand without a wall, so
    /// this post is never returned.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Maze};
    /// let maze: Maze = "\
    /// o---o---o---o
    /// |         G |
    /// o   o   o---o
    /// | S         |
    /// o---o---o---o
    /// ".parse()?;
    /// assert!(maze.posts_without_wall().eq([Cell::new(1, 1)]));
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn posts_without_wall(&self) -> impl Iterator<Item = Cell> + '_ {
        let size = self.size();
        let is_middle = move |cell: Cell| (2 * cell.x, 2 * cell.y) == (size.width(), size.height());
        size.cells().filter(move |&post| !is_middle(post) && !self.walls.has_wall_at_corner(post))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_and_goals_must_be_inside() {
        let walls = Walls::open(MazeSize::new(4, 3).unwrap());
        let goals = |x, y| [Cell::new(x, y)].into_iter().collect();
        let maze = Maze::new(walls.clone(), Cell::new(3, 2), goals(0, 2)).unwrap();
        assert_eq!(maze.start(), Pose::new(Cell::new(3, 2), Heading::North));
        let error = Maze::new(walls.clone(), Cell::new(4, 0), goals(0, 0)).unwrap_err();
        assert_eq!(error.to_string(), "the start at (4, 0) is outside the maze of 4x3 cells");
        let error = Maze::new(walls, Cell::new(0, 0), goals(0, 3)).unwrap_err();
        assert_eq!(error.to_string(), "the goal at (0, 3) is outside the maze of 4x3 cells");
    }

    #[test]
    fn one_wall_at_a_post_is_enough() {
        let (north_east, south_west) = (Cell::new(1, 1), Cell::new(0, 0));
        for (cell, heading, touches) in [
            (north_east, Heading::South, true),
            (north_east, Heading::West, true),
            (south_west, Heading::North, true),
            (south_west, Heading::East, true),
            (north_east, Heading::North, false),
            (north_east, Heading::East, false),
        ] {
            let mut walls = Walls::open(MazeSize::new(5, 5).unwrap());
            walls.set(cell, heading, true);
            let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
            let is_free = maze.posts_without_wall().any(|post| post == north_east);
            assert_eq!(is_free, !touches, "{cell} {heading}");
        }
    }

    #[test]
    fn only_the_central_post_needs_no_wall() {
        let posts = |width, height| -> Vec<Cell> {
            let walls = Walls::open(MazeSize::new(width, height).unwrap());
            let goals = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(x, y)| Cell::new(x, y));
            let maze = Maze::new(walls, Cell::new(0, 0), goals.into_iter().collect()).unwrap();
            maze.posts_without_wall().collect()
        };
        assert_eq!(posts(4, 2), [Cell::new(1, 1), Cell::new(3, 1)]);
        assert_eq!(posts(3, 2), [Cell::new(1, 1), Cell::new(2, 1)]);
        assert_eq!(posts(2, 2), []);
        assert_eq!(posts(2, 4), [Cell::new(1, 1), Cell::new(1, 3)]);
    }

    #[test]
    fn the_default_goal_is_the_centre() {
        let walls = Walls::open(MazeSize::CLASSIC);
        let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
        assert_eq!(*maze.goals(), MazeSize::CLASSIC.central_cells());
    }
}
