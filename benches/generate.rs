//! Measures the time to generate a maze of each style. For the contest style, also measures the
//! mean and the maximum time over 10,000 mazes, and the time of the flood of firmware in the same
//! mazes.

use std::collections::HashSet;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use mmsim_benches::{Nibbles, in_units, is_measuring, print_row, ratio};
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
        let [mut total, mut slowest, mut floods] = [Duration::ZERO; 3];
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
            let nibbles = Nibbles::new(&maze);
            floods += (0..ROUNDS).map(|_| time_to_flood(&nibbles, size)).min().unwrap_or_default();
            assert_eq!(MazeFacts::new(&maze).reachable_cells, size.area());
            mazes.insert(maze);
        }
        assert_eq!(mazes.len(), MAZES as usize);
        if is_measuring() {
            let (mean, flood) = ((total / MAZES).as_secs_f64(), (floods / MAZES).as_secs_f64());
            let slowest = slowest.as_secs_f64();
            let result = format!(
                "mean {} times a flood with the array queue ({}), slowest {} times ({})",
                ratio(mean / flood),
                in_units(mean),
                ratio(slowest / flood),
                in_units(slowest)
            );
            print_row(&format!("generate/{name}"), &format!("{MAZES} contest mazes"), &result);
        }
    }
}

fn time_to_flood(nibbles: &Nibbles, size: MazeSize) -> Duration {
    let start = Instant::now();
    if size == MazeSize::CLASSIC {
        black_box(&nibbles.flood::<256, u8>());
    } else {
        black_box(&nibbles.flood::<1024, u16>());
    }
    start.elapsed()
}

criterion_group!(benches, styles, ten_thousand);
criterion_main!(benches);
