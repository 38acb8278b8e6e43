//! Whole searches, from reset to the goal: in memory, and over ZeroMQ on loopback.

use std::ops::ControlFlow;

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_benches::{bundled_maze, serve};
use mmsim_client::{InMemory, SearchRun, Transport, Zmq, search_run};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_server::Simulation;
use mmsim_solvers::{FloodFill, Mouse};

/// A maze in which the search takes about 200 steps, and how many it takes exactly.
const MAZE: (&str, u32) = ("06-mirage", 220);

fn search(transport: &mut impl Transport, maze: &Maze) -> SearchRun {
    let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::before(maze), maze.start());
    let run = search_run(transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!((run.goal_reached, run.steps), (true, MAZE.1));
    run
}

fn searches(criterion: &mut Criterion) {
    let maze = bundled_maze(MAZE.0);
    let mut group = criterion.benchmark_group(format!("search/{} steps", MAZE.1));
    let mut simulation = Simulation::new("memory", maze.clone());
    let mut memory = InMemory::new(|request, reply| simulation.handle(request, reply));
    group.bench_function("in memory", |b| b.iter(|| search(&mut memory, &maze)));
    let server = serve(maze.clone());
    let mut zmq = Zmq::connect(server.address(), None, |_| {}).unwrap();
    group.bench_function("over ZeroMQ", |b| b.iter(|| search(&mut zmq, &maze)));
    group.finish();
}

criterion_group!(benches, searches);
criterion_main!(benches);
