//! Measures the time to generate a maze of each style. For the contest style, also measures the
//! mean and the maximum time over 10,000 mazes.

use std::collections::HashSet;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_generator::{Style, generate};
use mmsim_maze::MazeSize;
use mmsim_solvers::MazeFacts;

const MAZES: u32 = 10_000;
/// How many times each maze is generated. Without optimization, only the results are checked.
const ROUNDS: usize = if cfg!(debug_assertions) { 1 } else { 3 };

fn styles(criterion: &mut Criterion) {
    for (size, name) in [(MazeSize::CLASSIC, "16x16"), (MazeSize::HALF_SIZE, "32x32")] {
        let mut group = criterion.benchmark_group(format!("generate/{name}"));
        for &style in Style::ALL {
            let mut seed = 0;
            group.bench_function(style.name(), |b| {
                b.iter(|| {
                    seed += 1;
                    black_box(generate(size, seed, style))
                });
            });
        }
        group.finish();
    }
}

/// Measures the time to generate each of 10,000 mazes. To exclude interruptions by the system, each
/// maze is generated several times and the fastest run counts. Asserts that all mazes are different
/// and that all cells are reachable.
fn ten_thousand(_: &mut Criterion) {
    for (size, name) in [(MazeSize::CLASSIC, "16x16"), (MazeSize::HALF_SIZE, "32x32")] {
        let mut mazes = HashSet::new();
        let (mut total, mut slowest) = (Duration::ZERO, Duration::ZERO);
        for seed in 0..MAZES {
            let timed = |_| {
                let start = Instant::now();
                let maze = black_box(generate(size, seed.into(), Style::Contest));
                (start.elapsed(), maze)
            };
            let fastest = (0..ROUNDS).map(timed).min_by_key(|&(time, _)| time);
            let (time, maze) = fastest.expect("at least one round");
            total += time;
            slowest = slowest.max(time);
            assert_eq!(MazeFacts::new(&maze).reachable_cells, size.area());
            mazes.insert(maze);
        }
        assert_eq!(mazes.len(), MAZES as usize);
        let mean = total / MAZES;
        println!("generate/{name}/contest: {MAZES} mazes, mean {mean:.1?}, slowest {slowest:.1?}");
    }
}

criterion_group!(benches, styles, ten_thousand);
criterion_main!(benches);
