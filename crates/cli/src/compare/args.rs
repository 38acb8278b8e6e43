//! The command line of `mmsim compare`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use mmsim_solvers::BundledStrategy;

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   all strategies in the bundled mazes
  mmsim compare mazes/                            in the mazes of a folder
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare mazes/ --csv > searches.csv       a line for each search, for a spreadsheet
  mmsim compare mazes/ --json                     the same and the means, for a program

Columns:
  reached    in how many mazes it reached the goal, of those that have a way to it
  given up   in how many it said that there is no way, of those that have none
  to goal    steps to the goal
  proven     in how many of the mazes it reached the goal in it proved the shortest path
  after      steps until it had proven that, the mean over these
  in all     steps of the whole search run, without a fast run
  turns      quarter turns in it; turning round is two
  path       steps of the shortest path over what was known at the end
  shortest   steps of the shortest path that there is
  found      in how many mazes these two are the same
  µs         processor time of the search, in microseconds

The numbers with a decimal are means over the mazes in which the strategy reached the goal.

Exit code 0 says that all mazes could be read and were searched, however that went.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    /// Maze files, folders, which are searched with their subfolders, and words of the path of a
    /// maze [default: all mazes of ~/.mmsim where that holds any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    /// The strategies, parted by commas; may be given several times
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = ALL,
        value_parser = strategies()
    )]
    strategies: Vec<Strategies>,
    /// Search in this many threads, at least 1; the results are the same [default: the number of
    /// processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// Print CSV: a header, and a line for each search
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

/// The value of `--strategies` that is no name.
const ALL: &str = "all";

/// A value of `--strategies`.
#[derive(Clone, Copy, Debug)]
enum Strategies {
    One(BundledStrategy),
    All,
}

impl CompareArgs {
    /// The strategies that are asked for, each once.
    pub(crate) fn strategies(&self) -> Vec<BundledStrategy> {
        let mut strategies = Vec::new();
        for asked in &self.strategies {
            let asked: &[BundledStrategy] = match asked {
                Strategies::All => BundledStrategy::ALL,
                Strategies::One(strategy) => std::slice::from_ref(strategy),
            };
            for strategy in asked {
                if !strategies.contains(strategy) {
                    strategies.push(*strategy);
                }
            }
        }
        strategies
    }
}

fn strategies() -> impl TypedValueParser<Value = Strategies> {
    let one =
        |strategy: BundledStrategy| PossibleValue::new(strategy.name()).help(strategy.about());
    let all = PossibleValue::new(ALL).help("all of them");
    let values = BundledStrategy::ALL.iter().copied().map(one).chain([all]);
    // Nothing but these is let through.
    PossibleValuesParser::new(values)
        .map(|name| name.parse().map_or(Strategies::All, Strategies::One))
}
