//! Plans from the start to the goal of classic mazes, beside the crate `pathfinding`: the shortest
//! way in cells, and the fewest time steps of a race. Mazes in mixed order.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use mmsim_benches::{Noise, classic_mazes};
use mmsim_maze::{Cell, Heading, Maze};
use mmsim_solvers::ShortestPath;
use mmsim_trial::{Action, race_optimum};
use pathfinding::prelude::{astar, bfs};

type Plan<'p> = (&'p str, &'p dyn Fn(&Maze) -> Option<u16>);

/// The goal cell that all plan to.
fn goal(maze: &Maze) -> Cell {
    maze.goals().iter().next().unwrap()
}

/// Asserts that all plans agree on each maze, then times them.
fn compare(criterion: &mut Criterion, name: &str, plans: &[Plan<'_>]) {
    let mazes = classic_mazes();
    for maze in &mazes {
        for (peer, plan) in &plans[1..] {
            assert_eq!(plan(maze), plans[0].1(maze), "{peer}");
        }
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(1));
    for (name, plan) in plans {
        let mut noise = Noise::new(1);
        group.bench_function(*name, |b| {
            b.iter_batched(
                || &mazes[noise.below(mazes.len())],
                |maze| black_box(plan(black_box(maze))),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

fn cells(criterion: &mut Criterion) {
    let ours = |maze: &Maze| {
        let path = ShortestPath::find(maze.walls(), maze.start().cell, goal(maze))?;
        black_box(path.headings().last());
        Some(path.length())
    };
    let peer = |maze: &Maze| {
        let (walls, to) = (maze.walls(), goal(maze));
        let steps = |cell: &Cell| walls.open_neighbours(*cell).map(|next| (next, 1));
        let guess =
            |cell: &Cell| u16::from(cell.x.abs_diff(to.x)) + u16::from(cell.y.abs_diff(to.y));
        Some(astar(&maze.start().cell, steps, guess, |cell| *cell == to)?.1)
    };
    compare(criterion, "a_star/mixed", &[("mmsim", &ours), ("pathfinding astar", &peer)]);
}

/// The cells in which a time step may end.
fn straights(maze: &Maze, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
    Heading::ALL.into_iter().flat_map(move |heading| {
        let on = move |&here: &Cell| {
            (!maze.walls().has(here, heading)).then(|| here.neighbour(heading)).flatten()
        };
        std::iter::successors(Some(cell), on).skip(1).take(Action::MAX_CELLS.unsigned_abs().into())
    })
}

fn time_steps(criterion: &mut Criterion) {
    let ours = |maze: &Maze| race_optimum(maze.walls(), maze.start().cell, maze.goals());
    let by_bfs = |maze: &Maze| {
        let is_goal = |cell: &Cell| maze.goals().contains(*cell);
        let way = bfs(&maze.start().cell, |cell| straights(maze, *cell), is_goal)?;
        u16::try_from(way.len() - 1).ok()
    };
    let by_a_star = |maze: &Maze| {
        let goals: Vec<_> = maze.goals().iter().collect();
        let steps = |cell: &Cell| straights(maze, *cell).map(|next| (next, 1));
        let guess = |cell: &Cell| {
            let straight = |from: u8, to: u8| u16::from(from.abs_diff(to).div_ceil(3));
            let to = |goal: &Cell| straight(cell.x, goal.x) + straight(cell.y, goal.y);
            goals.iter().map(to).min().unwrap_or(0)
        };
        let is_goal = |cell: &Cell| maze.goals().contains(*cell);
        Some(astar(&maze.start().cell, steps, guess, is_goal)?.1)
    };
    let plans: [Plan<'_>; 3] =
        [("mmsim", &ours), ("pathfinding bfs", &by_bfs), ("pathfinding astar", &by_a_star)];
    compare(criterion, "race/mixed", &plans);
}

criterion_group!(benches, cells, time_steps);
criterion_main!(benches);
