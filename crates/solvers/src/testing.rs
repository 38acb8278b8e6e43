//! A helper that runs searches in memory to test strategies.

use mmsim_maze::{KnownMaze, Maze};

use crate::driver::SearchDriver;
use crate::mouse::Mouse;
use crate::strategy::{Move, SearchError, Strategy};

/// The outcome of a search.
pub(crate) struct Outcome {
    /// The last decision.
    pub(crate) result: Result<Move, SearchError>,
    /// The number of steps that the mouse has taken.
    pub(crate) steps: u32,
    /// A picture of the map with the weights and the mouse.
    pub(crate) drawing: String,
}

/// Searches the maze drawn in `text` until the strategy stops or the mouse has taken `max_steps`
/// steps.
pub(crate) fn search(strategy: impl Strategy, text: &str, max_steps: u32) -> Outcome {
    let maze: Maze = text.parse().unwrap();
    let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
    let mut driver = SearchDriver::new(&mut mouse, max_steps + 1);
    while driver.advance_in(&maze) == Ok(true) {}
    let (result, steps) = (driver.decision().unwrap(), driver.stats().steps());
    let weight = |cell| mouse.weight(cell);
    let drawing = mouse.map().picture().with_numbers(&weight).with_mouse(mouse.pose()).to_string();
    Outcome { result, steps, drawing }
}
