//! Checks complete searches over real sockets and in memory.

use std::collections::HashMap;
use std::convert::Infallible;
use std::fs;
use std::ops::ControlFlow;
use std::thread;

use mmsim_client::{BrokenRun, Exchange, SearchRun, Timeout, Zmq, search_run, search_run_with};
use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, KnownMaze, Maze, Misreadings, Pose, Unknown, WallSensor};
use mmsim_protocol::{MazeSize, Request};
use mmsim_run::{MovementRules, Phases, RunFigures};
use mmsim_server::{Server, Simulation};
use mmsim_solvers::{
    BundledStrategy, Distances, MazeFacts, Mouse, Move, PathBounds, Phase, SearchDriver,
    SearchError, ShortestPathSearch, Swing, WallVotes,
};
use mmsim_tests::{TIMEOUT, known_distance, serve, shared, stop, within};

fn mazes() -> Vec<(String, Maze)> {
    let catalogue = Catalogue::bundled();
    catalogue.entries().iter().map(|entry| (entry.name(), entry.maze().unwrap())).collect()
}

/// Connects a mouse to a server, with [`TIMEOUT`] as the limit for each reply.
type Connect = fn(&str) -> Zmq<'static>;

const TRANSPORTS: &[Connect] = &[
    |address| Zmq::connect(address, Timeout::After(TIMEOUT), |_| {}).unwrap(),
    #[cfg(not(all(windows, target_env = "gnu")))]
    |address| Zmq::connect_with_libzmq(address, Timeout::After(TIMEOUT), |_| {}).unwrap(),
];

#[test]
fn mice_reach_every_reachable_goal_over_each_transport() {
    for (name, maze) in mazes() {
        for strategy in
            [BundledStrategy::FloodFill, BundledStrategy::WeightIncrement, BundledStrategy::Swing]
        {
            let search = |connect: &Connect| search_over_socket(&maze, strategy, *connect);
            let histories: Vec<_> = TRANSPORTS.iter().map(search).collect();
            assert!(histories.windows(2).all(|both| both[0] == both[1]), "{strategy} in {name}");
        }
    }
}

/// Searches a maze over a socket, checks the result, and returns the states in the history of the
/// server.
fn search_over_socket(maze: &Maze, strategy: BundledStrategy, connect: Connect) -> Vec<Vec<u8>> {
    let server = serve(maze.clone());
    let mut transport = connect(server.address());
    let info = Exchange::new(&mut transport).info().unwrap();
    let (size, start) = (info.size().unwrap(), info.start_pose().unwrap());
    let map = KnownMaze::new(size, start.cell, info.goal_cells());
    assert_eq!(map, KnownMaze::unexplored(maze));
    let mut mouse = Mouse::new(strategy.strategy(), map, start);
    let shortest = MazeFacts::new(maze).shortest_path;
    // A weight-increment mouse never gives up.
    let max_states = if shortest.is_some() { 10_000 } else { 500 };
    let result =
        search_run(&mut transport, &mut mouse, max_states, |_, _| ControlFlow::Continue(()));
    let simulation = stop(server);
    let history: Vec<_> = simulation.history().iter().collect();
    let last = Request::decode(history.last().unwrap(), size);
    let Ok(Request::State(last)) = last else { panic!("{last:?}") };
    assert_eq!(last.pose(), mouse.pose());
    if let Some(shortest) = shortest {
        let run = result.unwrap();
        assert!(run.stats.goal_reached() && run.stats.steps() >= shortest.into(), "{run:?}");
        assert_eq!(history.len(), run.states as usize);
        let known = known_distance(mouse.map(), start.cell, Unknown::Closed).unwrap();
        assert!(known >= shortest && u32::from(known) <= run.stats.steps());
    } else {
        assert!(!result.is_ok_and(|run| run.stats.goal_reached()));
    }
    history
}

/// The phases that a viewer finds in the poses of a bundled mouse equal those in the steps that the
/// mouse counts.
#[test]
fn phases_of_poses_equal_those_of_the_strategies() {
    let mut complete = 0;
    for (name, maze) in mazes() {
        for &strategy in BundledStrategy::ALL {
            let map = KnownMaze::unexplored(&maze);
            let mut mouse = Mouse::new(strategy.strategy(), map, maze.start());
            let mut driver = SearchDriver::new(&mut mouse, 1000);
            let (rules, mut found) = (MovementRules::from_maze(&maze), Phases::default());
            // The steps and turns of the search run, the latest return run and the latest fast run.
            let (mut runs, mut run, mut next) = ([(0, 0); 3], 0, None);
            let mut before = (0, 0);
            while driver.advance_in(&maze) == Ok(true) {
                let (pose, stats) = (driver.mouse().pose(), driver.stats());
                found.add(&rules, pose, false);
                let index = found.states - 1;
                if let Some(begun) = next.take() {
                    (run, runs[begun]) = (begun, (0, 0));
                }
                runs[run].0 += stats.steps() - before.0;
                runs[run].1 += stats.turns() - before.1;
                before = (stats.steps(), stats.turns());
                let is_goal = maze.goals().contains(pose.cell);
                next = match run {
                    1 => (pose.cell == maze.start().cell).then_some(2),
                    _ => is_goal.then_some(1),
                };
                let counts = |run: RunFigures| (run.steps, run.turns);
                let text = format!("{strategy} in {name}, state {index}");
                let found_runs = [found.search_run, found.return_run, found.fast_run].map(counts);
                assert_eq!(found_runs, runs, "{text}");
                assert_eq!(runs[0], (stats.search_run.steps, stats.search_run.turns), "{text}");
                let total = (stats.steps().into(), stats.turns().into());
                assert_eq!((found.total.steps, found.total.turns), total, "{text}");
                assert_eq!((found.restarts, found.jumps), (0, 0), "{text}");
                assert_eq!(found.is_goal_reached(), stats.goal_reached(), "{text}");
                complete += u32::from(stats.fast_run.steps > 0 && found.best_run.is_some());
            }
        }
    }
    assert!(complete > 20, "{complete} searches with a fast run");
}

/// The same seed gives the same wrong readings, so a mouse does the same over a socket as in memory.
#[test]
fn wrong_readings_are_the_same_over_a_socket_and_in_memory() {
    let (mut recovered, mut failed, mut crashes) = (0, 0, 0);
    for (name, maze) in mazes() {
        let strategies = [BundledStrategy::FloodFill, BundledStrategy::ShortestPathSearch];
        let kinds =
            [false, true].map(|are_fixed| Misreadings { probability: 0.03, seed: 7, are_fixed });
        for ((strategy, misreadings), recovers) in strategies
            .into_iter()
            .flat_map(|strategy| kinds.map(|kind| (strategy, kind)))
            .flat_map(|search| [false, true].map(|recovers| (search, recovers)))
        {
            let text = format!("{strategy} in {name} with {misreadings:?}");
            let (start, max_states) = (maze.start(), strategy.max_states());
            let mouse = || Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), start);
            let (mut mouse, mut same) = (mouse(), mouse());
            let simulation = Simulation::new("misread", maze.clone()).with_misreadings(misreadings);
            let server = Server::bind("127.0.0.1", 0).unwrap().spawn(simulation);
            let mut poses = Vec::new();
            let (run, again) = {
                let mut transport = TRANSPORTS[0](server.address());
                let mut search = |mouse: &mut Mouse<_>, poses: &mut Vec<Pose>| {
                    let observe = |mouse: &Mouse<_>, _: &_| {
                        poses.push(mouse.pose());
                        ControlFlow::Continue(())
                    };
                    let mut votes = recovers.then(WallVotes::new);
                    let driver = SearchDriver::new(mouse, max_states).recovering(votes.as_mut());
                    search_run_with(&mut transport, driver, observe)
                };
                let run = search(&mut mouse, &mut poses);
                let mut second = Vec::new();
                let mut other =
                    Mouse::new(strategy.strategy(), KnownMaze::unexplored(&maze), start);
                let again = search(&mut other, &mut second);
                assert_eq!(second, poses, "{text}: a reset restores the seed");
                (run, again)
            };
            stop(server);
            let (mut sensor, mut at) = (WallSensor::new(misreadings, &maze), start.cell);
            let mut votes = recovers.then(WallVotes::new);
            let mut driver = SearchDriver::new(&mut same, max_states).recovering(votes.as_mut());
            let mut in_memory = Vec::new();
            let error = loop {
                let read =
                    |pose| Ok::<_, Infallible>(sensor.around_from(maze.walls(), &mut at, pose));
                match driver.advance_unless_blocked(read) {
                    Ok(true) => in_memory.push(driver.mouse().pose()),
                    Ok(false) => break None,
                    Err(error) => break Some(error.to_string()),
                }
            };
            assert_eq!(in_memory, poses, "{text}");
            let error_of =
                |run: &Result<SearchRun, BrokenRun>| run.as_ref().err().map(ToString::to_string);
            assert_eq!([error_of(&run), error_of(&again)], [error.clone(), error], "{text}");
            let stats = *driver.stats();
            assert_eq!(run.unwrap_or_else(|broken| broken.run).stats, stats, "{text}");
            assert_eq!((same.map(), same.pose()), (mouse.map(), mouse.pose()), "{text}");
            crashes += stats.crashes;
            recovered += u32::from(recovers && stats.goal_reached());
            failed += u32::from(!recovers && !stats.goal_reached());
        }
    }
    assert!(recovered > 60 && failed > 20 && crashes > 20, "{recovered} {failed} {crashes}");
}

#[test]
fn a_client_may_start_before_its_server() {
    let (_, maze) = mazes().swap_remove(0);
    let port = {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        server.address().rsplit(':').next().unwrap().parse().unwrap()
    };
    let (sender, notices) = std::sync::mpsc::channel();
    let endpoint = format!("tcp://127.0.0.1:{port}");
    let map = KnownMaze::unexplored(&maze);
    let start = maze.start();
    let client = thread::spawn(move || {
        let on_wait = |_: mmsim_client::Waiting<'_>| sender.send(()).unwrap();
        let mut transport = Zmq::connect(&endpoint, Timeout::After(TIMEOUT), on_wait).unwrap();
        let mut mouse = Mouse::new(BundledStrategy::FloodFill.strategy(), map, start);
        search_run(&mut transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(())).unwrap()
    });
    notices.recv_timeout(TIMEOUT).unwrap();
    let server = Server::bind("127.0.0.1", port).unwrap();
    let server = server.spawn(Simulation::new("late", maze));
    let run = within("the search to end", || client.join()).unwrap();
    assert!(run.stats.goal_reached());
    assert_eq!(stop(server).history().len(), run.states as usize);
}

#[test]
fn simultaneous_clients_get_their_own_replies() {
    let (_, maze) = mazes().swap_remove(0);
    assert_eq!(maze.size(), MazeSize::CLASSIC);
    let server = serve(maze.clone());
    thread::scope(|scope| {
        for strategy in [
            BundledStrategy::FloodFill,
            BundledStrategy::WeightIncrement,
            BundledStrategy::LeftWall,
        ] {
            let (maze, address) = (&maze, server.address());
            scope.spawn(move || {
                let mut transport = Zmq::connect(address, Timeout::After(TIMEOUT), |_| {}).unwrap();
                let map = KnownMaze::unexplored(maze);
                let mut mouse = Mouse::new(strategy.strategy(), map, maze.start());
                search_run(&mut transport, &mut mouse, 500, |_, _| ControlFlow::Continue(()))
                    .unwrap();
                for cell in mouse.map().visited() {
                    for heading in mmsim_maze::Heading::ALL {
                        let known = mouse.map().walls(Unknown::Open).has(cell, heading);
                        assert!(
                            !known || maze.walls().has(cell, heading),
                            "{strategy}: false wall at {cell}"
                        );
                    }
                }
            });
        }
    });
    stop(server);
}

#[test]
fn swing_reaches_every_reachable_goal_of_the_shared_mazes() {
    let Some(folder) = shared("mazes") else { return };
    // All mazes take a minute in an unoptimised build.
    let sample = if cfg!(debug_assertions) { 24 } else { 1 };
    let mut max_states = 0;
    for entry in Catalogue::from_path(&folder).unwrap().entries().iter().step_by(sample) {
        let (name, maze) = (entry.name(), entry.maze().unwrap());
        let mut mouse = Mouse::new(Swing::new(), KnownMaze::unexplored(&maze), maze.start());
        let mut driver = SearchDriver::new(&mut mouse, BundledStrategy::Swing.max_states());
        while driver.advance_in(&maze) == Ok(true) {}
        let (decision, stats) = (driver.decision().unwrap(), *driver.stats());
        match MazeFacts::new(&maze).shortest_path {
            Some(_) => {
                assert_eq!(decision, Ok(Move::Stop), "{name}");
                assert!(maze.goals().contains(mouse.pose().cell), "{name}");
                let known = PathBounds::new(mouse.map()).pessimistic.map(u32::from);
                assert_eq!(
                    known,
                    Some(stats.fast_run.steps),
                    "{name}: the fast run is not the shortest known path"
                );
            }
            None => assert!(decision.is_err(), "{name}: {decision:?}"),
        }
        max_states = max_states.max(stats.steps() + 1);
    }
    assert!(max_states > 100, "no search had more than 100 states");
    println!("at most {max_states} states");
}

#[test]
fn shortest_path_search_proves_that_paths_in_the_shared_mazes_are_shortest() {
    let Some(folder) = shared("mazes") else { return };
    let facts: HashMap<String, Facts> =
        serde_json::from_str(&fs::read_to_string(folder.join("facts.json")).unwrap()).unwrap();
    // All mazes take minutes in an unoptimised build.
    let sample = if cfg!(debug_assertions) { 24 } else { 1 };
    let (mut max_steps, mut classic) = (0, Vec::new());
    for entry in Catalogue::from_path(&folder).unwrap().entries().iter().step_by(sample) {
        let (name, maze) = (entry.name(), entry.maze().unwrap());
        let file = entry.path().strip_prefix(&folder).unwrap().to_str().unwrap();
        let shortest = facts.get(file).map_or_else(
            || MazeFacts::new(&maze).shortest_path, // the trial's mazes have no recorded facts
            |facts| facts.shortest_cells,
        );
        let search = ShortestPathRun::new(&maze);
        assert_eq!(search.back_at, maze.start().cell, "{name}");
        if let Some(shortest) = shortest {
            assert_eq!(search.result, Ok(Move::Stop), "{name}");
            assert_eq!(
                search.known,
                Some(shortest.into()),
                "{name}: the shortest path is not known"
            );
            assert_eq!(
                search.fast_steps,
                u32::from(shortest),
                "{name}: the fast run does not take the shortest path"
            );
            if file.starts_with("classic") {
                classic.push(search.steps);
            }
        } else {
            let cell = maze.start().cell;
            assert_eq!(search.result, Err(SearchError::GoalUnreachable { cell }), "{name}");
        }
        max_steps = max_steps.max(search.steps);
    }
    assert!(max_steps > 100, "no search took more than 100 steps");
    let (steps, mazes) = (classic.iter().sum::<u32>(), u32::try_from(classic.len()).unwrap());
    println!("at most {max_steps} steps, {steps} in total in {mazes} classic mazes");
    assert!(sample > 1 || steps < 230 * mazes, "the mean exceeds 230 steps");
}

#[derive(serde::Deserialize)]
struct Facts {
    shortest_cells: Option<u16>,
}

/// The results of a shortest-path search in memory.
struct ShortestPathRun {
    result: Result<Move, SearchError>,
    /// The number of steps until the mouse is back at the start for the fast run.
    steps: u32,
    back_at: Cell,
    /// The length of the shortest known path from the start to the goal.
    known: Option<u32>,
    fast_steps: u32,
}

impl ShortestPathRun {
    /// Searches the maze. Checks that the mouse returns to the start as soon as it has reached the
    /// goal and has proven that a known path is shortest.
    fn new(maze: &Maze) -> Self {
        let start = maze.start().cell;
        let home = [start].into_iter().collect();
        let mut mouse =
            Mouse::new(ShortestPathSearch::new(), KnownMaze::unexplored(maze), maze.start());
        let max_states = BundledStrategy::ShortestPathSearch.max_states();
        let mut driver = SearchDriver::new(&mut mouse, max_states);
        let (mut back_at, mut proven) = (start, false);
        while driver.advance_in(maze) == Ok(true) {
            let (mouse, phase, stats) = (driver.mouse(), driver.phase(), driver.stats());
            let cell = mouse.pose().cell;
            proven |= stats.goal_reached() && PathBounds::new(mouse.map()).is_proven();
            let has_begun = (proven && cell == start) || stats.fast_run.steps > 0;
            assert_eq!(phase == Phase::FastRun, has_begun);
            if proven && phase != Phase::FastRun {
                assert_eq!(phase, Phase::ReturnRun, "the mouse does not return from {cell}");
                let to_start = |unknown| Distances::flood(mouse.map().walls(unknown), &home);
                let paths_home = [Unknown::Open, Unknown::Closed].map(to_start);
                let goes_by = mouse.weight(cell);
                assert!(paths_home.iter().any(|path| path.at(cell) == goes_by), "{cell}");
                assert_eq!(mouse.weight(start), Some(0), "the mouse does not return from {cell}");
            }
            if stats.fast_run.steps == 0 {
                back_at = cell;
            }
        }
        let (result, stats) = (driver.decision().unwrap(), *driver.stats());
        let known = PathBounds::new(mouse.map()).pessimistic.map(u32::from);
        let steps = stats.exploration().steps;
        Self { result, steps, back_at, known, fast_steps: stats.fast_run.steps }
    }
}
