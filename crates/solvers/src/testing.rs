//! Helpers for tests of strategies.

use mmsim_maze::{Cell, KnownMaze, Maze, MazeSize, Walls};
use proptest::prelude::{Strategy as Generator, prop};

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

/// Generates walls, of which a random share of up to `max_density` stands.
pub(crate) fn random_walls(size: MazeSize, max_density: f64) -> impl Generator<Value = Walls> {
    let rolls = prop::collection::vec(0.0..1.0, 2 * size.area());
    (rolls, 0.0..max_density).prop_map(move |(rolls, density)| {
        let mut walls = Walls::open(size);
        for (wall, roll) in size.walls().zip(rolls) {
            walls.set(wall.cell, wall.heading, roll < density);
        }
        walls
    })
}

/// Generates mazes whose sides are at most `max_side`, with any start and up to four goals.
pub(crate) fn random_mazes(max_side: usize) -> impl Generator<Value = Maze> {
    let walls = (1..=max_side, 1..=max_side)
        .prop_flat_map(|(width, height)| random_walls(MazeSize::new(width, height).unwrap(), 0.7));
    let goals = prop::collection::vec((0u8..32, 0u8..32), 0..5);
    (walls, (0u8..32, 0u8..32), goals).prop_map(|(walls, start, goals)| {
        let size = walls.size();
        let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
        Maze::new(walls, inside(start), goals.into_iter().map(inside).collect()).unwrap()
    })
}
