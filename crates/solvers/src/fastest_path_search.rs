//! The fastest-path search, which explores until the fastest run is proven.

use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, Step, Unknown};

use crate::flood::{Distances, only};
use crate::proving_search::{DownhillPlan, Objective, ProvingSearch};
use crate::strategy::{Move, Phase, SearchError, Strategy, forward_strategy};
use sampled_runs::SampledRuns;
pub use time_bounds::{InvalidTolerance, TimeBounds, Tolerance};
use time_bounds::{RunBounds, fastest_known_route};

mod sampled_runs;
mod time_bounds;

/// A strategy that goes to the goal, explores until no unknown wall can hide a faster run, returns
/// to the start, and drives the fastest run. Times are those of a [`Vehicle`], so the fastest run is
/// often not the shortest.
///
/// - The mouse goes to the goal as in [`ShortestPathSearch`](crate::ShortestPathSearch).
/// - The optimistic run is the fastest run with all unknown walls open. Its time is a lower bound on
///   the time of every run. The fastest run that crosses no unknown wall gives an upper bound. The
///   exploration ends when the bounds are equal, or as close as the tolerance allows.
/// - Until then, the mouse goes to the nearest cell in which it reads an unknown wall on the
///   optimistic run, or on the fastest run of a sampled maze. Sampled mazes agree with all known
///   walls, and their other walls are random, but the same in each search. Walls that many of these
///   runs cross are likely to matter later, so the mouse reads them while it is nearby.
/// - On the return run, the mouse tries a path through unknown walls if that path may be shorter
///   than the shortest known path.
///
/// The weight of a cell is its distance in steps to the mouse's current target, and on the fast run
/// to the end of the run. If the goal is unreachable, the mouse returns to the start before the
/// strategy returns an error.
///
/// ```
/// use mmsim_fastrun::{Vehicle, fastest};
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_solvers::{FastestPathSearch, Mouse, SearchDriver};
///
/// let maze: Maze = "\
/// o---o---o---o
/// |         G |
/// o   o---o   o
/// | S         |
/// o---o---o---o
/// ".parse()?;
/// let search = FastestPathSearch::new(Vehicle::ares(), "3%".parse()?);
/// let mut mouse = Mouse::new(search, KnownMaze::unexplored(&maze), maze.start());
/// let mut driver = SearchDriver::new(&mut mouse, 1000);
/// while driver.advance_in(&maze)? {}
/// let optimal = fastest(maze.walls(), maze.start().cell, maze.goals(), &Vehicle::ares())?;
/// let bounds = mouse.strategy().bounds();
/// assert!(bounds.loss().unwrap() <= 0.03);
/// assert!(bounds.pessimistic.unwrap() <= 1.03 * optimal.time(&Vehicle::ares())?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FastestPathSearch(ProvingSearch<LeastTime>);

impl FastestPathSearch {
    /// Creates the strategy in its initial state. The mouse stops exploring when the best known run
    /// is proven to be within the tolerance of the fastest run.
    pub fn new(vehicle: Vehicle, tolerance: Tolerance) -> Self {
        Self::with_planner(Planner::new(vehicle), tolerance)
    }

    /// Creates the strategy with the tables of a planner. This is faster than [`new`](Self::new) if
    /// a program creates several strategies for the same vehicle.
    pub fn with_planner(planner: Planner, tolerance: Tolerance) -> Self {
        let objective = LeastTime { planner: Some(planner), tolerance, ..LeastTime::default() };
        Self(ProvingSearch::new(objective))
    }

    /// Returns the bounds on the time of the fastest run. The mouse computes them while it explores,
    /// so both are `None` before it has reached the goal.
    pub fn bounds(&self) -> TimeBounds {
        self.0.objective.bounds.times()
    }
}

/// Creates the strategy for the [default vehicle](Vehicle::default_for) of the maze, without tolerance.
impl Default for FastestPathSearch {
    fn default() -> Self {
        Self(ProvingSearch::new(LeastTime::default()))
    }
}

impl Strategy for FastestPathSearch {
    forward_strategy!(self => self.0);
}

/// The objective to run to the goal in the least time.
#[derive(Clone, Debug, Default)]
struct LeastTime {
    /// The planner, or `None` for that of the default vehicle until the size of the maze is known.
    planner: Option<Planner>,
    tolerance: Tolerance,
    bounds: RunBounds,
    samples: SampledRuns,
    /// The cells of the fast run after the mouse's cell, the last one first.
    route: Vec<Cell>,
}

/// The mouse prefers a cell on the optimistic run to a cell on the fastest runs of few sampled mazes,
/// even if the first cell is up to this many steps farther away.
const DETOUR: i32 = 4;

/// The mouse prefers a cell that is more than this many steps farther from the start, even if the
/// cell is one step farther away. It can visit the other cells on its way back.
const STEPS_FROM_START: i32 = 8;

/// Returns a planner, and creates one for the default vehicle if there is none.
fn for_size(planner: &mut Option<Planner>, size: MazeSize) -> &mut Planner {
    planner.get_or_insert_with(|| Planner::new(Vehicle::default_for(size)))
}

impl Objective for LeastTime {
    /// Every wall may change the run in a sampled maze.
    fn may_change_target(&self, _: Cell) -> bool {
        true
    }

    fn next_target(&mut self, map: &KnownMaze, mouse: Cell, _: &mut DownhillPlan) -> Option<Cell> {
        let planner = for_size(&mut self.planner, map.size());
        self.bounds.update(planner, map);
        if self.bounds.times().are_within(self.tolerance) {
            return None;
        }
        let optimistic = self.bounds.optimistic.as_ref()?.cells_beside_unknown_walls(map);
        self.samples.update(planner, map);
        let (runs, counts) = self.samples.count(map);
        let open = map.walls(Unknown::Open);
        let from_mouse = Distances::flood(open, &only(mouse));
        let from_start = Distances::flood(open, &only(map.start().cell));
        // In steps, multiplied by both divisors.
        let cost = |cell: Cell| {
            let steps = i32::from(from_mouse.at(cell)?);
            let home = i32::from(from_start.at(cell)?);
            let others = if optimistic.contains(cell) { 0 } else { runs - i32::from(counts[cell]) };
            let detour = DETOUR * others;
            Some((
                runs.max(1) * (STEPS_FROM_START * steps - home) + STEPS_FROM_START * detour,
                steps,
            ))
        };
        let counted: CellSet = map.size().cells().filter(|&cell| counts[cell] > 0).collect();
        let candidates = (optimistic | counted) - *map.visited();
        let costs = candidates.iter().filter_map(|cell| Some((cost(cell)?, cell)));
        costs.min_by_key(|&(cost, _)| cost).map(|(_, cell)| cell)
    }

    fn preferences(&self, map: &KnownMaze, cell: Cell) -> [u8; 4] {
        let is_visited = |heading| {
            let next = cell.neighbour(heading);
            u8::from(next.is_some_and(|next| map.visited().contains(next)))
        };
        Heading::ALL.map(is_visited)
    }

    fn plan_fast_run(&mut self, map: &KnownMaze, plan: &mut DownhillPlan) {
        let planner = for_size(&mut self.planner, map.size());
        self.bounds.update(planner, map);
        self.route = fastest_known_route(planner, map).unwrap_or_default();
        if let Some(&end) = self.route.last() {
            plan.flood_from(map.walls(Unknown::Closed), end);
        }
        self.route.reverse();
        self.route.pop();
    }

    fn reconsider(&mut self) {
        (self.bounds, self.samples) = (RunBounds::default(), SampledRuns::default());
    }

    fn fast_move(&mut self, _: &KnownMaze, pose: Pose, _: &DownhillPlan) -> Option<Move> {
        let Some(next) = self.route.pop() else { return Some(Move::Stop) };
        let leads_there = |step: &Step| pose.after(*step).is_some_and(|to| to.cell == next);
        Step::ALL.into_iter().find(leads_there).map(Move::Step)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::fastest;
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::driver::SearchDriver;
    use crate::mouse::Mouse;
    use crate::stats::SearchStats;
    use crate::tests::{Outcome, random_mazes, search};

    #[test]
    fn proves_the_fastest_run_and_drives_it() {
        let maze = "\
o---o---o---o---o
|               |
o   o   o   o   o
|   | G |   |   |
o   o   o   o   o
|               |
o   o---o---o---o
| S |           |
o---o---o---o---o
";
        let outcome = search(FastestPathSearch::default(), maze, 1000);
        assert_eq!(outcome.result, Ok(Move::Stop));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o---o
        | 2   1   2 .   |
        o   o   o . o . o
        | 3 | ^ |   .   |
        o   o   o . o . o
        | 2   1   2 .   |
        o   o---o . o . o
        | 3 |   .   .   |
        o---o---o---o---o
        ");
    }

    #[test]
    fn the_fastest_run_depends_on_the_vehicle() {
        let maze = "\
o---o---o---o---o
|             G |
o   o   o   o---o
|               |
o   o   o   o   o
|               |
o   o   o   o   o
| S             |
o---o---o---o---o
"
        .parse()
        .unwrap();
        // The slow mouse avoids turns, the fast one drives along the diagonal. At the start, both make
        // a half turn.
        for (vehicle, turns) in [(Vehicle::ukmars(), 3), (Vehicle::expert(), 7)] {
            let (_, result, stats) =
                explore(&maze, FastestPathSearch::new(vehicle, Tolerance::ZERO));
            assert_eq!(result, Ok(Move::Stop));
            assert_eq!((stats.fast_run.steps, stats.fast_run.turns), (6, turns));
        }
    }

    #[test]
    fn reports_an_unreachable_goal_at_the_start() {
        let unreachable = Err(SearchError::GoalUnreachable { cell: Cell::new(0, 0) });
        let maze = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        let Outcome { result, steps, .. } = search(FastestPathSearch::default(), maze, 1000);
        assert_eq!((result, steps), (unreachable, 4));
    }

    #[test]
    fn stops_if_the_start_is_a_goal() {
        for maze in ["o---o\n|SG |\no---o\n", "o---o---o\n| G |SG |\no---o---o\n"] {
            let Outcome { result, steps, .. } = search(FastestPathSearch::default(), maze, 1000);
            assert_eq!((result, steps), (Ok(Move::Stop), 0));
        }
    }

    /// Searches a maze. Returns the mouse at the beginning of its fast run or after its failure, the
    /// result and the steps.
    fn explore(
        maze: &Maze,
        strategy: FastestPathSearch,
    ) -> (Mouse<FastestPathSearch>, Result<Move, SearchError>, SearchStats) {
        let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(maze), maze.start());
        // The strategy plans again only in unvisited cells.
        let area = maze.size().area();
        let max_states = u32::try_from((area + 3) * area).unwrap();
        let mut driver = SearchDriver::new(&mut mouse, max_states);
        let mut explored = None;
        while driver.advance_in(maze) == Ok(true) {
            if driver.phase() == Phase::FastRun && explored.is_none() {
                explored = Some(driver.mouse().clone());
            }
        }
        let (result, stats) = (driver.decision().unwrap(), *driver.stats());
        assert!(stats.steps() + 1 < max_states);
        (explored.unwrap_or(mouse), result, stats)
    }

    proptest! {
        #[test]
        fn proves_the_fastest_run_or_reports_an_unreachable_goal(
            maze in random_mazes(16),
            preset in prop::sample::select(&Vehicle::PRESETS[..]),
            tolerance in prop_oneof![Just(0.0), 0.0..0.5],
        ) {
            let vehicle = Vehicle::preset(preset).unwrap();
            let strategy = FastestPathSearch::new(vehicle.clone(), Tolerance::new(tolerance).unwrap());
            let (mouse, result, stats) = explore(&maze, strategy);
            let cell = maze.start().cell;
            if let Ok(optimal) = fastest(maze.walls(), cell, maze.goals(), &vehicle) {
                let optimal = optimal.time(&vehicle).unwrap();
                let known = mouse.map().walls(Unknown::Closed);
                let known = fastest(known, cell, maze.goals(), &vehicle).unwrap();
                let time = known.time(&vehicle).unwrap();
                let bounds = mouse.strategy().bounds();
                let (lower, upper) = (bounds.optimistic.unwrap(), bounds.pessimistic.unwrap());
                prop_assert!((upper - time).abs() < 1e-5);
                prop_assert!(lower < optimal + 1e-5 && optimal < upper + 1e-5);
                prop_assert!(upper < (1.0 + tolerance) * lower + 1e-5);
                prop_assert_eq!(result, Ok(Move::Stop));
                prop_assert_eq!(stats.fast_run.steps as usize, known.cells().len() - 1);
            } else {
                prop_assert_eq!(mouse.pose().cell, cell);
                prop_assert_eq!(result, Err(SearchError::GoalUnreachable { cell }));
            }
        }
    }
}
