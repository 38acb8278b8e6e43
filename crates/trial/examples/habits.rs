//! Learns what mazes are like from folders of them, and prints it as `src/champion/contest.rs`
//! holds it:
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example habits -- MAZES... > crates/trial/src/champion/contest.rs
//! ```

use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_maze::Maze;
use mmsim_trial::{Habits, race_optimum};

fn main() -> Result<(), Box<dyn Error>> {
    let mut mazes: Vec<Maze> = Vec::new();
    for folder in std::env::args().skip(1) {
        for entry in Catalogue::from_path(Path::new(&folder))?.entries() {
            mazes.push(entry.maze()?);
        }
    }
    let is_whole =
        |maze: &&Maze| race_optimum(maze.walls(), maze.start().cell, maze.goals()).is_some();
    let habits = Habits::learn(mazes.iter().filter(is_whole));
    println!("//! What contest mazes are like, as the example `habits` learnt it.\n");
    println!("/// See [`Habits`](super::Habits).\npub(super) const WALL: [u8; 256] = [");
    for row in habits.chances().chunks(16) {
        let row: Vec<String> = row.iter().map(u8::to_string).collect();
        println!("    {},", row.join(", "));
    }
    println!("];");
    Ok(())
}
