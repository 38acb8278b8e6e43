//! Search strategies for a micromouse, and the flood algorithms that they use.
//!
//! A [`Strategy`] takes the known walls and the pose of the mouse, and returns the next move. A
//! strategy uses no socket, clock or thread, so the same strategy can search a maze in memory, the
//! maze of a simulator, or a real maze. A [`Mouse`] combines a strategy with a map and a pose:
//!
//! ```
//! use mmsim_maze::{KnownMaze, Maze};
//! use mmsim_solvers::{FloodFill, Mouse, SearchDriver};
//!
//! let maze: Maze = "\
//! o---o---o---o
//! |     G     |
//! o   o---o   o
//! | S |       |
//! o---o---o---o
//! ".parse()?;
//! let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(&maze), maze.start());
//! let mut driver = SearchDriver::new(&mut mouse, 1000);
//! while driver.advance_in(&maze)? {}
//! assert_eq!(driver.stats().steps(), 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Floods
//! [`Distances`] holds the distance from each cell to the nearest target. [`Downhill`] finds the
//! next step from each cell without computing distances. [`steps_between`] computes the distance of
//! a single cell. On processors with 64-bit registers, floods operate on bit sets and use the vector
//! [`Instructions`] that the processor supports. On microcontrollers, they operate on bytes.
//!
//! # Ties
//! If several neighbours are equally good, the strategies prefer front, left, right and back, in
//! that order. The example clients of the reference simulator (mmsim 0.1.7, written in Python) have
//! the same preference.
//!
//! # Microcontrollers
//! Without the `std` feature (enabled by default), the crate is `no_std` and never allocates
//! memory. Without the `half-size` feature (enabled by default), mazes have at most 16×16 cells.
//! Strategies can be `static`, and [`Distances::reflood`] floods a maze in place.
#![cfg_attr(not(any(test, feature = "std")), no_std)]
// Marks the items of optional features on docs.rs.
#![cfg_attr(docsrs, feature(doc_cfg))]

mod a_star;
#[cfg(feature = "std")]
mod bundled;
mod driver;
#[cfg(feature = "std")]
mod fastest_path_search;
mod flood;
mod flood_fill;
mod key_point_route;
mod left_wall;
#[cfg(feature = "std")]
mod maze_rules;
mod mouse;
mod path_bounds;
mod proving_search;
mod shortest_path_search;
mod stats;
mod strategy;
mod swing;
mod wall_votes;
mod weight_increment;

pub use a_star::ShortestPath;
#[cfg(feature = "std")]
pub use bundled::{BundledStrategy, UnknownStrategy};
pub use driver::{DriveError, SearchDriver};
#[cfg(feature = "std")]
pub use fastest_path_search::{FastestPathSearch, InvalidTolerance, TimeBounds, Tolerance};
pub use flood::{Distances, Downhill, Instructions, steps_between};
pub use flood_fill::FloodFill;
pub use key_point_route::{KeyPointRoute, centre};
pub use left_wall::LeftWall;
#[cfg(feature = "std")]
pub use maze_rules::{MazeRules, MazeViolation};
pub use mouse::{Crash, Mouse};
pub use path_bounds::{MazeFacts, PathBounds, steps_until_proven};
pub use shortest_path_search::ShortestPathSearch;
pub use stats::{PhaseStats, SearchStats};
pub use strategy::{Move, Phase, SearchError, Strategy, open_steps};
pub use swing::Swing;
pub use wall_votes::WallVotes;
pub use weight_increment::WeightIncrement;

/// Tests the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, KnownMaze, Maze, MazeSize, Walls};
    use proptest::prelude::{Strategy as Generator, prop};

    use super::{Mouse, Move, SearchDriver, SearchError, Strategy};

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
        let drawing =
            mouse.map().picture().with_numbers(&weight).with_mouse(mouse.pose()).to_string();
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
        let walls = (1..=max_side, 1..=max_side).prop_flat_map(|(width, height)| {
            random_walls(MazeSize::new(width, height).unwrap(), 0.7)
        });
        let goals = prop::collection::vec((0u8..32, 0u8..32), 0..5);
        (walls, (0u8..32, 0u8..32), goals).prop_map(|(walls, start, goals)| {
            let size = walls.size();
            let inside = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            Maze::new(walls, inside(start), goals.into_iter().map(inside).collect()).unwrap()
        })
    }
}
