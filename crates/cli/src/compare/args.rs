//! Arguments of `mmsim compare`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use mmsim_solvers::BundledStrategy;

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   compare all strategies in the default mazes
  mmsim compare mazes/                            use the mazes in a folder
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare mazes/ --csv > searches.csv       write a CSV file, one line per search
  mmsim compare mazes/ --json                     print searches and means as JSON

Columns:
  reached    mazes in which the strategy reached the goal, of those with a reachable goal
  given up   mazes in which it reported an unreachable goal, of those with an unreachable goal
  to goal    steps to the goal
  proven     solved mazes in which the shortest path was proven
  after      steps until it was proven, mean over these mazes
  in all     steps of the whole search run, without a fast run
  turns      quarter turns in the search run; a turn back counts as two
  path       length of the shortest known path at the end, in steps
  shortest   length of the shortest path in the maze, in steps
  found      solved mazes in which path equals shortest
  µs         processor time of the search in microseconds

Numbers with a decimal are means over the mazes in which the strategy reached the goal.

The exit code is 0 if all mazes could be read, whatever the searches found.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all mazes
    /// in ~/.mmsim if there are any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    /// Comma-separated list of strategies; may be repeated
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = ALL,
        value_parser = strategies()
    )]
    strategies: Vec<Strategies>,
    /// Use N threads; the results do not depend on it [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    /// Print CSV: a header and one line per search
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

/// The value of `--strategies` for all strategies.
const ALL: &str = "all";

/// A value of `--strategies`.
#[derive(Clone, Copy, Debug)]
enum Strategies {
    One(BundledStrategy),
    All,
}

impl CompareArgs {
    /// Returns the selected strategies, each once.
    pub(crate) fn strategies(&self) -> Vec<BundledStrategy> {
        let mut strategies = Vec::new();
        for value in &self.strategies {
            let selected: &[BundledStrategy] = match value {
                Strategies::All => BundledStrategy::ALL,
                Strategies::One(strategy) => std::slice::from_ref(strategy),
            };
            for strategy in selected {
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
    let all = PossibleValue::new(ALL).help("all strategies");
    let values = BundledStrategy::ALL.iter().copied().map(one).chain([all]);
    // The parser accepts only these values.
    PossibleValuesParser::new(values)
        .map(|name| name.parse().map_or(Strategies::All, Strategies::One))
}
