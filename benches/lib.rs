//! What the benchmarks share: mazes, and a server to talk to.

use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{InMemory, search_run};
use mmsim_maze::{Catalogue, Cell, CellSet, Heading, KnownMaze, Maze, Pose};
use mmsim_server::{Background, Server, Simulation};
use mmsim_solvers::{Bundled, Mouse};

/// States of one search at most: wall followers may go round for ever.
const MAX_STATES: u32 = 400;

/// The classic mazes to measure on: those of the project, and those of the shared collection
/// beside it where that is there.
///
/// # Panics
/// The project's own mazes cannot be read.
pub fn classic_mazes() -> Vec<Maze> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut mazes = Vec::new();
    for folder in ["mazes", "../shared/mazes/classic"] {
        let Ok(catalogue) = Catalogue::of_path(&root.join(folder)) else { continue };
        mazes.extend(catalogue.entries().iter().map(|entry| entry.maze().unwrap()));
    }
    mazes.retain(|maze| maze.size() == mmsim_maze::MazeSize::CLASSIC);
    mazes
}

/// A maze of the project by its file name without the ending.
///
/// # Panics
/// There is none of this name.
pub fn bundled_maze(name: &str) -> Maze {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mazes");
    Maze::read(&folder.join(name).with_extension("txt")).unwrap()
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
    /// Numbers of this seed.
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
    pub const STRATEGIES: usize = Bundled::ALL.len();

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
        let strategy = Bundled::ALL[self.count % Bundled::ALL.len()];
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
