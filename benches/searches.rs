//! Servers and searches for the benchmarks that need a simulator.

use std::ops::ControlFlow;

use mmsim_client::{InMemory, search_run};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, Pose, WyRand};
use mmsim_server::{Background, Server, Simulation};
use mmsim_solvers::{BundledStrategy, Mouse};

use crate::MAX_STATES;

/// Serves a maze on a free port of the loopback interface.
///
/// # Panics
/// Panics if there is no free port.
pub fn serve(maze: Maze) -> Background {
    Server::bind("127.0.0.1", 0).unwrap().spawn(Simulation::new("served", maze))
}

/// A reproducible sequence of searches. The strategies take turns; the maze, the start cell and the
/// goal cell of each search are random.
pub struct Searches<'m> {
    mazes: &'m [Maze],
    rng: WyRand,
    count: usize,
}

impl<'m> Searches<'m> {
    /// Creates a sequence of searches in these mazes.
    pub const fn new(mazes: &'m [Maze]) -> Self {
        Self { mazes, rng: WyRand::new(1), count: 0 }
    }

    /// Runs the next search and calls `observe` with each encoded state.
    ///
    /// # Panics
    /// Panics if there are no mazes.
    pub fn next(&mut self, mut observe: impl FnMut(&[u8])) {
        let maze = &self.mazes[self.rng.index(self.mazes.len())];
        let strategy = BundledStrategy::ALL[self.count % BundledStrategy::ALL.len()];
        let mut cell = || {
            let (width, height) = (maze.size().width().into(), maze.size().height().into());
            let coordinate = |number| u8::try_from(number).unwrap();
            Cell::new(coordinate(self.rng.index(width)), coordinate(self.rng.index(height)))
        };
        let (start, goals) =
            (Pose::new(cell(), Heading::North), [cell()].into_iter().collect::<CellSet>());
        self.count += 1;
        let map = KnownMaze::new(maze.size(), start.cell, goals);
        let mut mouse = Mouse::new(strategy.strategy(), map, start);
        let mut simulation = Simulation::new("", maze.clone());
        let mut transport = InMemory::new(|request, reply| {
            if request.starts_with(b"S") {
                observe(request);
            }
            simulation.handle(request, reply)
        });
        // An unreachable goal is an error, but its states count too.
        let _ =
            search_run(&mut transport, &mut mouse, MAX_STATES, |_, _| ControlFlow::Continue(()));
    }
}
