//! Runs a search with a strategy against a simulator.

use std::ops::ControlFlow;

use mmsim_maze::{Cell, Contradiction, Heading, MazeSize};
use mmsim_protocol::{BufferTooSmall, Excerpt, RequestError, UnknownReply};
use mmsim_solvers::{
    Crash, DriveError, Mouse, Move, SearchDriver, SearchError, SearchStats, Strategy,
};

use crate::exchange::Exchange;
use crate::transport::{Transport, TransportError};

/// The value sent for a cell without a weight.
const NO_WEIGHT: u16 = u16::MAX;

/// The results of a search run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SearchRun {
    /// The steps and turns of the mouse.
    pub stats: SearchStats,
    /// The number of states sent: one at the start and one after each step.
    pub states: u32,
    /// The number of requests sent.
    pub requests: u32,
    /// True if the search ended at its limit of states.
    pub is_at_limit: bool,
}

/// The reason why a search run failed. The mouse keeps its map after a failure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The request could not be sent, or no reply arrived.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The simulator refused a request.
    #[error("the simulator refused {request}: {reason}")]
    Refused {
        /// The name of the request.
        request: &'static str,
        /// The simulator's error message.
        reason: String,
    },
    /// The simulator sent a reply that the protocol does not define.
    #[error(transparent)]
    UnknownReply(#[from] UnknownReply),
    /// The reply belongs to a different kind of request.
    #[error("expected the reply to {request}, found {found}")]
    WrongReply {
        /// The name of the request.
        request: &'static str,
        /// The reply.
        found: Excerpt<16>,
    },
    /// The reply to `info` is not the expected JSON object.
    #[error("invalid reply to info: {0}")]
    Info(#[from] serde_json::Error),
    /// A reply contradicts an earlier reply.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// A wall is missing at the edge of the expected maze, so the actual maze is larger.
    #[error("expected a maze of {size} cells, found no wall on the {heading} side of {cell}")]
    LargerMaze {
        /// The expected size.
        size: MazeSize,
        /// The cell at the edge of the expected maze.
        cell: Cell,
        /// The side of `cell` that has no wall.
        heading: Heading,
    },
    /// The strategy cannot continue.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// The strategy chose a step through a side that is not known to be open.
    #[error(transparent)]
    Crash(#[from] Crash),
    /// An annotation is invalid.
    #[error(transparent)]
    Annotation(#[from] RequestError),
    /// A request does not fit into its buffer.
    #[error(transparent)]
    Buffer(#[from] BufferTooSmall),
}

impl RunError {
    /// Converts a contradiction in the simulator's replies to an error. A contradiction at the edge
    /// of the expected maze means that the maze is larger than expected.
    pub fn from_contradiction(error: Contradiction, size: MazeSize) -> Self {
        let Contradiction { cell, heading, .. } = error;
        match size.neighbour(cell, heading) {
            Some(_) => error.into(),
            None => Self::LargerMaze { size, cell, heading },
        }
    }

    /// Returns true if the strategy has given up, so neither the simulator nor the mouse is at fault.
    pub const fn is_given_up(&self) -> bool {
        matches!(self, Self::Search(_))
    }

    fn from_drive_error(error: DriveError<Self>, size: MazeSize) -> Self {
        match error {
            DriveError::Sensor(error) => error,
            DriveError::Contradiction(error) => Self::from_contradiction(error, size),
            DriveError::Search(error) => error.into(),
            DriveError::Crash(error) => error.into(),
        }
    }
}

/// A search run that failed.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct BrokenRun {
    /// The results of the search up to the failure.
    pub run: SearchRun,
    /// The cause.
    #[source]
    pub error: RunError,
}

/// Runs a search, beginning with a `reset`. In each cell, the search requests the walls, lets the
/// mouse choose a step, sends the state, and takes the step. If the wall behind the mouse is
/// unknown at the start, the search first requests the walls around a mouse that faces the opposite
/// way.
///
/// The search ends when the strategy stops, or after `max_states` states. After each state,
/// `observe` is called with the mouse and the current results; [`ControlFlow::Break`] ends the
/// search.
///
/// # Errors
/// Returns an error if the simulator does not reply or refuses a request, or if the strategy cannot
/// continue. The last state is sent before a strategy error is returned.
pub fn search_run<S: Strategy>(
    transport: &mut impl Transport,
    mouse: &mut Mouse<S>,
    max_states: u32,
    observe: impl FnMut(&Mouse<S>, &SearchRun) -> ControlFlow<()>,
) -> Result<SearchRun, BrokenRun> {
    search_run_with(transport, SearchDriver::new(mouse, max_states), observe)
}

/// Runs a search like [`search_run`] with a driver, which may
/// [recover](SearchDriver::recovering) from wrong readings.
///
/// # Errors
/// Returns the same errors as [`search_run`].
pub fn search_run_with<S: Strategy>(
    transport: &mut impl Transport,
    driver: SearchDriver<'_, S>,
    observe: impl FnMut(&Mouse<S>, &SearchRun) -> ControlFlow<()>,
) -> Result<SearchRun, BrokenRun> {
    let (mut exchange, mut run) = (Exchange::new(transport), SearchRun::default());
    let result = drive(&mut exchange, driver, observe, &mut run);
    run.requests = exchange.requests();
    result.map(|()| run).map_err(|error| BrokenRun { run, error })
}

fn drive<S: Strategy>(
    exchange: &mut Exchange<impl Transport>,
    mut driver: SearchDriver<'_, S>,
    mut observe: impl FnMut(&Mouse<S>, &SearchRun) -> ControlFlow<()>,
    run: &mut SearchRun,
) -> Result<(), RunError> {
    exchange.reset()?;
    let size = driver.mouse().map().size();
    loop {
        let at = driver.mouse().pose().cell;
        let advanced = driver.advance_unless_blocked(|pose| {
            if pose.cell == at {
                exchange.walls(pose).map(Some)
            } else {
                exchange.walls_unless_blocked(pose)
            }
        });
        run.stats = *driver.stats();
        if !advanced.map_err(|error| RunError::from_drive_error(error, size))? {
            run.is_at_limit = driver.decision() != Some(Ok(Move::Stop));
            return Ok(());
        }
        let mouse = driver.mouse();
        exchange
            .state(mouse.pose(), mouse.map(), |cell| mouse.weight(cell).unwrap_or(NO_WEIGHT))?;
        run.states += 1;
        run.requests = exchange.requests();
        if observe(mouse, run).is_break() {
            return driver.decision().transpose().map(|_| ()).map_err(RunError::from);
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_server::Simulation;
    use mmsim_solvers::{BundledStrategy, FloodFill};

    use super::*;
    use crate::transport::InMemory;

    const MAZE: &str = "\
o---o---o---o
|   |     G |
o   o   o---o
|       |   |
o   o---o   o
| S |       |
o---o---o---o
";

    /// Runs a search in memory; `change` may corrupt a reply.
    fn run(
        map: KnownMaze,
        max_states: u32,
        mut change: impl FnMut(&[u8], &mut Vec<u8>),
    ) -> (Result<SearchRun, BrokenRun>, Simulation) {
        let maze: Maze = MAZE.parse().unwrap();
        let start = maze.start();
        let mut simulation = Simulation::new("small", maze);
        let mut mouse = Mouse::new(FloodFill::new(), map, start);
        let mut transport = InMemory::new(|request, reply| {
            simulation.handle(request, reply);
            change(request, reply);
        });
        let result =
            search_run(&mut transport, &mut mouse, max_states, |_, _| ControlFlow::Continue(()));
        (result, simulation)
    }

    /// Returns whether the goal was reached, and the numbers of steps, states and requests.
    fn figures(run: &SearchRun) -> (bool, u32, u32, u32) {
        (run.stats.goal_reached(), run.stats.steps(), run.states, run.requests)
    }

    fn known() -> KnownMaze {
        KnownMaze::unexplored(&MAZE.parse().unwrap())
    }

    #[test]
    fn counts_steps_states_and_requests() {
        for (limit, expected) in
            [(1000, (true, 6, 7, 15)), (7, (true, 6, 7, 15)), (3, (false, 2, 3, 7))]
        {
            let (result, simulation) = run(known(), limit, |_, _| {});
            let run = result.unwrap();
            assert_eq!(figures(&run), expected);
            assert_eq!(simulation.history().len(), run.states as usize);
            assert_eq!(run.is_at_limit, limit == 3);
        }
    }

    #[test]
    fn a_crash_before_the_first_step_is_a_refusal() {
        let (result, _) = run(known(), 1000, |request, reply| {
            if request.starts_with(b"W") {
                *reply = b"error: crash: no".to_vec();
            }
        });
        let BrokenRun { run, error } = result.unwrap_err();
        assert_eq!((run.stats, run.states), (SearchStats::default(), 0));
        assert_eq!(error.to_string(), "the simulator refused W: crash: no");
    }

    #[test]
    fn the_observer_can_end_the_run() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut mouse = Mouse::new(FloodFill::new(), known(), maze.start());
        let mut simulation = Simulation::new("small", maze);
        let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
        let run = search_run(&mut transport, &mut mouse, 1000, |_, run| {
            if run.stats.steps() < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let expected = (false, 2, 3, 7);
        assert_eq!(figures(&run.unwrap()), expected);
    }

    #[test]
    fn every_strategy_reaches_the_goal() {
        for &strategy in BundledStrategy::ALL {
            let maze: Maze = MAZE.parse().unwrap();
            let mut mouse =
                Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), maze.start());
            let mut simulation = Simulation::new("small", maze);
            let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
            let run =
                search_run(&mut transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(()))
                    .unwrap();
            assert!(run.stats.goal_reached(), "{strategy}");
        }
    }

    #[test]
    fn leaves_a_start_that_is_open_only_behind_the_mouse() {
        for &strategy in BundledStrategy::ALL {
            let maze: Maze = "o---o\n| S |\no   o\n| G |\no---o\n".parse().unwrap();
            let mut mouse =
                Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), maze.start());
            let mut simulation = Simulation::new("behind", maze);
            let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
            let observe = |_: &Mouse<_>, _: &_| ControlFlow::Continue(());
            let run = search_run(&mut transport, &mut mouse, 1000, observe).unwrap();
            // Some strategies return to the start before the fast run.
            let steps = match strategy {
                BundledStrategy::Swing
                | BundledStrategy::ShortestPathSearch
                | BundledStrategy::FastestPathSearch => 3,
                _ => 1,
            };
            let (states, requests) = (steps + 1, 2 * steps + 4);
            let expected = (true, steps, states, requests);
            assert_eq!(figures(&run), expected, "{strategy}");
        }
    }

    #[test]
    fn an_unreachable_goal_is_reported_after_the_last_state() {
        let goals = [Cell::new(0, 5)].into_iter().collect();
        let map = KnownMaze::new(known().size(), Cell::new(0, 0), goals);
        let (result, simulation) = run(map, 1000, |_, _| {});
        let BrokenRun { run, error } = result.unwrap_err();
        assert!(matches!(error, RunError::Search(SearchError::GoalUnreachable { .. })), "{error}");
        let expected = (false, 0, 1, 3);
        assert_eq!(figures(&run), expected);
        assert_eq!(simulation.history().len(), 1);
    }

    #[test]
    fn a_maze_of_another_size_is_reported() {
        let error_for = |width, height| {
            let size = MazeSize::new(width, height).unwrap();
            let goals = [Cell::new(2, 2)].into_iter().collect();
            run(KnownMaze::new(size, Cell::new(0, 0), goals), 1000, |_, _| {}).0.unwrap_err()
        };
        assert_eq!(
            error_for(3, 4).to_string(),
            "the simulator refused S: expected a state of 24 bytes for a maze of 3x3 cells, \
             found 30 bytes"
        );
        assert_eq!(
            error_for(3, 1).to_string(),
            "expected a maze of 3x1 cells, found no wall on the north side of (0, 0)"
        );
    }

    #[test]
    fn unexpected_replies_are_errors() {
        let error = |corrupted: &'static [u8], reply: &'static [u8]| {
            let change = move |request: &[u8], bytes: &mut Vec<u8>| {
                if request.starts_with(corrupted) {
                    *bytes = reply.to_vec();
                }
            };
            run(known(), 1000, change).0.unwrap_err().to_string()
        };
        assert_eq!(error(b"reset", b"error: no"), "the simulator refused reset: no");
        assert_eq!(error(b"W", b"error: \x1b[2J\n"), "the simulator refused W: \\u{1b}[2J\\n");
        let long = error(b"W", [b"error: ", &*b"x".repeat(700_000)].concat().leak());
        assert_eq!(long.trim_start_matches("the simulator refused W: ").len(), 500 + 21, "{long}");
        assert!(long.ends_with("xx… (of 700000 bytes)"), "{long}");
        assert_eq!(error(b"W", b"ok"), "expected the reply to W, found \"ok\"");
        assert_eq!(error(b"S", b"pong"), "expected the reply to S, found \"pong\"");
        assert!(error(b"S", b"").starts_with("expected pong, ok, "));
        assert_eq!(
            error(b"W\x00\x01", &[1, 0, 0]),
            "the east side of (0, 1) is known to have no wall, but a wall was observed"
        );
    }

    #[test]
    fn info_describes_the_maze() {
        let mut simulation = Simulation::new("small", MAZE.parse().unwrap());
        let transport = InMemory::new(|request, reply| simulation.handle(request, reply));
        let info = Exchange::new(transport).info().unwrap();
        assert_eq!((info.maze.as_str(), info.width, info.height), ("small", 3, 3));
    }
}
