//! The search run: what a client asks of a simulator, in which order.

use std::ops::ControlFlow;

use mmsim_maze::{Cell, Contradiction, Heading, MazeSize};
use mmsim_protocol::{BufferTooSmall, Excerpt, Info, UnknownReply};
use mmsim_solvers::{Crash, DriveError, Mouse, SearchDriver, SearchError, SearchStats, Strategy};

use crate::exchange::Exchange;
use crate::transport::{Transport, TransportError};

/// The weight that a state contains for a cell without one.
const NO_WEIGHT: u16 = u16::MAX;

/// The figures of a search run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SearchRun {
    /// Steps and turns of the mouse.
    pub stats: SearchStats,
    /// States sent, one for each cell the mouse came to: one more than steps.
    pub states: u32,
    /// Requests sent.
    pub requests: u32,
}

/// Why a search run broke off. What the mouse has learned until then it still knows.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// No reply.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The simulator refused a request.
    #[error("the simulator refused {request}: {reason}")]
    Refused {
        /// Which one.
        request: &'static str,
        /// What the simulator says.
        reason: String,
    },
    /// The reply is none of the protocol.
    #[error(transparent)]
    UnknownReply(#[from] UnknownReply),
    /// The reply is one to another request.
    #[error("expected the reply to {request}, found {found}")]
    WrongReply {
        /// To which request.
        request: &'static str,
        /// The reply.
        found: Excerpt<16>,
    },
    /// The reply to `info` is not as it should be.
    #[error("expected the reply to info to be its JSON object: {0}")]
    Info(#[from] serde_json::Error),
    /// The simulator contradicts what it said before.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// There is no wall where the mouse believes the maze to end.
    #[error("expected a maze of {size} cells, found no wall at the {heading} side of {cell}")]
    LargerMaze {
        /// The size the mouse was told.
        size: MazeSize,
        /// The cell at the edge.
        cell: Cell,
        /// The side of it without a wall.
        heading: Heading,
    },
    /// The strategy cannot go on.
    #[error(transparent)]
    Search(#[from] SearchError),
    /// The strategy would drive the mouse into a wall.
    #[error(transparent)]
    Crash(#[from] Crash),
    /// A request longer than any of the protocol.
    #[error(transparent)]
    Buffer(#[from] BufferTooSmall),
}

impl RunError {
    /// What a contradiction to what is known of a maze that should have this size means: at the edge,
    /// that the maze is larger.
    pub fn from_contradiction(error: Contradiction, size: MazeSize) -> Self {
        let Contradiction { cell, heading, .. } = error;
        match size.neighbour(cell, heading) {
            Some(_) => error.into(),
            None => Self::LargerMaze { size, cell, heading },
        }
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

/// A search run that broke off.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct BrokenRun {
    /// The run until then.
    pub run: SearchRun,
    /// Why it broke off.
    #[source]
    pub error: RunError,
}

/// Runs a search: `reset`, then in every cell reads the walls, lets the mouse decide, sends the
/// state, and stops or takes a step. Where nothing is known of the side behind the mouse at the
/// start, it reads the walls there with the nose turned round, first of all.
///
/// It ends when the strategy stops or `max_states` states are sent. After each state `observe` is
/// shown the mouse and the run so far, and may end it by breaking off.
///
/// # Errors
/// The simulator does not answer or answers with an error, or the strategy cannot go on; its last
/// state is sent before that.
pub fn search_run<S: Strategy>(
    transport: &mut impl Transport,
    mouse: &mut Mouse<S>,
    max_states: u32,
    observe: impl FnMut(&Mouse<S>, &SearchRun) -> ControlFlow<()>,
) -> Result<SearchRun, BrokenRun> {
    let (mut exchange, mut run) = (Exchange::new(transport), SearchRun::default());
    let result = drive(&mut exchange, mouse, max_states, observe, &mut run);
    run.requests = exchange.requests();
    result.map(|()| run).map_err(|error| BrokenRun { run, error })
}

fn drive<S: Strategy>(
    exchange: &mut Exchange<impl Transport>,
    mouse: &mut Mouse<S>,
    max_states: u32,
    mut observe: impl FnMut(&Mouse<S>, &SearchRun) -> ControlFlow<()>,
    run: &mut SearchRun,
) -> Result<(), RunError> {
    exchange.reset()?;
    let size = mouse.map().size();
    let mut driver = SearchDriver::new(mouse, max_states);
    loop {
        let advanced = driver.advance(|pose| exchange.walls(pose));
        run.stats = *driver.stats();
        if !advanced.map_err(|error| RunError::from_drive_error(error, size))? {
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

/// Asks a server of this project what it serves. The reference server never answers this.
///
/// # Errors
/// The server does not answer or answers something else.
pub fn ask_info(transport: &mut impl Transport) -> Result<Info, RunError> {
    Exchange::new(transport).info()
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_server::Simulation;
    use mmsim_solvers::{BundledStrategy, FloodFill};

    use super::*;
    use crate::InMemory;

    const MAZE: &str = "\
o---o---o---o
|   |     G |
o   o   o---o
|       |   |
o   o---o   o
| S |       |
o---o---o---o
";

    /// Runs a search in memory; `change` may spoil a reply.
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

    /// Whether the goal was reached; steps, states and requests.
    fn figures(run: &SearchRun) -> (bool, u32, u32, u32) {
        (run.stats.goal_reached(), run.stats.steps(), run.states, run.requests)
    }

    fn known() -> KnownMaze {
        KnownMaze::unexplored(&MAZE.parse().unwrap())
    }

    #[test]
    fn a_run_counts_what_it_does() {
        let (result, simulation) = run(known(), 1000, |_, _| {});
        let expected = (true, 6, 7, 15);
        assert_eq!(figures(&result.unwrap()), expected);
        assert_eq!(simulation.history().len(), 7);
        let (result, simulation) = run(known(), 3, |_, _| {});
        let expected = (false, 2, 3, 7);
        assert_eq!(figures(&result.unwrap()), expected);
        assert_eq!(simulation.history().len(), 3);
    }

    #[test]
    fn who_watches_may_break_off() {
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
    fn every_strategy_runs_the_same_way() {
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
    fn a_start_open_only_behind_is_no_trap() {
        for &strategy in BundledStrategy::ALL {
            let maze: Maze = "o---o\n| S |\no   o\n| G |\no---o\n".parse().unwrap();
            let mut mouse =
                Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), maze.start());
            let mut simulation = Simulation::new("behind", maze);
            let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
            let go_on = |_: &Mouse<_>, _: &_| ControlFlow::Continue(());
            let run = search_run(&mut transport, &mut mouse, 1000, go_on).unwrap();
            // Some come back before they run fast.
            let comes_back =
                matches!(strategy, BundledStrategy::Swing | BundledStrategy::ShortestPathSearch);
            let steps = if comes_back { 3 } else { 1 };
            let (states, requests) = (steps + 1, 2 * steps + 4);
            let expected = (true, steps, states, requests);
            assert_eq!(figures(&run), expected, "{strategy}");
        }
    }

    #[test]
    fn a_goal_out_of_reach_ends_with_its_last_state() {
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
    fn a_maze_of_another_size_is_noticed() {
        let of_size = |width, height| {
            let size = MazeSize::new(width, height).unwrap();
            let goals = [Cell::new(2, 2)].into_iter().collect();
            run(KnownMaze::new(size, Cell::new(0, 0), goals), 1000, |_, _| {}).0.unwrap_err()
        };
        assert_eq!(
            of_size(3, 4).to_string(),
            "the simulator refused S: expected S of 24 bytes for a maze of 3x3 cells, found 30 bytes"
        );
        assert_eq!(
            of_size(3, 1).to_string(),
            "expected a maze of 3x1 cells, found no wall at the north side of (0, 0)"
        );
    }

    #[test]
    fn other_replies_are_errors() {
        let error = |spoilt: &'static [u8], reply: &'static [u8]| {
            let change = move |request: &[u8], bytes: &mut Vec<u8>| {
                if request.starts_with(spoilt) {
                    *bytes = reply.to_vec();
                }
            };
            run(known(), 1000, change).0.unwrap_err().to_string()
        };
        assert_eq!(error(b"reset", b"error: no"), "the simulator refused reset: no");
        assert_eq!(error(b"W", b"error: \x1b[2J\n"), "the simulator refused W: \\u{1b}[2J\\n");
        assert_eq!(error(b"W", b"ok"), "expected the reply to W, found \"ok\"");
        assert_eq!(error(b"S", b"pong"), "expected the reply to S, found \"pong\"");
        assert!(error(b"S", b"").starts_with("expected pong, ok, "));
        assert_eq!(
            error(b"W\x00\x01", &[1, 0, 0]),
            "expected no wall at the east side of (0, 1), as known before, found a wall"
        );
    }

    #[test]
    fn info_tells_the_maze() {
        let mut simulation = Simulation::new("small", MAZE.parse().unwrap());
        let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
        let info = ask_info(&mut transport).unwrap();
        assert_eq!((info.name.as_str(), info.width, info.height), ("small", 3, 3));
    }
}
