//! What the benchmarks share: mazes, and a server to talk to.
#![forbid(unsafe_code)]

use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use criterion::{BatchSize, Criterion, Throughput};
use mmsim_client::{InMemory, search_run};
use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, MazeSize, Pose};
use mmsim_server::{Background, Server, Simulation};
use mmsim_solvers::{BundledStrategy, Mouse, SearchDriver, Strategy};

/// The maximum number of states in a search: wall followers may run in circles forever.
const MAX_STATES: u32 = 400;

/// The classic mazes to measure on: the project's own and, if it is available, the shared
/// collection.
///
/// # Panics
/// The project's own mazes cannot be read.
pub fn classic_mazes() -> Vec<Maze> {
    mazes_of(&["mazes", "../shared/mazes/classic"], |size| size == MazeSize::CLASSIC)
}

fn mazes_of(folders: &[&str], is_wanted: fn(MazeSize) -> bool) -> Vec<Maze> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut mazes = Vec::new();
    for folder in folders {
        let Ok(catalogue) = Catalogue::from_path(&root.join(folder)) else { continue };
        mazes.extend(catalogue.entries().iter().map(|entry| entry.maze().unwrap()));
    }
    mazes.retain(|maze| is_wanted(maze.size()));
    mazes
}

/// A maze of the project by its file name without the ending.
///
/// # Panics
/// There is none of this name.
pub fn bundled_maze(name: &str) -> Maze {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mazes");
    mmsim_formats::read_maze(&folder.join(name).with_extension("txt")).unwrap()
}

/// A server of this maze on a free port of loopback.
///
/// # Panics
/// There is no free port.
pub fn serve(maze: Maze) -> Background {
    Server::bind("127.0.0.1", 0).unwrap().spawn(Simulation::new("served", maze))
}

/// Numbers without a pattern, the same for the same seed.
pub struct Noise(u64);

impl Noise {
    /// A generator of random numbers with this seed.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number below `count`, which is not 0.
    pub fn below(&mut self, count: usize) -> usize {
        // Knuth's MMIX generator; the upper bits are the good ones.
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap_or(0) % count
    }
}

/// Searches of mazes in mixed order by all strategies in turn, from a cell to a goal cell that are
/// drawn anew each time. The same seed gives the same searches.
pub struct Searches<'m> {
    mazes: &'m [Maze],
    noise: Noise,
    count: usize,
}

impl<'m> Searches<'m> {
    /// How many strategies take turns.
    pub const STRATEGIES: usize = BundledStrategy::ALL.len();

    /// How many searches there were.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Searches of these mazes.
    pub const fn new(mazes: &'m [Maze]) -> Self {
        Self { mazes, noise: Noise::new(1), count: 0 }
    }

    /// Runs one search and shows each of its states.
    ///
    /// # Panics
    /// There is no maze.
    pub fn next(&mut self, mut show: impl FnMut(&[u8])) {
        let maze = &self.mazes[self.noise.below(self.mazes.len())];
        let strategy = BundledStrategy::ALL[self.count % BundledStrategy::ALL.len()];
        let mut cell = || {
            let (width, height) = (maze.size().width().into(), maze.size().height().into());
            let coordinate = |number| u8::try_from(number).unwrap();
            Cell::new(coordinate(self.noise.below(width)), coordinate(self.noise.below(height)))
        };
        let (start, goals) =
            (Pose::new(cell(), Heading::North), [cell()].into_iter().collect::<CellSet>());
        self.count += 1;
        let map = KnownMaze::new(maze.size(), start.cell, goals);
        let mut mouse = Mouse::new(strategy.strategy(), map, start);
        let mut simulation = Simulation::new("", maze.clone());
        let mut transport = InMemory::new(|request, reply| {
            if request.starts_with(b"S") {
                show(request);
            }
            simulation.handle(request, reply)
        });
        // A goal that cannot be reached ends a search as well.
        let _ =
            search_run(&mut transport, &mut mouse, MAX_STATES, |_, _| ControlFlow::Continue(()));
    }
}

/// Mazes of 32×32 cells: those of the shared collection, if it is available, and the project's
/// own.
///
/// # Panics
/// The project's own mazes cannot be read.
pub fn large_mazes() -> Vec<Maze> {
    mazes_of(&["mazes", "../shared/mazes/halfsize"], |size| size == MazeSize::HALF_SIZE)
}

/// Where a mouse stood each time it looked around on its search of this maze, in that order.
pub fn walls_seen(maze: &Maze, strategy: impl Strategy) -> Vec<Pose> {
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(maze), maze.start());
    let mut driver = SearchDriver::new(&mut mouse, MAX_STATES);
    let mut seen = Vec::new();
    while driver.advance_in(maze) == Ok(true) {
        seen.push(driver.mouse().pose());
    }
    seen
}

/// Something that is timed beside others of its kind.
pub struct Row<'a, T> {
    name: String,
    run: Box<dyn Fn(&T) + 'a>,
}

impl<'a, T> Row<'a, T> {
    /// Times this under that name.
    pub fn new(name: &str, run: impl Fn(&T) + 'a) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }
}

/// In how many rounds rows take turns, and how many things each is done with in a round.
const ROUNDS: usize = 51;
const IN_A_ROUND: u32 = 1000;

/// Times rows one after another with criterion, and then in turns, so that a change in the machine's
/// speed hits all of them; prints the medians of these rounds, and how many times as long as the
/// first row each other one takes. The things it is done with come in mixed order.
///
/// # Panics
/// There is nothing to do it with.
pub fn compare<T>(criterion: &mut Criterion, name: &str, things: &[T], rows: &[Row<'_, T>]) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(1));
    for Row { name, run } in rows {
        let mut noise = Noise::new(1);
        group.bench_function(name, |b| {
            b.iter_batched(
                || &things[noise.below(things.len())],
                |thing| run(black_box(thing)),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
    let is_asked = |argument: &str| std::env::args().any(|asked| asked == argument);
    if is_asked("--bench") && !is_asked("--test") && !is_asked("--list") {
        in_turns(name, things, rows);
    }
}

fn in_turns<T>(name: &str, things: &[T], rows: &[Row<'_, T>]) {
    let mut times = vec![Vec::new(); rows.len()];
    let mut noise = Noise::new(2);
    for _ in 0..ROUNDS {
        let order: Vec<_> = (0..IN_A_ROUND).map(|_| noise.below(things.len())).collect();
        for (Row { run, .. }, times) in rows.iter().zip(&mut times) {
            let begun = Instant::now();
            for &index in &order {
                run(black_box(&things[index]));
            }
            times.push(begun.elapsed().as_secs_f64() / f64::from(IN_A_ROUND));
        }
    }
    println!("{name}, medians of {ROUNDS} rounds in turns:");
    let first = times[0].clone();
    for (Row { name, .. }, times) in rows.iter().zip(times) {
        let ratio =
            median(&times.iter().zip(&first).map(|(this, first)| this / first).collect::<Vec<_>>());
        println!("  {name:<32} {:>10.1} ns  {ratio:>6.2} times", median(&times) * 1e9);
    }
}

/// The median of some figures.
///
/// # Panics
/// There are none.
pub fn median(figures: &[f64]) -> f64 {
    let mut sorted = figures.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
