//! Code shared by the benchmarks.
#![forbid(unsafe_code)]

mod array_queue;
#[cfg(feature = "server")]
mod searches;

use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use std::{env, iter};

use criterion::{BatchSize, Criterion, Throughput};
use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze, MazeSize, Pose, WyRand};
use mmsim_solvers::{Mouse, SearchDriver, Strategy};

pub use array_queue::{Nibbles, Steps};
#[cfg(feature = "server")]
pub use searches::{Searches, serve};

/// The maximum number of states in a search. Without this limit, wall followers could run in
/// circles forever.
const MAX_STATES: u32 = 400;

/// Returns the 16×16 mazes: the bundled ones and, if available, those in the shared collection.
///
/// # Panics
/// Panics if a maze cannot be read.
pub fn classic_mazes() -> Vec<Maze> {
    mazes(&["classic"], |size| size == MazeSize::CLASSIC)
}

/// Returns all mazes of [`classic_mazes`] and [`large_mazes`], and the mazes of other sizes beside
/// them.
///
/// # Panics
/// Panics if a maze cannot be read.
pub fn all_mazes() -> Vec<Maze> {
    mazes(&["classic", "halfsize", "training"], |_| true)
}

/// Returns the bundled mazes and those in these folders of the shared collection.
fn mazes(folders: &[&str], has_size: fn(MazeSize) -> bool) -> Vec<Maze> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/mazes");
    let folders = folders.iter().filter_map(|name| Catalogue::from_path(&shared.join(name)).ok());
    let catalogues = iter::once(Catalogue::bundled()).chain(folders);
    let entries = catalogues.flat_map(|catalogue| catalogue.entries().to_vec());
    entries.map(|entry| entry.maze().unwrap()).filter(|maze| has_size(maze.size())).collect()
}

/// Returns the maze of the benchmarks that need only one.
///
/// # Panics
/// Never.
pub fn harbour() -> Maze {
    mmsim_mazes::HARBOUR.parse().unwrap()
}

/// Returns the 32×32 mazes: the bundled ones and, if available, those in the shared collection.
///
/// # Panics
/// Panics if a maze cannot be read.
pub fn large_mazes() -> Vec<Maze> {
    mazes(&["halfsize"], |size| size == MazeSize::HALF_SIZE)
}

/// Searches a maze and returns, in order, the poses in which the mouse read the walls.
pub fn sensor_poses(maze: &Maze, strategy: impl Strategy) -> Vec<Pose> {
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(maze), maze.start());
    let mut driver = SearchDriver::new(&mut mouse, MAX_STATES);
    let mut poses = Vec::new();
    while driver.advance_in(maze) == Ok(true) {
        poses.push(driver.mouse().pose());
    }
    poses
}

/// A row of a comparison: a named function to measure. `T` is the type of the function's input.
pub struct Row<'a, T> {
    name: String,
    run: Box<dyn Fn(&T) + 'a>,
}

impl<'a, T> Row<'a, T> {
    /// Creates a row.
    pub fn new(name: &str, run: impl Fn(&T) + 'a) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }
}

/// The number of rounds. Each round measures every function in the comparison.
const ROUNDS: usize = 21;
/// How many times each round calls each function.
const INPUTS: u32 = 1000;

/// Returns whether to measure, and not only to check the answers: `cargo bench` measures,
/// `cargo bench -- --test` and `cargo test --benches` do not.
pub fn is_measuring() -> bool {
    let has_argument = |name: &str| env::args().any(|argument| argument == name);
    has_argument("--bench") && !has_argument("--test") && !has_argument("--list")
}

/// Prints a row of the table in README.md, which the script `table` collects.
pub fn print_row(benchmark: &str, row: &str, result: &str) {
    println!("| {benchmark} | {row} | {result} |");
}

/// Measures each row's function with criterion, on randomly chosen inputs. Then runs several
/// rounds, each of which measures all functions one after another, so that changes in the machine's
/// speed affect all rows equally. Prints the median time of the first row, and the median ratios of
/// the other rows to it.
///
/// # Panics
/// Panics if there are no inputs or no rows.
pub fn compare<T>(criterion: &mut Criterion, name: &str, inputs: &[T], rows: &[Row<'_, T>]) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(1));
    for Row { name, run } in rows {
        let mut rng = WyRand::new(1);
        group.bench_function(name, |b| {
            b.iter_batched(
                || &inputs[rng.index(inputs.len())],
                |input| run(black_box(input)),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
    if is_measuring() {
        compare_alternately(name, inputs, rows);
    }
}

fn compare_alternately<T>(name: &str, inputs: &[T], rows: &[Row<'_, T>]) {
    let mut times = vec![Vec::new(); rows.len()];
    let mut rng = WyRand::new(2);
    for _ in 0..ROUNDS {
        let order: Vec<_> = (0..INPUTS).map(|_| rng.index(inputs.len())).collect();
        for (Row { run, .. }, times) in rows.iter().zip(&mut times) {
            let start = Instant::now();
            for &index in &order {
                run(black_box(&inputs[index]));
            }
            times.push(start.elapsed().as_secs_f64() / f64::from(INPUTS));
        }
    }
    let mut result = in_units(median(&times[0]));
    for (Row { name, .. }, others) in rows.iter().zip(&times).skip(1) {
        let ratio = ratio(median_ratio(others, &times[0]));
        write!(result, "; {name}: {ratio} times").unwrap();
    }
    print_row(name, &rows[0].name, &result);
}

/// Formats a time with its unit and three digits.
pub fn in_units(seconds: f64) -> String {
    match seconds {
        ..1e-6 => format!("{} ns", ratio(seconds * 1e9)),
        ..1e-3 => format!("{} µs", ratio(seconds * 1e6)),
        _ => format!("{} ms", ratio(seconds * 1e3)),
    }
}

/// Formats a ratio with at least three digits.
pub fn ratio(number: f64) -> String {
    let decimals = match number {
        ..10.0 => 2,
        ..100.0 => 1,
        _ => 0,
    };
    format!("{number:.decimals$}")
}

/// Returns the median of the ratios of two measurements, which were taken round by round.
///
/// # Panics
/// Panics if there are no numbers.
pub fn median_ratio(ours: &[f64], peers: &[f64]) -> f64 {
    median(&ours.iter().zip(peers).map(|(ours, peer)| ours / peer).collect::<Vec<_>>())
}

/// Returns the median of the numbers.
///
/// # Panics
/// Panics if there are no numbers.
pub fn median(figures: &[f64]) -> f64 {
    let mut sorted = figures.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
