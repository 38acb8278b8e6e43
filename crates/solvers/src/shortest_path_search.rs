//! The shortest-path search, which explores until a known path is proven to be shortest.

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Pose, Unknown, Walls};

use crate::flood::{
    Distances, ExplorationMemory, ExplorationTarget, UNREACHABLE, steps_between_in,
};
use crate::strategy::{Move, Phase, SearchError, Strategy, step_to_least};

/// A strategy that goes to the goal, explores until no unknown wall can hide a shorter path,
/// returns to the start, and runs to the goal.
///
/// - The mouse uses flood fill to reach the goal. If several neighbours are equally near, the mouse
///   ignores the walls and counts the columns and the rows from each neighbour to the goal. It
///   prefers the neighbour for which the larger of these two numbers is smallest. This neighbour
///   leaves the mouse the most alternative paths to the goal.
/// - After reaching the goal, the mouse explores the optimistic shortest paths from the start to
///   the goal. A layer consists of all cells on the optimistic shortest paths that have the same
///   distance from the start. Every path crosses every layer, so a few walls in a narrow layer may
///   block all paths. Of the layers without a visited cell, the mouse selects those with the fewest
///   cells, and goes to the nearest cell in the selected layers.
/// - The exploration ends as soon as one of the optimistic shortest paths is known to be open,
///   because the optimistic distance then equals the pessimistic distance. The mouse always enters
///   the goal before it returns, even if the proof is complete one step earlier.
/// - On the return run, the mouse tries a path through unknown walls if that path may be shorter
///   than the shortest known path.
///
/// The weight of a cell is its distance in steps to the mouse's current target. If the goal is
/// reachable, the strategy always finds a path and proves that it is the shortest. If the goal is
/// unreachable, the mouse returns to the start before the strategy returns an error.
#[derive(Clone, Debug)]
pub struct ShortestPathSearch {
    leg: Leg,
    /// The cells in which the strategy has made a decision. A second visit to a cell reveals no new
    /// walls.
    visited: CellSet,
    /// The current target of the exploration.
    target: Option<ExplorationTarget>,
    distances: Distances,
    /// The south-western and north-eastern corners of the bounding box of the goal cells, or `None`
    /// before the first decision.
    goal_corners: Option<[Cell; 2]>,
    /// Memory for floods and for [`ExplorationTarget::find`] on small cores.
    memory: ExplorationMemory,
}

/// A part of the search.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Leg {
    ToGoal,
    Explore,
    Return,
    /// The mouse returns to the start because the goal is unreachable.
    GiveUp,
    FastRun,
}

impl ShortestPathSearch {
    /// Creates the strategy in its initial state.
    pub const fn new() -> Self {
        Self {
            leg: Leg::ToGoal,
            visited: CellSet::EMPTY,
            target: None,
            distances: Distances::unreachable(MazeSize::CLASSIC),
            goal_corners: None,
            memory: ExplorationMemory::NEW,
        }
    }

    /// Plans the next steps. If the current part of the search (see [`Leg`]) is complete, begins
    /// the next one.
    fn plan(&mut self, map: &KnownMaze, cell: Cell) {
        let (open, closed) = (map.walls(Unknown::Open), map.walls(Unknown::Closed));
        if self.leg == Leg::ToGoal {
            if !self.distances.is_downhill_open(open, cell) {
                self.flood(open, map.goals());
            }
            if map.goals().contains(cell) {
                self.leg = Leg::Explore;
            } else if self.distances.at(cell).is_none() {
                self.leg = Leg::GiveUp;
            }
        }
        // A new plan is only needed if a wall blocks the current plan, or if the mouse is on a
        // shortest path. Walls elsewhere do not change the shortest paths.
        if self.leg == Leg::Explore {
            let is_valid = self.target.is_some() && self.distances.is_downhill_open(open, cell);
            if !is_valid || self.target.as_ref().is_some_and(|target| target.paths.contains(cell)) {
                let before = self.target.as_ref().map(|target| target.cell);
                self.target =
                    ExplorationTarget::find(map, cell, &mut self.memory, &mut self.distances);
                let after = self.target.as_ref().map(|target| target.cell);
                let is_same = is_valid && before == after && ExplorationTarget::KEEPS_DISTANCES;
                match after {
                    Some(cell) if !is_same => self.flood_from(open, cell),
                    Some(_) => {}
                    None => self.leg = Leg::Return,
                }
            }
        }
        if matches!(self.leg, Leg::Return | Leg::GiveUp) {
            self.plan_return(map, cell);
        }
        if self.leg == Leg::Return && cell == map.start().cell {
            self.leg = Leg::FastRun;
            self.flood(closed, map.goals());
        }
    }

    /// Plans the shortest known path to the start, or a shorter path through unknown walls.
    // Not inlined, like `flood_from`, so that the set occupies the stack only during this call.
    #[inline(never)]
    fn plan_return(&mut self, map: &KnownMaze, cell: Cell) {
        let (open, closed) = (map.walls(Unknown::Open), map.walls(Unknown::Closed));
        let start = only(map.start().cell);
        let optimistic = steps_between_in(&mut self.memory, open, cell, &start);
        self.flood(closed, &start);
        if optimistic.unwrap_or(UNREACHABLE) < self.distances.raw(cell) {
            self.flood(open, &start);
        }
    }

    #[inline(never)]
    fn flood_from(&mut self, walls: &Walls, cell: Cell) {
        self.flood(walls, &only(cell));
    }

    fn flood(&mut self, walls: &Walls, targets: &CellSet) {
        self.distances.reflood_in(Some(&mut self.memory.sides), walls, targets);
    }

    /// Returns true if the current part of the search ends when the mouse enters `cell`.
    fn has_arrived(&self, map: &KnownMaze, cell: Cell) -> bool {
        match self.leg {
            Leg::ToGoal => map.goals().contains(cell),
            Leg::Return => cell == map.start().cell,
            Leg::Explore | Leg::GiveUp | Leg::FastRun => false,
        }
    }
}

impl Default for ShortestPathSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for ShortestPathSearch {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let cell = pose.cell;
        let is_new = self.visited.insert(cell) || cell == map.start().cell;
        if self.leg != Leg::FastRun && (is_new || self.has_arrived(map, cell)) {
            self.plan(map, cell);
        }
        match self.leg {
            Leg::FastRun if map.goals().contains(cell) => return Ok(Move::Stop),
            Leg::GiveUp if map.start().cell == cell => {
                return Err(SearchError::GoalUnreachable { cell });
            }
            _ => {}
        }
        let corners = *self.goal_corners.get_or_insert_with(|| corners(map.goals()));
        let crow_flies =
            if self.leg == Leg::ToGoal { crow_flies_around(cell, corners) } else { [0; 4] };
        let mut numbers = self.distances.raw_around(cell).map(u32::from);
        for (number, crow_flies) in numbers.iter_mut().zip(crow_flies) {
            *number = *number << 8 | u32::from(crow_flies);
        }
        step_to_least(map, pose, numbers)
            .filter(|&(_, number)| number >> 8 < UNREACHABLE.into())
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::BoxedIn { cell })
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        self.distances.at(cell)
    }

    fn phase(&self) -> Phase {
        match self.leg {
            Leg::ToGoal | Leg::Explore => Phase::SearchRun,
            Leg::Return | Leg::GiveUp => Phase::ReturnRun,
            Leg::FastRun => Phase::FastRun,
        }
    }
}

/// Returns the south-western and north-eastern corners of the bounding box of `cells`.
pub(crate) fn corners(cells: &CellSet) -> [Cell; 2] {
    let mut cells = cells.iter();
    let first = cells.next().unwrap_or(Cell::new(0, 0));
    cells.fold([first; 2], |[south_west, north_east], Cell { x, y }| {
        [
            Cell::new(south_west.x.min(x), south_west.y.min(y)),
            Cell::new(north_east.x.max(x), north_east.y.max(y)),
        ]
    })
}

/// Returns the distances of a cell's neighbours from a bounding box, in the order of
/// [`Heading::ALL`](mmsim_maze::Heading::ALL). The distance is the difference in columns or in
/// rows, whichever is larger. Walls are ignored.
pub(crate) fn crow_flies_around(cell: Cell, [south_west, north_east]: [Cell; 2]) -> [u8; 4] {
    let off = |from: u8, at: u8, to: u8| from.saturating_sub(at).max(at.saturating_sub(to));
    let columns = |x| off(south_west.x, x, north_east.x);
    let rows = |y| off(south_west.y, y, north_east.y);
    let Cell { x, y } = cell;
    [
        columns(x).max(rows(y.saturating_add(1))),
        columns(x.saturating_add(1)).max(rows(y)),
        columns(x).max(rows(y.saturating_sub(1))),
        columns(x.saturating_sub(1)).max(rows(y)),
    ]
}

pub(crate) fn only(cell: Cell) -> CellSet {
    [cell].into_iter().collect()
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::driver::SearchDriver;
    use crate::mouse::Mouse;
    use crate::testing::{Outcome, random_mazes, search};

    fn steps(maze: &str) -> (Result<Move, SearchError>, u32) {
        let Outcome { result, steps, .. } = search(ShortestPathSearch::new(), maze, 1000);
        (result, steps)
    }

    #[test]
    fn proves_the_shortest_path_and_runs_it() {
        let maze = "\
o---o---o---o---o
|               |
o   o---o   o   o
|   | G     |   |
o   o---o---o   o
|               |
o   o---o---o---o
| S |           |
o---o---o---o---o
";
        let outcome = search(ShortestPathSearch::new(), maze, 1000);
        assert_eq!((outcome.result, outcome.steps), (Ok(Move::Stop), 21));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o---o
        | 4   3   2   3 |
        o   o---o   o . o
        | 5 | <   1 |   |
        o   o---o---o . o
        | 6   7 .   .   |
        o   o . o . o . o
        | 7 |   .   .   |
        o---o---o---o---o
        ");
    }

    #[test]
    fn reports_an_unreachable_goal_at_the_start() {
        let unreachable = Err(SearchError::GoalUnreachable { cell: Cell::new(0, 0) });
        let maze = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        assert_eq!(steps(maze), (unreachable, 4));
        assert_eq!(steps("o---o---o\n| S | G |\no---o---o\n"), (unreachable, 0));
    }

    #[test]
    fn stops_if_the_start_is_a_goal() {
        for maze in ["o---o\n|SG |\no---o\n", "o---o---o\n| G |SG |\no---o---o\n"] {
            assert_eq!(steps(maze), (Ok(Move::Stop), 0));
        }
    }

    #[test]
    fn returns_over_known_openings_if_no_unknown_path_may_be_shorter() {
        let maze = "\
o---o---o---o
|         G |
o   o---o   o
|   |   |   |
o   o---o   o
| S         |
o---o---o---o
";
        let maze: Maze = maze.parse().unwrap();
        let mut mouse =
            Mouse::new(ShortestPathSearch::new(), KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, 1000);
        let mut cells = Vec::new();
        while driver.phase() != Phase::FastRun && driver.advance_in(&maze) == Ok(true) {
            cells.push(driver.mouse().pose().cell);
        }
        let stats = driver.stats();
        assert_eq!((stats.search_run.steps, stats.return_run.steps), (4, 4));
        let (there, back) = cells.split_at(4);
        assert!(there.iter().rev().eq(&back[1..]), "{cells:?}");
    }

    proptest! {
        #[test]
        fn proves_the_shortest_path_or_reports_an_unreachable_goal(
            maze in random_mazes(32),
        ) {
            let mut mouse =
                Mouse::new(ShortestPathSearch::new(), KnownMaze::unexplored(&maze), maze.start());
            // The strategy plans again only in unvisited cells.
            let max_states = u32::try_from((maze.size().area() + 3) * maze.size().area()).unwrap();
            let mut driver = SearchDriver::new(&mut mouse, max_states);
            while driver.advance_in(&maze) == Ok(true) {}
            let (result, stats) = (driver.decision().unwrap(), *driver.stats());
            prop_assert!(stats.steps() + 1 < max_states);
            let cell = maze.start().cell;
            if let Some(shortest) = Distances::flood(maze.walls(), maze.goals()).at(cell) {
                prop_assert_eq!((result, stats.fast_run.steps), (Ok(Move::Stop), shortest.into()));
            } else {
                prop_assert_eq!(mouse.pose().cell, cell);
                prop_assert_eq!(result, Err(SearchError::GoalUnreachable { cell }));
            }
        }
    }
}
