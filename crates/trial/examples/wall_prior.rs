//! Learns a wall prior from mazes and prints it as the source file `src/champion/contest.rs`:
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example wall_prior -- MAZES... > crates/trial/src/champion/contest.rs
//! ```

use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_maze::Maze;
use mmsim_trial::{WallPrior, race_optimum};

fn main() -> Result<(), Box<dyn Error>> {
    let mut mazes: Vec<Maze> = Vec::new();
    for path in std::env::args().skip(1) {
        for entry in Catalogue::from_path(Path::new(&path))?.entries() {
            mazes.push(entry.maze()?);
        }
    }
    let is_solvable =
        |maze: &&Maze| race_optimum(maze.walls(), maze.start().cell, maze.goals()).is_some();
    let prior = WallPrior::learn(mazes.iter().filter(is_solvable));
    println!("//! The wall probabilities of contest mazes, printed by the example `wall_prior`.\n");
    println!("/// The table of [`WallPrior`](super::wall_prior::WallPrior).");
    println!("pub(super) const WALL: [u8; 256] = [");
    for row in prior.probabilities().chunks(16) {
        let row: Vec<String> = row.iter().map(u8::to_string).collect();
        println!("    {},", row.join(", "));
    }
    println!("];");
    Ok(())
}
