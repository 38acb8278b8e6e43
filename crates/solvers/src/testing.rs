//! A search in memory, for the strategies' tests.

use mmsim_maze::{KnownMaze, Maze};

use crate::{Mouse, Move, SearchError, Strategy};

/// How a search ended.
pub(crate) struct Outcome {
    /// The last decision.
    pub(crate) result: Result<Move, SearchError>,
    /// Steps taken.
    pub(crate) steps: usize,
    /// The map with weights and mouse.
    pub(crate) drawing: String,
}

/// Searches the maze drawn in `text` until the strategy stops, but takes `max_steps` at most.
pub(crate) fn search(strategy: impl Strategy, text: &str, max_steps: usize) -> Outcome {
    let maze: Maze = text.parse().unwrap();
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
    let mut steps = 0;
    let result = loop {
        mouse.see(maze.walls().around(mouse.pose())).unwrap();
        match mouse.decide() {
            Ok(Move::Step(step)) if steps < max_steps => mouse.go(step).unwrap(),
            result => break result,
        }
        steps += 1;
    };
    let weight = |cell| Some(mouse.weight(cell)).filter(|&weight| weight != u16::MAX);
    let drawing = mouse.map().picture().with_numbers(&weight).with_mouse(mouse.pose()).to_string();
    Outcome { result, steps, drawing }
}
