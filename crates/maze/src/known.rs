//! What a mouse knows of a maze.

use crate::cell::{Cell, MazeSize};
use crate::cell_set::CellSet;
use crate::heading::Heading;
use crate::maze::Maze;
use crate::pose::Pose;
use crate::walls::{Sides, Walls, WallsAround};

/// What a mouse knows: the size, the start, the goal cells, the visited cells, and each wall as
/// present, absent or unknown. The outer walls are known from the beginning.
///
/// Planners choose how to treat unknown walls: [`walls`](Self::walls) returns them as open for a
/// search run, or as closed for a fast run.
///
/// ```
/// use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Unknown, WallState, WallsAround};
///
/// let size = MazeSize::CLASSIC;
/// let mut map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
/// let start = map.start();
/// map.observe(start, WallsAround { left: true, front: false, right: true })?;
/// assert_eq!(map.wall(start.cell, Heading::East), WallState::Present);
/// assert_eq!(map.wall(Cell::new(5, 5), Heading::East), WallState::Unknown);
/// assert!(!map.walls(Unknown::Open).has(Cell::new(5, 5), Heading::East));
/// assert!(map.walls(Unknown::Closed).has(Cell::new(5, 5), Heading::East));
/// # Ok::<(), mmsim_maze::Contradiction>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct KnownMaze {
    /// The walls that are present for certain. Unknown walls are open.
    certain: Walls,
    /// The walls that may be present. Unknown walls are closed.
    possible: Walls,
    start: Cell,
    goals: CellSet,
    visited: CellSet,
}

/// What is known about one wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WallState {
    /// Observed as a wall.
    Present,
    /// Observed as an opening.
    Absent,
    /// Not observed yet.
    Unknown,
}

impl WallState {
    /// Returns the state of a wall that is present for certain, possibly present, or neither.
    pub(crate) const fn from_bounds(certain: bool, possible: bool) -> Self {
        match (certain, possible) {
            (true, _) => Self::Present,
            (false, true) => Self::Unknown,
            (false, false) => Self::Absent,
        }
    }
}

/// How a planner treats unknown walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unknown {
    /// As absent: optimistic, for a search run.
    Open,
    /// As present: pessimistic, for a fast run.
    Closed,
}

/// An observation that contradicts what is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected {} at the {heading} side of {cell}, as known before, found {}",
    wall(!found), wall(*found)
)]
#[non_exhaustive]
pub struct Contradiction {
    /// The observed cell.
    pub cell: Cell,
    /// The contradictory side of the cell.
    pub heading: Heading,
    /// Whether a wall was observed.
    pub found: bool,
}

fn wall(present: bool) -> &'static str {
    if present { "a wall" } else { "no wall" }
}

impl KnownMaze {
    /// Creates an unexplored maze, of which only the outer walls are known. Goal cells outside the maze
    /// are unreachable.
    pub fn new(size: MazeSize, start: Cell, goals: CellSet) -> Self {
        let (certain, possible) = (Walls::open(size), Walls::closed(size));
        Self { certain, possible, start, goals, visited: CellSet::EMPTY }
    }

    /// Creates an unexplored maze with the size, start and goal of this maze.
    pub fn unexplored(maze: &Maze) -> Self {
        Self::new(maze.size(), maze.start().cell, *maze.goals())
    }

    /// Returns the size.
    pub const fn size(&self) -> MazeSize {
        self.certain.size()
    }

    /// Returns the start pose: in the start cell, heading north.
    pub const fn start(&self) -> Pose {
        Pose::new(self.start, Heading::North)
    }

    /// Returns the goal cells.
    pub const fn goals(&self) -> &CellSet {
        &self.goals
    }

    /// Returns the visited cells, in which the mouse has observed walls.
    pub const fn visited(&self) -> &CellSet {
        &self.visited
    }

    /// Returns what is known about the wall at the side of `cell` towards `heading`.
    pub fn wall(&self, cell: Cell, heading: Heading) -> WallState {
        WallState::from_bounds(self.certain.has(cell, heading), self.possible.has(cell, heading))
    }

    /// Returns all walls, with unknown walls as open or closed.
    pub const fn walls(&self, unknown: Unknown) -> &Walls {
        match unknown {
            Unknown::Open => &self.certain,
            Unknown::Closed => &self.possible,
        }
    }

    /// Records the walls observed at `pose`, and marks its cell as visited. Outside the maze all sides
    /// are walls, and no cell is marked.
    ///
    /// # Errors
    /// Returns an error if the observation contradicts what is known. The map is unchanged then.
    pub fn observe(&mut self, pose: Pose, around: WallsAround) -> Result<(), Contradiction> {
        let Pose { cell, heading } = pose;
        let all = WallsAround { left: true, front: true, right: true };
        let read = Sides::from_walls_around(heading, all);
        let found = Sides::from_walls_around(heading, around);
        let outer = Sides::outer(self.size(), cell);
        let certain = self.certain.inner_sides(cell).or(outer);
        let possible = self.possible.inner_sides(cell).or(outer);
        let known_absent = found.without(possible);
        let known_present = read.without(found).and(certain);
        let contradictions = known_absent.or(known_present);
        if contradictions != Sides::NONE {
            let contradicts = |&heading: &Heading| contradictions.has(heading);
            let from_left = [heading.left(), heading, heading.right()];
            let heading = from_left.into_iter().find(contradicts).unwrap_or(heading);
            return Err(Contradiction { cell, heading, found: found.has(heading) });
        }
        // Both sets include the outer walls and the walls outside.
        self.certain.toggle(cell, found.without(certain));
        self.possible.toggle(cell, read.without(found).and(possible));
        self.visit(cell);
        Ok(())
    }

    /// Sets the wall at the side of `cell` towards `heading`, regardless of what was known. Outer walls
    /// are unchanged. For maps from elsewhere; a mouse uses [`observe`](Self::observe).
    pub fn set_wall(&mut self, cell: Cell, heading: Heading, wall: WallState) {
        self.certain.set(cell, heading, wall == WallState::Present);
        self.possible.set(cell, heading, wall != WallState::Absent);
    }

    /// Marks a cell as visited if it is inside the maze.
    pub fn visit(&mut self, cell: Cell) {
        if self.size().contains(cell) {
            self.visited.insert(cell);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: WallsAround = WallsAround { left: false, front: false, right: false };

    fn map() -> KnownMaze {
        let size = MazeSize::new(3, 3).unwrap();
        KnownMaze::new(size, Cell::new(0, 0), size.central_cells())
    }

    #[test]
    fn only_outer_walls_are_known_at_first() {
        let map = map();
        for cell in map.size().cells() {
            for heading in Heading::ALL {
                let outer = map.size().neighbour(cell, heading).is_none();
                let expected = if outer { WallState::Present } else { WallState::Unknown };
                assert_eq!(map.wall(cell, heading), expected);
            }
        }
        assert!(map.visited().is_empty());
    }

    #[test]
    fn an_observed_wall_is_known_from_both_sides() {
        let mut map = map();
        let pose = Pose::new(Cell::new(1, 1), Heading::East);
        map.observe(pose, WallsAround { left: true, ..OPEN }).unwrap();
        assert_eq!(map.wall(Cell::new(1, 1), Heading::North), WallState::Present);
        assert_eq!(map.wall(Cell::new(1, 2), Heading::South), WallState::Present);
        assert_eq!(map.wall(Cell::new(2, 1), Heading::West), WallState::Absent);
        assert_eq!(map.wall(Cell::new(1, 0), Heading::North), WallState::Absent);
        assert_eq!(
            map.wall(Cell::new(0, 1), Heading::East),
            WallState::Unknown,
            "the wall behind is not observed"
        );
        assert!(map.visited().contains(Cell::new(1, 1)));
        assert_eq!(map.visited().len(), 1);
    }

    #[test]
    fn a_contradiction_changes_nothing() {
        let mut map = map();
        let corner = Pose::new(Cell::new(0, 0), Heading::North);
        let error = map.observe(corner, OPEN).unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected a wall at the west side of (0, 0), as known before, found no wall"
        );
        assert_eq!(map, self::map());
        map.observe(corner, WallsAround { left: true, ..OPEN }).unwrap();
        let seen = map.clone();
        let error =
            map.observe(corner, WallsAround { left: true, front: true, right: false }).unwrap_err();
        assert_eq!(
            error,
            Contradiction { cell: corner.cell, heading: Heading::North, found: true }
        );
        assert_eq!(map, seen);
    }

    #[test]
    fn inner_walls_can_be_set_and_outer_walls_cannot() {
        let (mut map, middle) = (map(), Cell::new(1, 1));
        for wall in [WallState::Present, WallState::Absent, WallState::Unknown] {
            map.set_wall(middle, Heading::West, wall);
            assert_eq!(map.wall(Cell::new(0, 1), Heading::East), wall);
            map.set_wall(Cell::new(0, 1), Heading::West, wall);
        }
        map.visit(Cell::new(3, 0));
        assert_eq!(map, self::map());
        map.visit(middle);
        assert!(map.visited().contains(middle));
    }

    #[test]
    fn outside_the_maze_nothing_is_recorded() {
        let mut map = map();
        let outside = Pose::new(Cell::new(3, 0), Heading::North);
        assert!(map.observe(outside, OPEN).is_err());
        map.observe(outside, WallsAround { left: true, front: true, right: true }).unwrap();
        assert_eq!(map, self::map());
    }
}
