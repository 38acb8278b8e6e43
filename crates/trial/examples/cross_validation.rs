//! Judges the champion on mazes that it has not learnt from: mazes are dealt into two halves, in
//! blocks of eight since those of one contest stand together; what walls are like is learnt from one
//! half, and the champion tried in the other with several seeds, then the other way round. Beside it
//! stands the robot that explores until no faster race is possible.
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example cross_validation -- MAZES...
//! ```

use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{Champion, Ending, Habits, Rule, race_optimum, try_robot};
use rayon::prelude::*;

const BLOCK: usize = 8;
const SEEDS: u64 = 4;
const WORTHS: [f64; 5] = [0.8, 1.0, 1.2, 1.5, 2.0];

fn main() -> Result<(), Box<dyn Error>> {
    let mut mazes: Vec<Maze> = Vec::new();
    for path in std::env::args().skip(1) {
        for entry in Catalogue::from_path(Path::new(&path))?.entries() {
            mazes.push(entry.maze()?);
        }
    }
    mazes.retain(|maze| race_optimum(maze.walls(), maze.start().cell, maze.goals()).is_some());
    if mazes.len() <= BLOCK {
        return Err("expected paths of more mazes than a block of eight".into());
    }
    let habits = [0, 1].map(|tried| {
        let learnt = mazes.iter().enumerate().filter(|&(index, _)| half(index) != tried);
        Habits::learn(learnt.map(|(_, maze)| maze))
    });
    println!("{} mazes; mean score by seed, 0 to {}, and of all", mazes.len(), SEEDS - 1);
    let print = |name: &str, rule, seeds| {
        let means: Vec<f64> = (0..seeds).map(|seed| mean(&mazes, &habits, rule, seed)).collect();
        let columns: Vec<String> = means.iter().map(|mean| format!("{mean:.3}")).collect();
        #[allow(clippy::cast_precision_loss)]
        let all = means.iter().sum::<f64>() / means.len() as f64;
        println!("{name:22} {}  {all:.3}", columns.join(" "));
    };
    // It does not depend on the seed.
    print("proven", Rule::Proven, 1);
    for worth in WORTHS {
        print(&format!("champion, worth {worth:.1}"), Rule::Worth(worth), SEEDS);
    }
    Ok(())
}

/// The half that a maze is in.
const fn half(index: usize) -> usize {
    index / BLOCK % 2
}

/// The mean score over all mazes, each with what was learnt from the half that it is not in; a
/// trial without a score makes it infinite.
fn mean(mazes: &[Maze], habits: &[Habits; 2], rule: Rule, seed: u64) -> f64 {
    let score = |(index, maze): (usize, &Maze)| {
        let habits = habits[half(index)].clone();
        let mut robot = Champion::new(KnownMaze::unexplored(maze), rule, habits, 0., seed);
        match try_robot(maze, &mut robot) {
            Ending::Scored(score) => {
                f64::from(score.race_steps) + f64::from(score.explore_steps) / 30.
            }
            Ending::OutOfTime | Ending::GaveUp => f64::INFINITY,
        }
    };
    let scores: f64 = mazes.par_iter().enumerate().map(score).sum();
    #[allow(clippy::cast_precision_loss)]
    let number = mazes.len() as f64;
    scores / number
}
