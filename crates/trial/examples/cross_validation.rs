//! Evaluates the champion on mazes outside its training set.
//!
//! The mazes are divided into two halves. Blocks of eight successive mazes stay together, because
//! mazes of the same contest are adjacent in the list. A [`WallPrior`] is learnt from each half.
//! The champion then uses this prior in the mazes of the other half, with several seeds. For
//! comparison, the example also runs the `proven` robot, which explores until no faster race is
//! possible.
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example cross_validation -- MAZES...
//! ```

use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{Champion, StoppingRule, TrialOutcome, WallPrior, race_optimum, run_trial};
use rayon::prelude::*;

const BLOCK: usize = 8;
const SEEDS: u64 = 4;

fn main() -> Result<(), Box<dyn Error>> {
    let mut mazes: Vec<Maze> = Vec::new();
    for path in std::env::args().skip(1) {
        for entry in Catalogue::from_path(Path::new(&path))?.entries() {
            mazes.push(entry.maze()?);
        }
    }
    mazes.retain(|maze| race_optimum(maze.walls(), maze.start().cell, maze.goals()).is_some());
    if mazes.len() <= BLOCK {
        return Err(
            format!("found {} solvable mazes, need at least {}", mazes.len(), BLOCK + 1).into()
        );
    }
    let priors = [0, 1].map(|test_half| {
        let training = mazes.iter().enumerate().filter(|&(index, _)| half(index) != test_half);
        WallPrior::learn(training.map(|(_, maze)| maze))
    });
    println!(
        "{} mazes; mean score for each seed from 0 to {}, and overall mean",
        mazes.len(),
        SEEDS - 1
    );
    let print = |name: &str, rule, seeds| {
        let means: Vec<f64> = (0..seeds).map(|seed| mean(&mazes, &priors, rule, seed)).collect();
        let columns: Vec<String> = means.iter().map(|mean| format!("{mean:.3}")).collect();
        #[allow(clippy::cast_precision_loss)]
        let overall = means.iter().sum::<f64>() / means.len() as f64;
        println!("{name:22} {}  {overall:.3}", columns.join(" "));
    };
    // The `proven` robot does not use the seed.
    print("proven", StoppingRule::Proven, 1);
    print("champion", StoppingRule::default(), SEEDS);
    Ok(())
}

/// Returns the half, 0 or 1, to which the maze with this index belongs.
const fn half(index: usize) -> usize {
    index / BLOCK % 2
}

/// Returns the mean score over all mazes. In each maze, the champion uses the prior that was learnt
/// from the other half. A trial without a score makes the mean infinite.
fn mean(mazes: &[Maze], priors: &[WallPrior; 2], rule: StoppingRule, seed: u64) -> f64 {
    let score = |(index, maze): (usize, &Maze)| {
        let prior = priors[half(index)].clone();
        let mut robot = Champion::new(KnownMaze::unexplored(maze), rule, prior, 0., seed);
        match run_trial(maze, &mut robot) {
            TrialOutcome::Scored(score) => score.value(),
            _ => f64::INFINITY,
        }
    };
    let scores: f64 = mazes.par_iter().enumerate().map(score).sum();
    #[allow(clippy::cast_precision_loss)]
    let count = mazes.len() as f64;
    scores / count
}
