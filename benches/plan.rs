//! Compares how long mmsim and the `pathfinding` crate take to plan a path from the start to the
//! goal in randomly chosen 16×16 mazes. One benchmark looks for the path with the fewest cells; the
//! other finds the minimum number of time steps that a robot in the two-run trial needs to reach
//! the goal.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_benches::{Row, classic_mazes};
use mmsim_maze::{Cell, Heading, Maze};
use mmsim_solvers::ShortestPath;
use mmsim_trial::{Action, race_optimum};
use pathfinding::prelude::{astar, bfs};

type Planner<'p> = (&'p str, &'p dyn Fn(&Maze) -> Option<u16>);

/// Returns the first goal cell. In [`cells`], all planners plan a path to this cell.
fn goal(maze: &Maze) -> Cell {
    maze.goals().iter().next().unwrap()
}

/// Asserts that all planners give the same result for each maze, then measures their time.
fn compare(criterion: &mut Criterion, name: &str, planners: &[Planner<'_>]) {
    let mazes = classic_mazes();
    for maze in &mazes {
        for (peer, plan) in &planners[1..] {
            assert_eq!(plan(maze), planners[0].1(maze), "{peer}");
        }
    }
    let rows: Vec<Row<'_, Maze>> = planners
        .iter()
        .map(|&(name, plan)| {
            Row::new(name, move |maze| {
                black_box(plan(maze));
            })
        })
        .collect();
    mmsim_benches::compare(criterion, name, &mazes, &rows);
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
        let heuristic =
            |cell: &Cell| u16::from(cell.x.abs_diff(to.x)) + u16::from(cell.y.abs_diff(to.y));
        Some(astar(&maze.start().cell, steps, heuristic, |cell| *cell == to)?.1)
    };
    compare(criterion, "plan/cells", &[("mmsim", &ours), ("pathfinding astar", &peer)]);
}

/// Returns the cells that the robot can reach in one time step.
fn reachable_in_one_step(maze: &Maze, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
    Heading::ALL.into_iter().flat_map(move |heading| {
        let next = move |&here: &Cell| {
            (!maze.walls().has(here, heading)).then(|| here.neighbour(heading)).flatten()
        };
        std::iter::successors(Some(cell), next)
            .skip(1)
            .take(Action::MAX_CELLS.unsigned_abs().into())
    })
}

fn time_steps(criterion: &mut Criterion) {
    let ours = |maze: &Maze| race_optimum(maze.walls(), maze.start().cell, maze.goals());
    let by_bfs = |maze: &Maze| {
        let is_goal = |cell: &Cell| maze.goals().contains(*cell);
        let path = bfs(&maze.start().cell, |cell| reachable_in_one_step(maze, *cell), is_goal)?;
        u16::try_from(path.len() - 1).ok()
    };
    let by_a_star = |maze: &Maze| {
        let goals: Vec<_> = maze.goals().iter().collect();
        let steps = |cell: &Cell| reachable_in_one_step(maze, *cell).map(|next| (next, 1));
        let heuristic = |cell: &Cell| {
            let axis_steps = |from: u8, to: u8| u16::from(from.abs_diff(to).div_ceil(3));
            let steps = |goal: &Cell| axis_steps(cell.x, goal.x) + axis_steps(cell.y, goal.y);
            goals.iter().map(steps).min().unwrap_or(0)
        };
        let is_goal = |cell: &Cell| maze.goals().contains(*cell);
        Some(astar(&maze.start().cell, steps, heuristic, is_goal)?.1)
    };
    let planners: [Planner<'_>; 3] =
        [("mmsim", &ours), ("pathfinding bfs", &by_bfs), ("pathfinding astar", &by_a_star)];
    compare(criterion, "plan/race", &planners);
}

criterion_group!(benches, cells, time_steps);
criterion_main!(benches);
