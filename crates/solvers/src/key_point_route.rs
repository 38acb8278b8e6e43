//! The sequence of cells (key points) that a mouse visits to explore a maze.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};

use crate::a_star::ShortestPath;
use crate::flood::{Distances, only};

/// A route that visits the goal and the corners of a maze in the same order as the robot published
/// for the project "plot and navigate a virtual maze".
///
/// ```text
///  2. top left ┌───────┐ 5. top right
///              │       │
///              │   1.  │ 4. 6. 8. centre
///              │       │
///     7. start └───────┘ 3. bottom right
/// ```
///
/// Unreachable key points are skipped. The centre is the [reachable goal cell nearest to the
/// middle](centre) of the maze.
///
/// ```
/// use mmsim_maze::{Cell, MazeSize, Walls};
/// use mmsim_solvers::KeyPointRoute;
/// let goals = MazeSize::CLASSIC.central_cells();
/// let walls = Walls::open(MazeSize::CLASSIC);
/// let mut route = KeyPointRoute::swing(MazeSize::CLASSIC, Cell::new(0, 0), goals, 3);
/// assert_eq!(route.target(&walls, Cell::new(0, 0)), Some(Cell::new(7, 8)));
/// assert_eq!(route.target(&walls, Cell::new(7, 8)), Some(Cell::new(0, 15)));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct KeyPointRoute {
    goals: CellSet,
    passed: CellSet,
    points: [KeyPoint; 8],
    /// The indices of the key points in `points` that are still ahead of the mouse.
    ahead: core::ops::Range<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum KeyPoint {
    Centre,
    Corner(Cell),
    Start(Cell),
}

impl KeyPointRoute {
    /// The maximum number of corners in a route.
    pub const CORNERS: usize = 3;

    /// Creates a route to the centre.
    #[must_use]
    pub fn just_arrive(goals: CellSet) -> Self {
        Self::new(goals, [KeyPoint::Centre])
    }

    /// Creates a route to the centre and back to the start.
    #[must_use]
    pub fn arrive_and_back(start: Cell, goals: CellSet) -> Self {
        Self::new(goals, [KeyPoint::Centre, KeyPoint::Start(start)])
    }

    /// Creates a route through the first `corners` of these corners: top left, bottom right, top
    /// right. With all three, the route is: centre, top left, bottom right, centre, top right,
    /// centre, start, centre.
    #[must_use]
    pub fn swing(size: MazeSize, start: Cell, goals: CellSet, corners: usize) -> Self {
        let (east, north) = (size.width() - 1, size.height() - 1);
        let all = [Cell::new(0, north), Cell::new(east, 0), Cell::new(east, north)];
        let corner = |index: usize| (index < corners).then_some(KeyPoint::Corner(all[index]));
        let (centre, start) = (Some(KeyPoint::Centre), Some(KeyPoint::Start(start)));
        // A mouse that is already in the centre skips this key point.
        let points = [centre, corner(0), corner(1), centre, corner(2), centre, start, centre];
        Self::new(goals, points.into_iter().flatten())
    }

    /// Creates the route with all three corners, but without the final visit to the centre, which
    /// the mouse makes on its fast run.
    #[must_use]
    pub fn there_and_back(size: MazeSize, start: Cell, goals: CellSet) -> Self {
        let mut route = Self::swing(size, start, goals, Self::CORNERS);
        route.ahead.end -= 1;
        route
    }

    /// Returns the route from its end back to its last key point, the start of
    /// [`there_and_back`](Self::there_and_back).
    pub(crate) const fn back(mut self) -> Self {
        self.ahead = self.ahead.end - 1..self.ahead.end;
        self
    }

    /// Marks a cell as passed. The route skips corners that have been passed.
    pub fn pass(&mut self, cell: Cell) {
        self.passed.insert(cell);
    }

    /// Returns true if the next key point is the start.
    pub(crate) fn is_returning(&self) -> bool {
        matches!(self.points[self.ahead.clone()].first(), Some(KeyPoint::Start(_)))
    }

    fn new(goals: CellSet, points: impl IntoIterator<Item = KeyPoint>) -> Self {
        let mut route =
            Self { goals, passed: CellSet::EMPTY, points: [KeyPoint::Centre; 8], ahead: 0..0 };
        for (place, point) in route.points.iter_mut().zip(points) {
            *place = point;
            route.ahead.end += 1;
        }
        route
    }

    /// Returns the next key point for a mouse at `from`, or `None` if the route is complete. Skips
    /// key points that have been reached or that `walls` make unreachable.
    pub fn target(&mut self, walls: &Walls, from: Cell) -> Option<Cell> {
        while !self.ahead.is_empty() {
            let target = match self.points[self.ahead.start] {
                KeyPoint::Centre => centre(&self.goals, walls, from),
                KeyPoint::Corner(cell) if self.passed.contains(cell) => None,
                KeyPoint::Corner(cell) | KeyPoint::Start(cell) => {
                    ShortestPath::find(walls, from, cell).map(|_| cell)
                }
            };
            if target.is_some_and(|target| target != from) {
                return target;
            }
            self.ahead.start += 1;
        }
        None
    }
}

/// Returns the goal cell nearest to the middle of the maze. Goal cells that are unreachable from
/// the cell `from` are ignored. Returns `None` if no goal cell is reachable. Ties are broken in
/// favour of the northernmost, then the westernmost cell.
///
/// In a maze of n×n cells with even n and four goal cells in the middle, the centre is the cell
/// (n/2 - 1, n/2) if that cell is reachable.
#[must_use]
pub fn centre(goals: &CellSet, walls: &Walls, from: Cell) -> Option<Cell> {
    let size = walls.size();
    // The distances from the middle are doubled, because the middle may lie between cells.
    let off = |coordinate: u8, side: u8| (2 * coordinate + 1).abs_diff(side);
    let reached = Distances::flood(walls, &only(from));
    goals.iter().filter(|&cell| reached.at(cell).is_some()).min_by_key(|cell| {
        let off = off(cell.x, size.width()) + off(cell.y, size.height());
        (off, core::cmp::Reverse(cell.y), cell.x)
    })
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Heading;

    use super::*;

    const SIZE: MazeSize = MazeSize::CLASSIC;
    const START: Cell = Cell::new(0, 0);

    /// Returns the cells that the route visits in a maze with these walls.
    fn cells(mut route: KeyPointRoute, walls: &Walls) -> Vec<(u8, u8)> {
        let mut here = START;
        let next = || {
            here = route.target(walls, here)?;
            Some((here.x, here.y))
        };
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn routes_match_the_published_routes() {
        let (goals, walls) = (SIZE.central_cells(), Walls::open(SIZE));
        let swing = |corners| cells(KeyPointRoute::swing(SIZE, START, goals, corners), &walls);
        let centre = (7, 8);
        assert_eq!(swing(3), [centre, (0, 15), (15, 0), centre, (15, 15), centre, (0, 0), centre]);
        assert_eq!(swing(2), [centre, (0, 15), (15, 0), centre, (0, 0), centre]);
        assert_eq!(swing(1), [centre, (0, 15), centre, (0, 0), centre]);
        assert_eq!(swing(0), [centre, (0, 0), centre]);
        assert_eq!(cells(KeyPointRoute::just_arrive(goals), &walls), [centre]);
        assert_eq!(cells(KeyPointRoute::arrive_and_back(START, goals), &walls), [centre, (0, 0)]);
        let without_last = [centre, (0, 15), (15, 0), centre, (15, 15), centre, (0, 0)];
        let there_and_back = KeyPointRoute::there_and_back(SIZE, START, goals);
        assert_eq!(cells(there_and_back, &walls), without_last);
    }

    #[test]
    fn a_mouse_returns_once_all_other_key_points_are_reached() {
        let walls = Walls::open(SIZE);
        let mut route = KeyPointRoute::arrive_and_back(START, SIZE.central_cells());
        let centre = route.target(&walls, START).unwrap();
        assert!(!route.is_returning());
        assert_eq!(route.target(&walls, centre), Some(START));
        assert!(route.is_returning());
        assert_eq!(route.target(&walls, START), None);
        assert!(!route.is_returning());
    }

    #[test]
    fn skips_unreachable_key_points() {
        let mut walls = Walls::open(SIZE);
        for cell in [Cell::new(0, 15), Cell::new(7, 8)] {
            for heading in Heading::ALL {
                walls.set(cell, heading, true);
            }
        }
        let route = KeyPointRoute::swing(SIZE, START, SIZE.central_cells(), 1);
        assert_eq!(cells(route, &walls), [(8, 8), (0, 0), (8, 8)]);
        let nowhere = KeyPointRoute::swing(SIZE, START, CellSet::EMPTY, 0);
        assert_eq!(cells(nowhere, &walls), []);
    }

    #[test]
    fn centre_is_the_goal_cell_nearest_to_the_middle() {
        let centre_of = |width, height, cells: &[(u8, u8)]| {
            let goals = cells.iter().map(|&(x, y)| Cell::new(x, y)).collect();
            let walls = Walls::open(MazeSize::new(width, height).unwrap());
            centre(&goals, &walls, START).map(|cell| (cell.x, cell.y))
        };
        assert_eq!(centre_of(5, 5, &[(0, 4), (4, 2), (2, 0)]), Some((4, 2)));
        assert_eq!(centre_of(32, 32, &[(31, 31), (30, 31), (9, 40)]), Some((30, 31)));
        assert_eq!(centre_of(1, 1, &[(0, 0)]), Some((0, 0)));
        assert_eq!(centre_of(4, 4, &[]), None);
    }
}
