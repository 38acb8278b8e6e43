//! The shortest-path search, which explores until a known path is proven to be shortest.

use mmsim_maze::{Cell, CellSet, KnownMaze, Pose, Unknown};

use crate::flood::{KEEPS_DISTANCES, exploration_target};
use crate::proving_search::{DownhillPlan, Objective, ProvingSearch};
use crate::strategy::{Move, Phase, SearchError, Strategy, forward_strategy};

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
pub struct ShortestPathSearch(ProvingSearch<FewestSteps>);

impl ShortestPathSearch {
    /// Creates the strategy in its initial state.
    pub const fn new() -> Self {
        Self(ProvingSearch::new(FewestSteps { paths: CellSet::EMPTY }))
    }
}

impl Default for ShortestPathSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for ShortestPathSearch {
    forward_strategy!(self => self.0);
}

/// The objective to run to the goal in the fewest steps.
#[derive(Clone, Debug)]
struct FewestSteps {
    /// The cells on the optimistic shortest paths when the target was selected.
    paths: CellSet,
}

impl Objective for FewestSteps {
    const OVERWRITES_DISTANCES: bool = !KEEPS_DISTANCES;

    /// Walls elsewhere do not change the shortest paths.
    fn may_change_target(&self, cell: Cell) -> bool {
        self.paths.contains(cell)
    }

    fn next_target(
        &mut self,
        map: &KnownMaze,
        cell: Cell,
        DownhillPlan { distances, memory }: &mut DownhillPlan,
    ) -> Option<Cell> {
        exploration_target(map, cell, &mut self.paths, memory, distances)
    }

    fn preferences(&self, _: &KnownMaze, _: Cell) -> [u8; 4] {
        [0; 4]
    }

    fn plan_fast_run(&mut self, map: &KnownMaze, plan: &mut DownhillPlan) {
        plan.flood(map.walls(Unknown::Closed), map.goals());
    }

    fn fast_move(&mut self, map: &KnownMaze, pose: Pose, plan: &DownhillPlan) -> Option<Move> {
        if map.goals().contains(pose.cell) {
            return Some(Move::Stop);
        }
        plan.step(map, pose, [0; 4]).map(Move::Step)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::Distances;
    use crate::driver::SearchDriver;
    use crate::mouse::Mouse;
    use crate::tests::{Outcome, random_mazes, search};

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
