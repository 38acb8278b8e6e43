//! Measures the time of complete searches. A flood-fill mouse searches one maze, both with an
//! in-memory simulator and over ZeroMQ on loopback. The bundled strategies search randomly chosen
//! 16×16 mazes without a simulator.

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_benches::{Row, classic_mazes, compare, in_units, is_measuring, print_row, serve};
use mmsim_client::{InMemory, SearchRun, Timeout, Transport, Zmq, search_run};
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_server::Simulation;
use mmsim_solvers::{
    BundledStrategy, FastestPathSearch, FloodFill, MazeFacts, Mouse, PathBounds, Phase,
    SearchDriver, ShortestPathSearch, Strategy, Tolerance,
};

/// A maze and the number of steps that a flood-fill search of this maze takes.
const MAZE: (&str, u32) = (mmsim_mazes::MIRAGE, 220);

fn search(transport: &mut impl Transport, maze: &Maze) -> SearchRun {
    let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(maze), maze.start());
    let run = search_run(transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!((run.stats.goal_reached(), run.stats.steps()), (true, MAZE.1));
    run
}

fn searches(criterion: &mut Criterion) {
    let maze = MAZE.0.parse::<Maze>().unwrap();
    let mut group = criterion.benchmark_group(format!("search/{} steps", MAZE.1));
    let mut simulation = Simulation::new("memory", maze.clone());
    let mut memory = InMemory::new(|request, reply| simulation.handle(request, reply));
    group.bench_function("in memory", |b| b.iter(|| search(&mut memory, &maze)));
    let server = serve(maze.clone());
    let mut zmq = Zmq::connect(server.address(), Timeout::Default, |_| {}).unwrap();
    group.bench_function("over ZeroMQ", |b| b.iter(|| search(&mut zmq, &maze)));
    group.finish();
}

/// Simulates a search run and a return run. Returns the mouse and the total number of steps.
fn explored<S: Strategy>(maze: &Maze, strategy: S, max_states: u32) -> (Mouse<S>, u32) {
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(maze), maze.start());
    let mut driver = SearchDriver::new(&mut mouse, max_states);
    while driver.phase() != Phase::FastRun && driver.advance_in(maze) == Ok(true) {}
    let steps = driver.stats().steps();
    (mouse, steps)
}

/// Asserts that both searches find the best run of each maze and prove it, and prints their mean
/// numbers of steps.
/// Then measures the time of complete searches of the strategies that count steps.
fn whole_searches(criterion: &mut Criterion) {
    let mut mazes = classic_mazes();
    mazes.retain(|maze| MazeFacts::new(maze).shortest_path.is_some());
    let count = u32::try_from(mazes.len()).unwrap();
    let steps = mazes.iter().map(|maze| {
        let (mouse, steps) = explored(maze, ShortestPathSearch::new(), 10_000);
        let bounds = PathBounds::new(mouse.map());
        assert!(bounds.is_proven());
        assert_eq!(bounds.pessimistic, MazeFacts::new(maze).shortest_path);
        assert_eq!(mouse.pose().cell, maze.start().cell);
        steps
    });
    let steps_to_shortest = steps.sum::<u32>();

    let vehicle = Vehicle::expert();
    let mut planner = Planner::new(vehicle.clone());
    let search = FastestPathSearch::with_planner(planner.clone(), Tolerance::ZERO);
    let mut time_per_step = Duration::ZERO;
    let steps = mazes.iter().map(|maze| {
        let begin = Instant::now();
        let (mouse, steps) = explored(maze, search.clone(), 10_000);
        time_per_step += begin.elapsed() / steps.max(1);
        let bounds = mouse.strategy().bounds();
        let fastest = planner.plan(maze.walls(), maze.start().cell, maze.goals()).unwrap();
        let error = bounds.pessimistic.unwrap() - fastest.time(&vehicle).unwrap();
        assert!(error.abs() < 5e-5, "{error} s");
        assert_eq!(bounds.loss(), Some(0.0));
        assert_eq!(mouse.pose().cell, maze.start().cell);
        steps
    });
    let steps_to_fastest = steps.sum::<u32>();
    if is_measuring() {
        print_row(
            "search/proof",
            "fastest-path-search, expert",
            &format!(
                "{:.2} times the steps of shortest-path-search ({:.0}); {} per step",
                f64::from(steps_to_fastest) / f64::from(steps_to_shortest),
                f64::from(steps_to_fastest) / f64::from(count),
                in_units((time_per_step / count).as_secs_f64())
            ),
        );
    }

    let baseline = Row::new("shortest-path-search", |maze: &Maze| {
        black_box(explored(maze, ShortestPathSearch::new(), 10_000).1);
    });
    // The fastest-path search takes some 300 times as long as the others.
    let others = BundledStrategy::ALL.iter().copied().filter(|&strategy| {
        strategy != BundledStrategy::ShortestPathSearch && !strategy.uses_vehicle()
    });
    let others = others.map(|strategy| {
        Row::new(strategy.name(), move |maze: &Maze| {
            black_box(explored(maze, strategy.strategy(), strategy.max_states()).1);
        })
    });
    let rows: Vec<_> = [baseline].into_iter().chain(others).collect();
    compare(criterion, "search/mixed", &mazes, &rows);
}

criterion_group!(benches, searches, whole_searches);
criterion_main!(benches);
