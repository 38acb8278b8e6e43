//! Measures how the score of the champion depends on its seed.
//!
//! Runs the champion in each maze with the seeds 0 to 255 and prints the mean, the standard
//! deviation, the minimum and the maximum of the scores, followed by the most frequent results in
//! the form "trials x (exploration steps + race steps)". The last row covers the sums of the scores
//! over all mazes.
//!
//! ```sh
//! cargo run --release -p mmsim-trial --example seed_scores -- MAZES...
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use mmsim_formats::Catalogue;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_trial::{BundledRobot, Score, Settings, TrialOutcome, run_trial};
use rayon::prelude::*;

const SEEDS: u64 = 256;
/// The number of results listed for each maze.
const FREQUENT: usize = 4;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:20} {:>7} {:>7} {:>7} {:>7}  frequent results", "", "mean", "sd", "min", "max");
    let mut sums = vec![0.; usize::try_from(SEEDS)?];
    for path in std::env::args().skip(1) {
        for entry in Catalogue::from_path(Path::new(&path))?.entries() {
            let maze = entry.maze()?;
            let scores: Option<Vec<Score>> =
                (0..SEEDS).into_par_iter().map(|seed| score(&maze, seed)).collect();
            let scores = scores.ok_or_else(|| format!("{}: no score", entry.name()))?;
            let values: Vec<f64> = scores.iter().map(|score| score.value()).collect();
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
            println!("{:20} {}  {}", entry.name(), statistics(&values), frequent(&scores));
        }
    }
    println!("{:20} {}", "sum", statistics(&sums));
    Ok(())
}

/// Returns the score of the champion, or `None` if the trial ended without a score.
fn score(maze: &Maze, seed: u64) -> Option<Score> {
    let settings = Settings { seed, ..Settings::default() };
    let mut champion = BundledRobot::Champion.robot(KnownMaze::unexplored(maze), &settings);
    match run_trial(maze, &mut champion) {
        TrialOutcome::Scored(score) => Some(score),
        _ => None,
    }
}

/// Returns the mean, the standard deviation, the minimum and the maximum as table columns.
fn statistics(values: &[f64]) -> String {
    #[allow(clippy::cast_precision_loss)]
    let mean_of =
        |values: &mut dyn Iterator<Item = f64>, count: usize| values.sum::<f64>() / count as f64;
    let mean = mean_of(&mut values.iter().copied(), values.len());
    let variance = mean_of(&mut values.iter().map(|value| (value - mean).powi(2)), values.len());
    let min = values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{mean:7.3} {:7.3} {min:7.3} {max:7.3}", variance.sqrt())
}

/// Lists the most frequent scores.
fn frequent(scores: &[Score]) -> String {
    let mut counts = BTreeMap::new();
    for &Score { explore_steps, race_steps } in scores {
        *counts.entry((explore_steps, race_steps)).or_insert(0) += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let result =
        |&((explore, race), count): &((u32, u32), u32)| format!("{count} x ({explore} + {race})");
    counts.iter().take(FREQUENT).map(result).collect::<Vec<_>>().join(", ")
}
