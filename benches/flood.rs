//! Full floods of classic mazes: the distance of every cell to the goal. Mazes in mixed order are
//! what counts; one maze again and again trains the branch predictor and flatters.

use std::collections::VecDeque;
use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use mmsim_benches::{Noise, classic_mazes};
use mmsim_maze::{CellSet, Heading, Maze, Walls};
use mmsim_solvers::Distances;

/// The flood as a textbook has it: a growing queue, bounds checked cell by cell.
fn textbook(walls: &Walls, targets: &CellSet) -> Vec<Vec<Option<u16>>> {
    let size = walls.size();
    let mut distances = vec![vec![None; size.height().into()]; size.width().into()];
    let mut queue: VecDeque<_> = targets.iter().collect();
    for cell in targets.iter() {
        distances[usize::from(cell.x)][usize::from(cell.y)] = Some(0);
    }
    while let Some(cell) = queue.pop_front() {
        let next = distances[usize::from(cell.x)][usize::from(cell.y)].map(|steps| steps + 1);
        for heading in Heading::ALL.into_iter().filter(|&heading| !walls.has(cell, heading)) {
            let Some(neighbour) = size.neighbour(cell, heading) else { continue };
            let distance = &mut distances[usize::from(neighbour.x)][usize::from(neighbour.y)];
            if distance.is_none() {
                *distance = next;
                queue.push_back(neighbour);
            }
        }
    }
    distances
}

fn floods(criterion: &mut Criterion) {
    let mazes = classic_mazes();
    for maze in &mazes {
        let (ours, twin) =
            (Distances::flood(maze.walls(), maze.goals()), textbook(maze.walls(), maze.goals()));
        for cell in maze.size().cells() {
            assert_eq!(ours.at(cell), twin[usize::from(cell.x)][usize::from(cell.y)]);
        }
    }
    let mut group = criterion.benchmark_group("flood/mixed");
    group.throughput(Throughput::Elements(1));
    let ours = |maze: &Maze| {
        black_box(Distances::flood(maze.walls(), maze.goals()));
    };
    let twin = |maze: &Maze| {
        black_box(textbook(maze.walls(), maze.goals()));
    };
    for (name, flood) in [("mmsim", &ours as &dyn Fn(&Maze)), ("textbook queue", &twin)] {
        let mut noise = Noise::new(1);
        group.bench_function(name, |b| {
            b.iter_batched(
                || &mazes[noise.below(mazes.len())],
                |maze| flood(black_box(maze)),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, floods);
criterion_main!(benches);
