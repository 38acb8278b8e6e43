//! Arguments of `mmsim fast-run`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_fastrun::Vehicle;

use super::driven::RouteChoice;
use super::picture::PictureArgs;
use crate::args::{UsageError, each_once, one_of};
use crate::output::is_standard;
use crate::vehicle::{GivenVehicle, VEHICLES, each_vehicle_once, parse_given_vehicle};

const AFTER_HELP: &str = "\
Examples:
  mmsim fast-run harbour                          time the fastest run of an expert's mouse
  mmsim fast-run harbour --explain                list its straights and turns
  mmsim fast-run harbour --vehicle ares --vehicle my-mouse.toml
  mmsim fast-run \"winding river\" --route all      compare it with the fewest cells and turns
  mmsim fast-run \"winding river\" --route all -o race.gif
                                                  animate a race of all three in real time
  mmsim fast-run mazes/                           time the fastest run through each maze of a folder
  mmsim fast-run harbour --csv run.csv            write the pose and the motion every 1 ms
  mmsim fast-run harbour --c-array final.h        write straights and turns for firmware
  mmsim fast-run --vehicle expert --print-vehicle > my-mouse.toml

The time from rest to rest includes the start and the stop. The time from gate to gate, which
contests measure, begins when the mouse leaves the start cell and ends when it enters the goal.

The exit code is 0 if all mazes could be read and have a run.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct FastRunArgs {
    /// Maze files, folders to search recursively, and words from the path of a maze [default: all
    /// mazes in ~/.mmsim if there are any, else the bundled mazes]
    #[arg(value_name = "MAZE")]
    pub(crate) mazes: Vec<PathBuf>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        default_value = "expert",
        value_parser = parse_given_vehicle,
        help = format!("Vehicle: {VEHICLES}; may be repeated")
    )]
    vehicle: Vec<GivenVehicle>,
    /// Comma-separated list of routes to drive; may be repeated
    #[arg(long, default_value = "fastest", value_delimiter = ',', value_parser = routes())]
    route: Vec<&'static [RouteChoice]>,
    /// List the straights and turns of each run
    #[arg(long)]
    pub(crate) explain: bool,
    /// Print a JSON array
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the pose, speed, acceleration and angular velocity over time to a CSV file; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Time between two lines of the CSV file in milliseconds, 0.1 to 1000
    #[arg(long, value_name = "MS", default_value = "1", requires = "csv", value_parser = parse_interval)]
    pub(crate) interval: f64,
    /// Write the straights and turns as an array to a C file; - for stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) c_array: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Print the vehicle as TOML, as a starting point for a file of your own, and exit
    #[arg(long, conflicts_with_all = ["mazes", "route", "explain", "json", "csv", "c_array", "output"])]
    pub(crate) print_vehicle: bool,
}

impl FastRunArgs {
    /// Returns the selected vehicles, each once.
    pub(crate) fn vehicles(&self) -> Result<Vec<Vehicle>, UsageError> {
        each_vehicle_once(&self.vehicle).map_err(|error| UsageError::new("fast-run", error))
    }

    /// Returns the selected routes, each once.
    pub(crate) fn routes(&self) -> Vec<RouteChoice> {
        each_once(&self.route)
    }

    /// Returns the option that needs exactly one run, if one is given.
    pub(crate) fn export(&self) -> Option<&'static str> {
        match (&self.csv, &self.c_array) {
            (Some(_), _) => Some("--csv"),
            (None, Some(_)) => Some("--c-array"),
            (None, None) => None,
        }
    }

    /// Returns true if an option other than `--json` prints to stdout. Returns an error if several
    /// options do.
    pub(crate) fn exports_to_stdout(&self) -> Result<bool, UsageError> {
        let exports =
            [&self.csv, &self.c_array].map(|file| file.as_deref().is_some_and(is_standard));
        let exports = exports.into_iter().filter(|&is_stdout| is_stdout).count();
        if exports + usize::from(self.json) + usize::from(self.explain) > 1 && exports > 0 {
            let message =
                "only one of --json, --explain, --csv - and --c-array - can print to stdout";
            return Err(UsageError::new("fast-run", message));
        }
        Ok(exports > 0)
    }
}

fn routes() -> impl TypedValueParser<Value = &'static [RouteChoice]> {
    let all = &RouteChoice::ALL;
    one_of(all.chunks(1).chain([&all[..]]), |routes| match routes {
        [route] => PossibleValue::new(route.name()).help(route.about()),
        _ => PossibleValue::new("all").help("all routes"),
    })
}

/// Parses a number of milliseconds. Returns it in seconds.
fn parse_interval(text: &str) -> Result<f64, String> {
    let milliseconds: Option<f64> = text.parse().ok().filter(|ms| (0.1..=1000.0).contains(ms));
    let seconds = milliseconds.map(|ms| ms / 1000.0);
    seconds.ok_or_else(|| "expected a number of milliseconds from 0.1 to 1000".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_limited() {
        assert_eq!(parse_interval("0.5"), Ok(0.0005));
        assert!(
            ["0", "-1", "0.09", "1001", "nan", "1s"].map(parse_interval).iter().all(Result::is_err)
        );
    }
}
