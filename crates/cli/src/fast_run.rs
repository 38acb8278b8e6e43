//! `mmsim fast-run`: the fastest run through a maze, in seconds.

mod c_array;
mod driven;
mod picture;
mod report;
mod text;

use std::error::Error;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_compare::{NamedMaze, map_each};
use mmsim_fastrun::{MotionState, Planners, Trajectory, Vehicle};
use mmsim_maze::MazeSize;

use crate::args::{CommandResult, UsageError, each_once, one_of};
use crate::output::{
    check_folder, csv_text, is_standard, print, print_pretty_json, replace_or_print, warn,
};
use crate::selection::{DEFAULT_MAZES, Inputs, MAZES_HELP};
use crate::vehicle::{GivenVehicle, VEHICLES, each_vehicle_once, parse_given_vehicle, warn_about};
use driven::{DrivenRun, RouteChoice, RunResult};
use picture::PictureArgs;
use report::FastRunReport;

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
  mmsim fast-run search.mcap                      use the walls that a recorded mouse knows
  mmsim fast-run --vehicle expert --print-vehicle > my-mouse.toml

The time from rest to rest includes the start and the stop. The time from gate to gate, which
contests measure, begins when the mouse leaves the start cell and ends when it enters the goal.

The exit code is 0 if all mazes could be read and have a run.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct FastRunArgs {
    #[arg(
        value_name = "MAZE",
        help = format!("{MAZES_HELP}, or recordings [default: all in {DEFAULT_MAZES}]")
    )]
    mazes: Vec<PathBuf>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_given_vehicle,
        help = format!("Vehicle: {VEHICLES}; may be repeated [default: {}]", Vehicle::DEFAULTS)
    )]
    vehicle: Vec<GivenVehicle>,
    /// Comma-separated list of routes to drive; may be repeated
    #[arg(long, default_value = "fastest", value_delimiter = ',', value_parser = routes())]
    route: Vec<&'static [RouteChoice]>,
    /// List the straights and turns of each run
    #[arg(long)]
    explain: bool,
    /// Print a JSON array
    #[arg(long)]
    json: bool,
    /// Write the pose, speed, acceleration and angular velocity over time to a CSV file; - for stdout
    #[arg(long, value_name = "FILE", group = "csv_file")]
    csv: Option<PathBuf>,
    /// Time between two lines of the CSV file in milliseconds, 0.1 to 1000
    #[arg(long, value_name = "MS", default_value = "1", requires = "csv_file", value_parser = parse_interval)]
    interval: f64,
    /// Write the straights and turns as an array to a C file; - for stdout
    #[arg(long, value_name = "FILE")]
    c_array: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Print the vehicle as TOML, as a starting point for a file of your own, and exit
    #[arg(long, conflicts_with_all = ["mazes", "route", "explain", "json", "csv", "c_array", "output"])]
    print_vehicle: bool,
}

impl FastRunArgs {
    /// Returns the planners of the selected vehicles, each once, or those of the default vehicles.
    fn planners(&self) -> Result<Vec<Planners>, UsageError> {
        let vehicles = each_vehicle_once(&self.vehicle);
        let vehicles = vehicles.map_err(|error| UsageError::new("fast-run", error))?;
        vehicles.iter().for_each(warn_about);
        if vehicles.is_empty() {
            return Ok(vec![Planners::new(None)]);
        }
        Ok(vehicles.into_iter().map(Some).map(Planners::new).collect())
    }

    /// Returns the selected routes, each once.
    fn routes(&self) -> Vec<RouteChoice> {
        each_once(&self.route)
    }

    /// Returns the option that needs exactly one run, if one is given.
    fn export(&self) -> Option<&'static str> {
        match (&self.csv, &self.c_array) {
            (Some(_), _) => Some("--csv"),
            (None, Some(_)) => Some("--c-array"),
            (None, None) => None,
        }
    }

    /// Returns true if an option other than `--json` prints to stdout. Returns an error if several
    /// options do.
    fn exports_to_stdout(&self) -> Result<bool, UsageError> {
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

pub(crate) fn run(args: &FastRunArgs) -> CommandResult {
    let (planners, routes) = (args.planners()?, args.routes());
    if args.print_vehicle {
        check_single("--print-vehicle", &[("vehicle", planners.len())])?;
        print(&planners[0].for_size(MazeSize::CLASSIC).vehicle().to_toml())?;
        return Ok(true);
    }
    let prints_export = args.exports_to_stdout()?;
    let Inputs { mazes, all_readable } = Inputs::read_with_recordings(&args.mazes);
    if mazes.is_empty() && (args.export().is_some() || args.picture.output.is_some()) {
        return Ok(false);
    }
    if let Some(option) = args.export() {
        let counts = [("maze", mazes.len()), ("vehicle", planners.len()), ("route", routes.len())];
        check_single(option, &counts)?;
        for file in [&args.csv, &args.c_array].into_iter().flatten() {
            if !is_standard(file) {
                check_folder(file)?;
            }
        }
    }
    if let Some(picture) = &args.picture.output {
        args.picture.check(mazes.len(), planners.len() * routes.len())?;
        check_folder(&picture.path)?;
    }
    let results = attempt_all(&mazes, &planners, &routes);
    if let (Some(_), [RunResult { driven: Ok(driven), .. }]) = (args.export(), &results[..]) {
        export(args, driven)?;
    }
    args.picture.write(&results)?;
    let have_runs = results.iter().all(|result| result.driven.is_ok());
    if args.json {
        let reports = results.iter().map(|result| FastRunReport::new(result, args.explain));
        print_pretty_json(&reports.collect::<Vec<_>>())?;
    } else if let [result] = &results[..] {
        match &result.driven {
            Ok(_) if prints_export => {}
            Ok(driven) => print(&text::describe(driven, args.explain))?,
            Err(error) => warn(format_args!("mmsim: {}: {error}", result.maze.path.display())),
        }
    } else if args.explain {
        print(&text::describe_all(&results))?;
    } else if !results.is_empty() {
        print(&text::table(&results))?;
    }
    Ok(all_readable && have_runs)
}

/// Plans each route of each vehicle through each maze, in parallel over the mazes.
fn attempt_all<'a>(
    mazes: &'a [NamedMaze],
    planners: &'a [Planners],
    routes: &[RouteChoice],
) -> Vec<RunResult<'a>> {
    let results = map_each(mazes, |maze| {
        let mut results = Vec::with_capacity(planners.len() * routes.len());
        for planners in planners {
            results.extend(RunResult::each_route(
                maze,
                planners.for_size(maze.maze.size()),
                routes,
            ));
        }
        results
    });
    results.into_iter().flatten().collect()
}

/// Returns an error unless each count is one.
fn check_single(option: &str, counts: &[(&str, usize)]) -> Result<(), UsageError> {
    match counts.iter().find(|(_, count)| *count != 1) {
        None => Ok(()),
        Some((thing, count)) => Err(UsageError::not_one("fast-run", option, thing, *count)),
    }
}

/// Writes the files that the options name.
fn export(args: &FastRunArgs, driven: &DrivenRun) -> Result<(), Box<dyn Error>> {
    if let Some(file) = &args.csv {
        replace_or_print(file, motion_csv(&driven.trajectory, args.interval)?.as_bytes())?;
    }
    if let Some(file) = &args.c_array {
        replace_or_print(file, c_array::c_array(driven, file).as_bytes())?;
    }
    Ok(())
}

/// The columns of the CSV file, with their units.
const CSV_HEAD: [&str; 7] = [
    "time_s",
    "x_mm",
    "y_mm",
    "heading_rad",
    "speed_mm_s",
    "acceleration_mm_s2",
    "angular_velocity_rad_s",
];

/// Formats the motion of the mouse as CSV: its states at regular times, `interval` s apart, and the last
/// one.
fn motion_csv(trajectory: &Trajectory, interval: f64) -> Result<String, Box<dyn Error>> {
    csv_text(|csv| {
        csv.write_record(CSV_HEAD)?;
        trajectory.samples(interval).try_for_each(|motion| {
            let MotionState { time, x, y, heading, speed, acceleration, angular_velocity, .. } =
                motion;
            csv.write_record([
                format!("{time:.6}"),
                format!("{x:.3}"),
                format!("{y:.3}"),
                format!("{heading:.6}"),
                format!("{speed:.2}"),
                format!("{acceleration:.1}"),
                format!("{angular_velocity:.4}"),
            ])
        })
    })
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
