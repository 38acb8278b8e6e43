//! Arguments of `mmsim compare`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_fastrun::Vehicle;
use mmsim_solvers::{BundledStrategy, Tolerance};

use super::candidate::{Candidate, NamedMouse};
use super::own_search::SearchLimits;
use super::search_speed::SearchSpeed;
use crate::args::{one_of, parse_seconds};
use crate::solve::args::strategy_value;
use crate::usage::UsageError;
use crate::vehicle::{VEHICLES, parse_vehicle};

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   compare all strategies in the default mazes
  mmsim compare mazes/ --mouse mine=./my-mouse    compare your own mouse with the strategies
  mmsim compare mazes/ --mouse new=./mouse --mouse \"old=python3 old.py\" --strategies none
  mmsim compare mazes/ --html report.html         write a report with charts and pictures
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare mazes/ --vehicle expert           add the times of fast runs in seconds
  mmsim compare mazes/ --csv > searches.csv       write a CSV file, one line per search
  mmsim compare mazes/ --json                     print searches and statistics as JSON

A mouse is a program for the simulator mms, or a client that connects to the address in the
environment variable MMSIM_ENDPOINT; {endpoint} in its arguments stands for the same address. A
mouse runs once in each maze, in parallel on all processors. It has finished if it has reached the
goal and not moved for two seconds. Failures are counted and listed; the other searches continue.

Means and medians cover the mazes in which all mice reached the goal. Differences, from the first
mouse, cover the mazes in which both reached the goal; the middle half lies between the quartiles.

The exit code is 0 if all mazes could be read, regardless of the results.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all
    /// mazes in ~/.mmsim if there are any, else the bundled mazes]
    pub(crate) mazes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) candidates: CandidateArgs,
    /// Stop a mouse of your own after S seconds in a maze
    #[arg(long, value_name = "S", default_value = "10", value_parser = parse_seconds)]
    time_limit: Duration,
    /// Stop a mouse of your own after N states in a maze: one for each cell that it enters and one for
    /// each turn
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..))]
    max_states: u32,
    /// Run N searches at a time [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!(
            "Calculate the times of fast runs for a vehicle: {VEHICLES}. Without it, \
             fastest-path-search explores for expert"
        )
    )]
    pub(crate) vehicle: Option<Vehicle>,
    /// Seconds per cell and per quarter turn while a mouse searches
    #[arg(long, value_name = "CELL,TURN", default_value = SearchSpeed::DEFAULT, requires = "vehicle")]
    pub(crate) search_speed: SearchSpeed,
    /// Write a report to FILE: one HTML page with tables, charts and pictures
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Write the charts as SVG files to DIR
    #[arg(long, value_name = "DIR")]
    pub(crate) charts: Option<PathBuf>,
    /// Print CSV: a header and one line per search
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

/// The mice to compare.
#[derive(Debug, Args)]
pub(crate) struct CandidateArgs {
    /// Run a mouse of your own: a mouse for mms, or a client of the ZeroMQ protocol. The words of
    /// COMMAND may be quoted; may be repeated
    #[arg(long, value_name = "NAME=COMMAND")]
    mouse: Vec<NamedMouse>,
    /// Comma-separated list of strategies; may be repeated
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "all",
        value_parser = strategies()
    )]
    strategies: Vec<Choice>,
    /// Let fastest-path-search stop exploring when its run is proven to be at most SHARE slower than
    /// the fastest run, such as 3% or 0.03 [default: 0%]
    #[arg(long, value_name = "SHARE")]
    tolerance: Option<Tolerance>,
}

/// A value of `--strategies`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Choice {
    All,
    None,
    One(BundledStrategy),
}

impl CompareArgs {
    /// Returns the limits of the user's mice.
    pub(crate) const fn limits(&self) -> SearchLimits {
        SearchLimits { time: self.time_limit, states: self.max_states }
    }
}

impl CandidateArgs {
    /// Returns the user's mice and then the selected strategies, each once. `command` is the command
    /// for usage errors.
    pub(crate) fn select(&self, command: &'static str) -> Result<Vec<Candidate>, UsageError> {
        let mut strategies: Vec<BundledStrategy> = Vec::new();
        for choice in &self.strategies {
            let chosen = match choice {
                Choice::All => BundledStrategy::ALL,
                Choice::None => &[],
                Choice::One(strategy) => std::slice::from_ref(strategy),
            };
            for strategy in chosen {
                if !strategies.contains(strategy) {
                    strategies.push(*strategy);
                }
            }
        }
        let own = self.mouse.iter().cloned().map(Candidate::Own);
        let bundled = strategies.into_iter().map(Candidate::Bundled);
        let candidates: Vec<Candidate> = own.chain(bundled).collect();
        for (index, candidate) in candidates.iter().enumerate() {
            let name = candidate.name();
            if candidates[..index].iter().any(|other| other.name() == name) {
                let message = format!("two mice are called {name:?}; choose another NAME");
                return Err(UsageError::new(command, message));
            }
        }
        for mouse in &self.mouse {
            if let Some(file) = mouse.program.missing_file() {
                let message = format!("{}: {} does not exist", mouse.name, file.display());
                return Err(UsageError::new(command, message));
            }
        }
        if candidates.is_empty() {
            let message = "no mice: --strategies none requires --mouse";
            return Err(UsageError::new(command, message));
        }
        let uses_vehicle = |candidate: &Candidate| match candidate {
            Candidate::Bundled(strategy) => strategy.uses_vehicle(),
            Candidate::Own(_) => false,
        };
        if self.tolerance.is_some() && !candidates.iter().any(uses_vehicle) {
            let message = "--tolerance has no effect without fastest-path-search";
            return Err(UsageError::new(command, message));
        }
        Ok(candidates)
    }

    /// Returns the tolerance of fastest-path-search.
    pub(crate) fn tolerance(&self) -> Tolerance {
        self.tolerance.unwrap_or_default()
    }
}

fn strategies() -> impl TypedValueParser<Value = Choice> {
    let each = BundledStrategy::ALL.iter().copied().map(Choice::One);
    one_of(each.chain([Choice::All, Choice::None]), |choice| match choice {
        Choice::One(strategy) => strategy_value(strategy),
        Choice::All => PossibleValue::new("all").help("all strategies"),
        Choice::None => PossibleValue::new("none").help("only your own mice"),
    })
}
