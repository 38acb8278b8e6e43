//! Arguments of `mmsim solve`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::PossibleValue;
use mmsim_protocol::DEFAULT_PORT;
use mmsim_solvers::BundledStrategy;

use crate::args::{KnownMazeArgs, one_of, parse_seconds};

#[derive(Debug, Args)]
#[command(override_usage = "mmsim solve <STRATEGY> [OPTIONS]")]
pub(crate) struct SolveArgs {
    /// Search strategy
    #[arg(value_parser = one_of(BundledStrategy::ALL.iter().copied(), strategy_value))]
    pub(crate) strategy: BundledStrategy,
    /// Address of the simulator as tcp://HOST:PORT; the simulator may start later
    #[arg(long, value_name = "ENDPOINT", default_value_t = format!("tcp://127.0.0.1:{DEFAULT_PORT}"))]
    pub(crate) connect: String,
    #[command(flatten)]
    pub(crate) known: KnownMazeArgs,
    /// Give up after sending N states: one for the start and one for each step [default: 10000 for
    /// swing and shortest-path-search, which also return to the start; 1000 for the others]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_steps: Option<u32>,
    /// Wait MS milliseconds after each step and, unless MS is 0, draw each step on the terminal
    #[arg(long, value_name = "MS", default_value_t = 0)]
    pub(crate) pace: u64,
    /// Record the acknowledged states to FILE, which must not exist; view it with `mmsim replay`
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Give up if a reply takes longer than S seconds [default: no limit for the first reply, 10
    /// for each later reply; no limit if started by `mmsim run`]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    pub(crate) timeout: Option<Duration>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Returns the name of a strategy, with its description for the help text.
pub(crate) fn strategy_value(strategy: BundledStrategy) -> PossibleValue {
    PossibleValue::new(strategy.name()).help(strategy.about())
}
