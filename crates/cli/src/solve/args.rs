//! Arguments of `mmsim solve`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::PossibleValue;
use mmsim_compare::Exploration;
use mmsim_fastrun::Vehicle;
use mmsim_protocol::DEFAULT_PORT;
use mmsim_solvers::{BundledStrategy, Tolerance};

use crate::args::{KnownMazeArgs, UsageError, one_of, parse_seconds};
use crate::connection::ENDPOINT_FORM;
use crate::vehicle::{VEHICLES, parse_vehicle};

#[derive(Debug, Args)]
#[command(override_usage = "mmsim solve <STRATEGY> [OPTIONS]")]
pub(crate) struct SolveArgs {
    /// Search strategy
    #[arg(value_parser = one_of(BundledStrategy::ALL.iter().copied(), strategy_value))]
    pub(crate) strategy: BundledStrategy,
    #[arg(
        long,
        value_name = "ENDPOINT",
        default_value_t = format!("tcp://127.0.0.1:{DEFAULT_PORT}"),
        help = format!("Address of the simulator as {ENDPOINT_FORM}; the simulator may start later")
    )]
    pub(crate) connect: String,
    #[command(flatten)]
    pub(crate) known: KnownMazeArgs,
    /// Give up after sending N states: one for the start and one for each step [default: 10000 for
    /// swing, shortest-path-search and fastest-path-search, which also return to the start; 1000 for
    /// the others]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_steps: Option<u32>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!(
            "Vehicle whose fastest run fastest-path-search explores for: {VEHICLES} [default: expert]"
        )
    )]
    pub(crate) vehicle: Option<Vehicle>,
    /// Let fastest-path-search stop exploring when its run is proven to be at most SHARE slower than
    /// the fastest run, such as 3% or 0.03 [default: 0%]
    #[arg(long, value_name = "SHARE")]
    pub(crate) tolerance: Option<Tolerance>,
    /// Wait MS milliseconds after each step and, unless MS is 0, draw each step on the terminal
    #[arg(long, value_name = "MS", default_value_t = 0)]
    pub(crate) pace: u64,
    /// Record the acknowledged states to FILE, which must not exist; view it with `mmsim replay`
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Record only the states, without the JSON channels for Foxglove and other tools
    #[arg(long, requires = "record")]
    pub(crate) states_only: bool,
    /// Give up if a reply takes longer than S seconds [default: no limit for the first reply, 10
    /// for each later reply; no limit if started by `mmsim run`]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    pub(crate) timeout: Option<Duration>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

impl SolveArgs {
    /// Returns the vehicle and the tolerance, or an error if the strategy uses neither.
    pub(crate) fn exploration(&self) -> Result<Exploration, UsageError> {
        let options =
            [("--vehicle", self.vehicle.is_some()), ("--tolerance", self.tolerance.is_some())];
        let given = options.iter().find(|(_, is_given)| *is_given);
        if let Some((option, _)) = given.filter(|_| !self.strategy.uses_vehicle()) {
            let message =
                format!("{} has no {option}; only fastest-path-search does", self.strategy);
            return Err(UsageError::new("solve", message));
        }
        let vehicle = self.vehicle.clone().unwrap_or_else(Vehicle::expert);
        Ok(Exploration::new(vehicle, self.tolerance.unwrap_or_default()))
    }
}

/// Returns the name of a strategy, with its description for the help text.
pub(crate) fn strategy_value(strategy: BundledStrategy) -> PossibleValue {
    PossibleValue::new(strategy.name()).help(strategy.about())
}
