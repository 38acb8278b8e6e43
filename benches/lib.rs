//! What the benchmarks share: mazes, and a server to talk to.

use std::path::Path;

use mmsim_maze::{Catalogue, Maze};
use mmsim_server::{Background, Server, Simulation};

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
