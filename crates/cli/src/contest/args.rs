//! Arguments of `mmsim contest`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::PossibleValue;
use mmsim_compare::{RuleSet, Rules};
use mmsim_fastrun::Vehicle;
use mmsim_run::SearchSpeed;

use crate::args::{one_of, parse_seconds};
use crate::searches::SearchArgs;
use crate::vehicle::{VEHICLES, parse_vehicle};

const AFTER_HELP: &str = "\
Examples:
  mmsim contest harbour                            let all strategies compete in a bundled maze
  mmsim contest mazes/ --rules apec                compete in each maze of a folder, add up scores
  mmsim contest harbour --mouse mine=./my-mouse    let your own mouse compete with the strategies
  mmsim contest harbour --vehicle ares --search-speed 0.2,0.1
  mmsim contest mazes/ --csv > scores.csv          write a CSV file, one line per mouse and maze
  mmsim contest harbour --json                     print all runs as JSON

Each mouse searches the maze, returns to the start, and then runs as often as the rules and the time
allow. Steps and turns of the search are timed by --search-speed, fast runs by --vehicle. A mouse
that does not return to the start by itself, is reset or runs into a wall counts as touched.
docs/contest.md describes the model.

The exit code is 0 if all mazes could be read, regardless of the scores.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct ContestArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all
    /// mazes in ~/.mmsim if there are any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) search: SearchArgs,
    /// Rules for the score
    #[arg(
        long,
        value_name = "RULES",
        default_value = RuleSet::BestRun.name(),
        value_parser = one_of(RuleSet::ALL, |rules| PossibleValue::new(rules.name()).help(rules.about()))
    )]
    rules: RuleSet,
    /// Give each mouse S seconds of simulated time for its search and all runs [default: by the rules]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    contest_time: Option<Duration>,
    /// Limit the number of runs, including the search run [default: by the rules]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    max_runs: Option<u32>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        default_value = "expert",
        value_parser = parse_vehicle,
        help = format!("Vehicle: {VEHICLES}")
    )]
    pub(crate) vehicle: Vehicle,
    /// Seconds per cell and per quarter turn while a mouse searches or returns
    #[arg(long, value_name = "CELL,TURN", default_value = SearchSpeed::DEFAULT)]
    pub(crate) search_speed: SearchSpeed,
    /// Print CSV: a header, and one line for each mouse in each maze
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl ContestArgs {
    /// Returns the rules with the given limits.
    pub(crate) fn rules(&self) -> Rules {
        let rules = self.rules.rules();
        Rules {
            time_limit: self.contest_time.map_or(rules.time_limit, |limit| limit.as_secs_f64()),
            max_runs: self.max_runs.or(rules.max_runs),
            ..rules
        }
    }
}
