//! Arguments of `mmsim compare`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_solvers::BundledStrategy;

use crate::args::{each_once, one_of};
use crate::solve::args::strategy_value;

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   compare all strategies in the default mazes
  mmsim compare mazes/                            use the mazes in a folder
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare mazes/ --csv > searches.csv       write a CSV file, one line per search
  mmsim compare mazes/ --json                     print searches and means as JSON

Columns:
  reached    mazes in which the strategy reached the goal, of those with a reachable goal
  given up   mazes in which the strategy reported an unreachable goal, of those with an unreachable goal
  to goal    steps to the goal
  proven     solved mazes in which the shortest path was proven
  after      steps until the shortest path was proven, mean over these mazes
  in all     steps of the whole search run, without a fast run
  turns      quarter turns in the search run; a U-turn counts as two
  path       length of the shortest known path at the end, in steps
  shortest   length of the shortest path in the maze, in steps
  found      solved mazes in which path equals shortest
  µs         processor time of the search in microseconds

Numbers with a decimal are means over the mazes in which the strategy reached the goal.

The exit code is 0 if all mazes could be read, whatever the searches found.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all
    /// mazes in ~/.mmsim if there are any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    /// Comma-separated list of strategies; may be repeated
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "all",
        value_parser = strategies()
    )]
    strategies: Vec<Option<BundledStrategy>>,
    /// Use N threads; the results do not depend on N [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// Print CSV: a header and one line per search
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

impl CompareArgs {
    /// Returns the selected strategies without duplicates.
    pub(crate) fn strategies(&self) -> Vec<BundledStrategy> {
        each_once(&self.strategies, BundledStrategy::ALL)
    }
}

fn strategies() -> impl TypedValueParser<Value = Option<BundledStrategy>> {
    one_of(BundledStrategy::ALL.iter().copied().map(Some).chain([None]), |strategy| {
        strategy.map_or(PossibleValue::new("all").help("all strategies"), strategy_value)
    })
}
