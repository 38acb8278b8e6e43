//! A mouse's map of a maze.

use crate::cell::{Cell, MazeSize, Pose};
use crate::cell_set::CellSet;
use crate::heading::Heading;
use crate::maze::Maze;
use crate::walls::{Sides, Walls, WallsAround};

/// A mouse's map of a maze. The map contains the size, the start, the goal cells, the visited
/// cells, and the state of each wall (present, absent or unknown). The outer walls are known from
/// the beginning.
///
/// [`walls`](Self::walls) treats unknown walls either as absent (for search runs) or as present
/// (for fast runs).
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
    /// The walls that are known to be present.
    certain: Walls,
    /// The walls that are known to be present, and the unknown walls.
    possible: Walls,
    start: Cell,
    goals: CellSet,
    visited: CellSet,
}

/// What a mouse knows about a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WallState {
    /// The wall is known to be present.
    Present,
    /// The wall is known to be absent.
    Absent,
    /// The wall has not been observed yet.
    Unknown,
}

impl WallState {
    /// Returns the state of a wall: present if `certain`, absent if not `possible`, otherwise
    /// unknown.
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
    /// Unknown walls count as absent (the optimistic assumption, for search runs).
    Open,
    /// Unknown walls count as present (the pessimistic assumption, for fast runs).
    Closed,
}

/// The error for an observation that contradicts the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the {heading} side of {cell} is known to have {}, but {} was observed",
    wall(!found), wall(*found)
)]
#[non_exhaustive]
pub struct Contradiction {
    /// The observed cell.
    pub cell: Cell,
    /// The side on which the observation contradicts the map.
    pub heading: Heading,
    /// True if the mouse observed a wall on that side, false if it observed none.
    pub found: bool,
}

fn wall(present: bool) -> &'static str {
    if present { "a wall" } else { "no wall" }
}

impl KnownMaze {
    /// Creates the map of an unexplored maze. Only the outer walls are known. `goals` may contain
    /// cells outside the maze, but a mouse cannot reach them.
    pub const fn new(size: MazeSize, start: Cell, goals: CellSet) -> Self {
        let (certain, possible) = (Walls::open(size), Walls::closed(size));
        Self { certain, possible, start, goals, visited: CellSet::EMPTY }
    }

    /// Creates the map of an unexplored maze with the size, start and goal of `maze`.
    pub fn unexplored(maze: &Maze) -> Self {
        Self::new(maze.size(), maze.start().cell, *maze.goals())
    }

    /// Returns the size.
    pub const fn size(&self) -> MazeSize {
        self.certain.size()
    }

    /// Returns the pose in which the mouse starts: in the start cell, heading north.
    pub const fn start(&self) -> Pose {
        Pose::new(self.start, Heading::North)
    }

    /// Returns the goal cells.
    pub const fn goals(&self) -> &CellSet {
        &self.goals
    }

    /// Returns the cells that the mouse has visited.
    pub const fn visited(&self) -> &CellSet {
        &self.visited
    }

    /// Returns what the mouse knows about the wall on the `heading` side of `cell`.
    pub fn wall(&self, cell: Cell, heading: Heading) -> WallState {
        WallState::from_bounds(self.certain.has(cell, heading), self.possible.has(cell, heading))
    }

    /// Returns all walls. The argument selects whether unknown walls count as absent or as present.
    pub const fn walls(&self, unknown: Unknown) -> &Walls {
        match unknown {
            Unknown::Open => &self.certain,
            Unknown::Closed => &self.possible,
        }
    }

    /// Records the walls that a mouse observes at `pose`, and marks the cell of `pose` as visited.
    /// If `pose` is outside the maze, no cell is marked, and the only valid observation is a wall
    /// on every side.
    ///
    /// # Errors
    /// Returns an error and leaves the map unchanged if the observation contradicts the map.
    pub fn observe(&mut self, pose: Pose, around: WallsAround) -> Result<(), Contradiction> {
        let Pose { cell, heading } = pose;
        let all = WallsAround { left: true, front: true, right: true };
        let read = Sides::from_walls_around(heading, all);
        let found = Sides::from_walls_around(heading, around);
        let (certain, possible) = (self.certain.sides(cell), self.possible.sides(cell));
        let known_absent = found.without(possible);
        let known_present = read.without(found).and(certain);
        let contradictions = known_absent.or(known_present);
        if contradictions != Sides::NONE {
            let contradicts = |&heading: &Heading| contradictions.has(heading);
            let from_left = [heading.left(), heading, heading.right()];
            let heading = from_left.into_iter().find(contradicts).unwrap_or(heading);
            return Err(Contradiction { cell, heading, found: found.has(heading) });
        }
        // `certain` and `possible` include the outer walls, so only inner walls are toggled.
        self.certain.toggle(cell, found.without(certain));
        self.possible.toggle(cell, read.without(found).and(possible));
        self.visit(cell);
        Ok(())
    }

    /// Sets the state of the wall on the `heading` side of `cell`, even if the map contains a
    /// different state. Outer walls cannot be changed. Use this method to load a map, and
    /// [`observe`](Self::observe) to record observations.
    pub fn set_wall(&mut self, cell: Cell, heading: Heading, wall: WallState) {
        self.certain.set(cell, heading, wall == WallState::Present);
        self.possible.set(cell, heading, wall != WallState::Absent);
    }

    /// Makes each wall unknown whose position is not marked by a wall in `observed`. Visited cells
    /// stay visited.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, WallState, Walls};
    /// let (size, corner) = (MazeSize::CLASSIC, Cell::new(0, 0));
    /// let mut map = KnownMaze::new(size, corner, size.central_cells());
    /// map.set_wall(corner, Heading::North, WallState::Absent);
    /// map.set_wall(corner, Heading::East, WallState::Absent);
    /// let mut observed = Walls::open(size);
    /// observed.set(corner, Heading::East, true);
    /// map.forget_unobserved(&observed);
    /// assert_eq!(map.wall(corner, Heading::North), WallState::Unknown);
    /// assert_eq!(map.wall(corner, Heading::East), WallState::Absent);
    /// ```
    pub fn forget_unobserved(&mut self, observed: &Walls) {
        self.certain = self.certain.combine(observed, |certain, observed| certain & observed);
        self.forget_unobserved_openings(observed);
    }

    /// Makes each absent wall unknown whose position is not marked by a wall in `observed`.
    pub fn forget_unobserved_openings(&mut self, observed: &Walls) {
        self.possible = self.possible.combine(observed, |possible, observed| possible | !observed);
    }

    /// Makes each wall unknown that differs from the true maze. The shortest path is then at least
    /// as long as the optimistic distance, and at most as long as the pessimistic distance.
    pub fn forget_errors(&mut self, truth: &Walls) {
        self.certain = self.certain.combine(truth, |certain, truth| certain & truth);
        self.possible = self.possible.combine(truth, |possible, truth| possible | truth);
    }

    /// Returns the walls that differ from the true maze, each as a cell and the north or east side
    /// of the cell. Unknown walls do not differ.
    ///
    /// ```
    /// use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, WallState, Walls};
    /// let (size, corner) = (MazeSize::CLASSIC, Cell::new(0, 0));
    /// let mut map = KnownMaze::new(size, corner, size.central_cells());
    /// map.set_wall(corner, Heading::North, WallState::Absent);
    /// map.set_wall(corner, Heading::East, WallState::Present);
    /// let wrong: Vec<_> = map.wrong_walls(&Walls::open(size)).collect();
    /// assert_eq!(wrong, [(corner, Heading::East)]);
    /// ```
    pub fn wrong_walls<'a>(
        &'a self,
        truth: &'a Walls,
    ) -> impl Iterator<Item = (Cell, Heading)> + 'a {
        let sides = self.size().walls().map(|wall| (wall.cell, wall.heading));
        sides.filter(|&(cell, heading)| {
            let opposite =
                if truth.has(cell, heading) { WallState::Absent } else { WallState::Present };
            self.wall(cell, heading) == opposite
        })
    }

    /// Marks `cell` as visited if it is inside the maze.
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
            "the west side of (0, 0) is known to have a wall, but no wall was observed"
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
        assert_eq!(
            error.to_string(),
            "the north side of (0, 0) is known to have no wall, but a wall was observed"
        );
        assert_eq!(map, seen);
    }

    #[test]
    fn the_contradiction_furthest_to_the_left_is_reported() {
        let (mut map, pose) = (map(), Pose::new(Cell::new(1, 1), Heading::South));
        map.observe(pose, OPEN).unwrap();
        for (left, front, right, heading) in [
            (true, true, true, Heading::East),
            (false, true, true, Heading::South),
            (false, false, true, Heading::West),
        ] {
            let error = map.observe(pose, WallsAround { left, front, right }).unwrap_err();
            assert_eq!(error, Contradiction { cell: pose.cell, heading, found: true });
        }
    }

    #[test]
    fn repeating_an_observation_changes_nothing() {
        let size = map().size();
        for (walls, cell) in [
            (Walls::closed(size), Cell::new(1, 1)),
            (Walls::closed(size), Cell::new(2, 2)),
            (Walls::open(size), Cell::new(1, 1)),
            (Walls::open(size), Cell::new(2, 2)),
        ] {
            for heading in Heading::ALL {
                let (mut map, pose) = (map(), Pose::new(cell, heading));
                map.observe(pose, walls.around(pose)).unwrap();
                let seen = map.clone();
                map.observe(pose, walls.around(pose)).unwrap();
                assert_eq!(map, seen);
                for unknown in [Unknown::Open, Unknown::Closed] {
                    assert_eq!(map.walls(unknown).around(pose), walls.around(pose));
                }
            }
        }
    }

    #[test]
    fn an_unexplored_map_has_the_start_and_goal_of_the_maze() {
        let goals = [Cell::new(2, 0)].into_iter().collect();
        let walls = Walls::closed(MazeSize::new(3, 2).unwrap());
        let map = KnownMaze::unexplored(&Maze::new(walls, Cell::new(1, 0), goals).unwrap());
        assert_eq!(map, KnownMaze::new(map.size(), Cell::new(1, 0), goals));
        assert_eq!(map.size().to_string(), "3x2");
        assert_eq!(map.start(), Pose::new(Cell::new(1, 0), Heading::North));
        assert_eq!(map.goals(), &goals);
        assert_eq!(map.walls(Unknown::Open), &Walls::open(map.size()));
        assert_eq!(map.walls(Unknown::Closed), &Walls::closed(map.size()));
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
    fn only_observed_and_correct_walls_stay_known() {
        use WallState::{Absent, Present, Unknown};
        let (cell, heading) = (Cell::new(1, 1), Heading::West);
        for observed in [false, true] {
            for truth in [false, true] {
                for claim in [Absent, Present, Unknown] {
                    let mut walls = Walls::open(map().size());
                    let mut map = map();
                    map.visit(cell);
                    map.set_wall(cell, heading, claim);
                    let mut kept = map.clone();
                    let mut without_openings = map.clone();
                    walls.set(cell, heading, observed);
                    without_openings.forget_unobserved_openings(&walls);
                    let is_kept = observed || claim == Present;
                    let expected = if is_kept { claim } else { Unknown };
                    assert_eq!(without_openings.wall(cell, heading), expected);
                    kept.forget_unobserved(&walls);
                    assert_eq!(kept.wall(cell, heading), if observed { claim } else { Unknown });
                    walls.set(cell, heading, truth);
                    map.forget_errors(&walls);
                    let is_correct = (claim == Present) == truth;
                    assert_eq!(map.wall(cell, heading), if is_correct { claim } else { Unknown });
                    for map in [map, kept] {
                        assert_eq!(map.wall(Cell::new(0, 0), Heading::South), Present);
                        assert!(map.visited().contains(cell));
                    }
                }
            }
        }
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
