//! Runs a search in memory.

use std::convert::Infallible;
use std::fmt;
use std::time::Duration;

use mmsim_maze::WallState::Present;
use mmsim_maze::{KnownMaze, Maze, Misreadings, Pose, Unknown, WallSensor};
use mmsim_solvers::{
    DriveError, Mouse, Move, PathBounds, Phase, SearchDriver, SearchError, Strategy, WallVotes,
    steps_between, steps_until_proven,
};

use crate::cause::{Cause, EndFacts, Evidence};
use crate::figures::{SearchFigures, SearchOutcome};
use crate::judge::Judge;
use crate::verdict::{Ending, Verdict};

/// How a strategy reads walls. By default, all readings are right.
#[derive(Clone, Copy, Debug, Default)]
pub struct Senses {
    /// The wrong readings.
    pub misreadings: Misreadings,
    /// True if the mouse [recovers](SearchDriver::recovering) from wrong readings.
    pub recovers: bool,
}

impl fmt::Display for Senses {
    /// Writes a sentence about the wrong readings.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Misreadings { probability, seed, are_fixed } = self.misreadings;
        let kind = if are_fixed { "always the same walls" } else { "each reading anew" };
        let recovers = if self.recovers { "; strategies recover" } else { "" };
        // Rounded, because 0.07 times 100 is a little more than 7.
        let percent = (probability * 1e10).round() / 1e8;
        write!(
            f,
            "Walls are misread with a probability of {percent} % (seed {seed}, {kind}){recovers}."
        )
    }
}

/// Searches the maze until the strategy stops or has made `max_states` decisions, and returns the
/// figures. `clock` returns the processor time so far; the time of the search covers creating the
/// strategy, the search run and the return run. Returns `None` if `is_cancelled` returns true.
///
/// A strategy knows when its fast run begins, so its figures come from the [`SearchDriver`]. If it
/// misreads walls, they come from its poses and the true walls, like those of other mice (see
/// [`Judge`]).
///
/// ```
/// use std::time::Duration;
/// use mmsim_maze::Maze;
/// use mmsim_run::{Senses, search};
/// use mmsim_solvers::FloodFill;
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let senses = Senses::default();
/// let figures = search(&maze, FloodFill::new, 100, senses, || Duration::ZERO, || false);
/// assert_eq!(figures.expect("not cancelled").steps_to_goal, Some(1));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn search<S: Strategy>(
    maze: &Maze,
    strategy: impl FnOnce() -> S,
    max_states: u32,
    senses: Senses,
    clock: impl Fn() -> Duration,
    is_cancelled: impl Fn() -> bool,
) -> Option<SearchFigures> {
    let begin = clock();
    let mut mouse = Mouse::new(strategy(), KnownMaze::unexplored(maze), maze.start());
    let mut sensor = WallSensor::new(senses.misreadings, maze);
    let mut votes = (senses.recovers && !sensor.is_exact()).then(WallVotes::new);
    let mut driver = SearchDriver::new(&mut mouse, max_states).recovering(votes.as_mut());
    let mut judge = (!sensor.is_exact()).then(|| Judge::new(maze));
    let mut at = maze.start().cell;
    let mut advance = |driver: &mut SearchDriver<'_, S>| {
        let advanced = driver.advance_unless_blocked(|pose| {
            let around = sensor.around_from(maze.walls(), &mut at, pose);
            match (&mut judge, around) {
                (Some(judge), Some(_)) => judge.read_walls(pose),
                (Some(judge), None) => judge.crash(),
                (None, _) => {}
            }
            Ok::<_, Infallible>(around)
        });
        if let (Some(judge), Ok(true)) = (&mut judge, &advanced) {
            judge.add(driver.mouse().pose(), false);
            judge.believe(true, |cell, side| driver.mouse().map().wall(cell, side) == Present);
        }
        advanced
    };
    let (mut poses, mut advanced, mut touches_to_goal) = (Vec::new(), Ok(true), 0);
    while advanced == Ok(true) && driver.phase() != Phase::FastRun {
        if is_cancelled() {
            return None;
        }
        advanced = advance(&mut driver);
        poses.extend((advanced == Ok(true)).then(|| driver.mouse().pose()));
        if !driver.stats().goal_reached() {
            touches_to_goal = driver.stats().crashes;
        }
    }
    let time = clock().saturating_sub(begin);
    let path_found = PathBounds::new(driver.mouse().map()).pessimistic;
    let known_walls = driver.mouse().map().walls(Unknown::Closed).clone();
    let (last_cell, touches) = (driver.mouse().pose().cell, driver.stats().crashes);
    let mut route = vec![last_cell];
    while advanced == Ok(true) {
        if is_cancelled() {
            return None;
        }
        advanced = advance(&mut driver);
        route.extend((advanced == Ok(true)).then(|| driver.mouse().pose().cell));
    }
    let (stats, error) = (driver.stats(), advanced.err());
    let shortest_path = steps_between(maze.walls(), maze.start().cell, maze.goals());
    let reports_unreachable = matches!(
        error,
        Some(DriveError::Search(SearchError::GoalUnreachable { .. } | SearchError::BoxedIn { .. }))
    );
    let is_in_goal = maze.goals().contains(driver.mouse().pose().cell);
    let has_fast_run = driver.phase() == Phase::FastRun && is_in_goal;
    let has_stopped = driver.decision() == Some(Ok(Move::Stop));
    let ending = ending(error.as_ref(), has_stopped);
    let error = error.as_ref().map(ToString::to_string);
    let is_rightly_given_up = shortest_path.is_none() && reports_unreachable;
    let may_fail = !stats.goal_reached() && !is_rightly_given_up;
    let cause = if may_fail { cause(maze, &poses, judge.as_ref(), ending) } else { None };
    let verdict = Verdict::from_goal(stats.goal_reached(), ending, error, cause);
    let ending = verdict.ending;
    let processor_time_us = Some((time.as_secs_f64() * 1e9).round() / 1e3);
    if let Some(judged) = judge.as_mut().map(Judge::figures) {
        let is_complete = judged.is_complete || ending == Ending::Finished;
        let figures =
            SearchFigures { processor_time_us, is_rightly_given_up, is_complete, ..judged };
        return Some(figures.with_verdict(verdict));
    }
    let count = u32::try_from(poses.len() + route.len() - 1).unwrap_or(u32::MAX);
    let figures = SearchFigures {
        steps_to_goal: stats.steps_to_goal,
        steps_until_proven: steps_until_proven(maze, &poses),
        search_steps: stats.exploration().steps,
        search_turns: stats.exploration().turns,
        path_found,
        shortest_path,
        visited_cells: driver.mouse().map().visited().len(),
        states: count,
        processor_time_us,
        fast_run_steps: has_fast_run.then_some(stats.fast_run.steps),
        crashes: Some(stats.crashes),
        is_complete: ending != Ending::StepLimit || driver.phase() == Phase::FastRun,
        is_rightly_given_up,
        path: poses.iter().map(|pose| pose.cell).collect(),
        outcome: SearchOutcome {
            known_walls: Some(known_walls),
            last_cell: Some(last_cell),
            driven: None,
            route: if has_fast_run && ending == Ending::Finished { route } else { Vec::new() },
            turns_to_goal: stats.steps_to_goal.map_or(0, |_| stats.search_run.turns),
            touches,
            touches_to_goal,
        },
        ..SearchFigures::default()
    };
    Some(figures.with_verdict(verdict))
}

/// Returns how the search of a strategy ended that returned this error, or stopped, or did neither.
const fn ending<E>(error: Option<&DriveError<E>>, has_stopped: bool) -> Ending {
    match error {
        Some(DriveError::Search(_)) => Ending::GaveUp,
        Some(_) => Ending::Failed,
        None if has_stopped => Ending::Finished,
        None => Ending::StepLimit,
    }
}

/// Returns the cause that a strategy has not reached the goal. If the strategy misreads walls, a judge has
/// seen its states.
fn cause(maze: &Maze, poses: &[Pose], judge: Option<&Judge>, ending: Ending) -> Option<Cause> {
    let facts = EndFacts { ending, ..EndFacts::default() };
    match judge {
        Some(judge) => judge.cause(&facts),
        None => Evidence::from_poses(maze, poses).cause(maze, &facts),
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Step;
    use mmsim_solvers::{FloodFill, LeftWall, Move, Swing};

    use super::*;

    fn figures(strategy: impl Strategy, drawing: &str, max_states: u32) -> SearchFigures {
        let maze: Maze = drawing.parse().unwrap();
        let figures = super::search(
            &maze,
            || strategy,
            max_states,
            Senses::default(),
            || Duration::ZERO,
            || false,
        )
        .unwrap();
        let (path, outcome) = (Vec::new(), SearchOutcome::default());
        SearchFigures {
            processor_time_us: None,
            visited_cells: 0,
            states: 0,
            path,
            outcome,
            is_complete: false,
            ..figures
        }
    }

    const CLOSED: &str = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";

    #[test]
    fn steps_and_turns_are_counted() {
        let maze = "\
o---o---o---o
|       | G |
o   o   o   o
|   |   |   |
o   o---o   o
| S |       |
o   o   o   o
|           |
o---o---o---o
";
        // The mouse takes four steps into the dead end with two right turns. It takes four steps
        // back with a U-turn, a right turn and a left turn, then six steps with two left turns. In
        // the cell before the goal it sees the open side of the goal.
        let expected = SearchFigures {
            goal_reached: true,
            steps_to_goal: Some(14),
            steps_until_proven: Some(13),
            search_steps: 14,
            search_turns: 2 + 4 + 2,
            path_found: Some(6),
            shortest_path: Some(6),
            crashes: Some(0),
            ..SearchFigures::default()
        };
        assert_eq!(figures(FloodFill::new(), maze, 1000), expected);
        assert_eq!(figures(FloodFill::new(), maze, 15), expected, "one state more than steps");
        let expected = SearchFigures {
            goal_reached: false,
            steps_to_goal: None,
            search_steps: 13,
            ..expected
        };
        let expected = SearchFigures { ending: Ending::StepLimit, ..expected };
        assert_eq!(
            figures(FloodFill::new(), maze, 14),
            expected,
            "the path is known, although the goal was not reached"
        );
    }

    #[test]
    fn a_fast_run_does_not_count() {
        let maze = "\
o---o---o---o
|           |
o   o---o   o
|   | G     |
o   o---o   o
| S |       |
o---o---o---o
";
        // The mouse visits the goal, the south-east corner, the goal again and the start. Then the
        // fast run leads to the goal.
        let expected = SearchFigures {
            goal_reached: true,
            steps_to_goal: Some(6),
            steps_until_proven: Some(5),
            search_steps: 6 + 2 + 2 + 6,
            search_turns: 3 + 3 + 3 + 5,
            path_found: Some(6),
            shortest_path: Some(6),
            fast_run_steps: Some(6),
            crashes: Some(0),
            ..SearchFigures::default()
        };
        assert_eq!(figures(Swing::new(), maze, 1000), expected);
    }

    #[test]
    fn a_path_that_may_be_too_long_is_not_proven() {
        let maze = "\
o---o---o
|       |
o   o   o
| S | G |
o---o---o
";
        let expected = SearchFigures {
            goal_reached: true,
            steps_to_goal: Some(3),
            steps_until_proven: Some(2),
            search_steps: 3,
            search_turns: 2,
            path_found: Some(3),
            shortest_path: Some(3),
            crashes: Some(0),
            ..SearchFigures::default()
        };
        assert_eq!(figures(FloodFill::new(), maze, 1000), expected);
        // A mouse that follows the left wall does not see the path through the middle.
        let maze = "\
o---o---o---o
|           |
o   o---o   o
|   |   | G |
o   o   o   o
|           |
o   o---o   o
| S |       |
o---o---o---o
";
        let expected = SearchFigures {
            goal_reached: true,
            steps_to_goal: Some(6),
            steps_until_proven: None,
            search_steps: 6,
            search_turns: 2,
            path_found: Some(6),
            shortest_path: Some(4),
            crashes: Some(0),
            ..SearchFigures::default()
        };
        assert_eq!(figures(LeftWall::new(), maze, 1000), expected);
    }

    #[test]
    fn giving_up_is_right_only_with_a_report_of_an_unreachable_goal() {
        let expected = SearchFigures {
            goal_reached: false,
            steps_to_goal: None,
            steps_until_proven: None,
            search_steps: 3,
            search_turns: 3,
            path_found: None,
            shortest_path: None,
            is_rightly_given_up: true,
            ending: Ending::GaveUp,
            error: Some("goal unreachable from (1, 0)".into()),
            crashes: Some(0),
            ..SearchFigures::default()
        };
        assert_eq!(figures(FloodFill::new(), CLOSED, 1000), expected);
        let endless = figures(LeftWall::new(), CLOSED, 100);
        let error = endless.failure().unwrap();
        assert_eq!(endless.search_steps, 99);
        insta::assert_snapshot!(error, @"loops over 3 cells, (0, 1) to (1, 0), since state 1");
        assert!(!endless.is_rightly_given_up);
    }

    /// A strategy that steps forward until it reaches the goal. The fast run of this strategy
    /// begins with the second state.
    #[derive(Default)]
    struct Straight {
        states: u32,
    }

    impl Strategy for Straight {
        fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
            self.states += 1;
            let is_done = map.goals().contains(pose.cell);
            Ok(if is_done { Move::Stop } else { Move::Step(Step::Front) })
        }

        fn phase(&self) -> Phase {
            if self.states >= 2 { Phase::FastRun } else { Phase::SearchRun }
        }
    }

    #[test]
    fn the_goal_may_be_reached_on_the_fast_run() {
        let maze = "o---o\n| G |\no   o\n|   |\no   o\n|   |\no   o\n| S |\no---o\n";
        let SearchFigures { steps_to_goal, search_steps, path_found, .. } =
            figures(Straight::default(), maze, 1000);
        assert_eq!((steps_to_goal, search_steps, path_found), (Some(3), 1, None));
    }

    #[test]
    fn the_probability_of_a_wrong_reading_is_rounded() {
        let misreadings = Misreadings { probability: 0.07, seed: 1, are_fixed: false };
        let text = Senses { misreadings, recovers: false }.to_string();
        assert!(text.contains(" 7 % (seed 1, each reading anew)"), "{text}");
    }

    #[test]
    fn a_crash_ends_the_search() {
        let SearchFigures { search_steps, error, .. } = figures(Straight::default(), CLOSED, 1000);
        assert_eq!(search_steps, 1);
        insta::assert_snapshot!(error.unwrap(), @"cannot leave (0, 1) to the north: there is a wall");
    }
}
