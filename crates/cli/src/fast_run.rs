//! `mmsim fast-run`: the fastest run through a maze, in seconds.

pub(crate) mod args;
mod c_array;
mod driven;
mod picture;
mod report;
mod text;

use std::error::Error;

use mmsim_compare::{NamedMaze, map_each};
use mmsim_fastrun::{MotionState, Planner, Trajectory, Vehicle};

use crate::args::{CommandResult, UsageError};
use crate::output::{
    check_folder, csv_text, is_standard, print, print_pretty_json, replace_or_print, warn,
};
use crate::selection::Inputs;
use crate::vehicle::warn_about;
use args::FastRunArgs;
use driven::{DrivenRun, RouteChoice, RunResult};
use report::FastRunReport;

pub(crate) fn run(args: &FastRunArgs) -> CommandResult {
    let (vehicles, routes) = (args.vehicles()?, args.routes());
    vehicles.iter().for_each(warn_about);
    if args.print_vehicle {
        check_single("--print-vehicle", &[("vehicle", vehicles.len())])?;
        print(&vehicles[0].to_toml())?;
        return Ok(true);
    }
    let prints_export = args.exports_to_stdout()?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.mazes);
    if let Some(option) = args.export() {
        if mazes.is_empty() {
            return Ok(false);
        }
        let counts = [("maze", mazes.len()), ("vehicle", vehicles.len()), ("route", routes.len())];
        check_single(option, &counts)?;
        for file in [&args.csv, &args.c_array].into_iter().flatten() {
            if !is_standard(file) {
                check_folder(file)?;
            }
        }
    }
    if let Some(picture) = &args.picture.output {
        if mazes.is_empty() {
            return Ok(false);
        }
        args.picture.check(mazes.len(), vehicles.len() * routes.len())?;
        check_folder(&picture.path)?;
    }
    let results = attempt_all(&mazes, &vehicles, &routes);
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
    vehicles: &'a [Vehicle],
    routes: &[RouteChoice],
) -> Vec<RunResult<'a>> {
    let planners: Vec<(&Vehicle, Planner)> =
        vehicles.iter().map(|vehicle| (vehicle, Planner::new(vehicle.clone()))).collect();
    let results = map_each(mazes, |maze| {
        let mut results = Vec::with_capacity(planners.len() * routes.len());
        for (vehicle, planner) in &planners {
            let mut planner = planner.clone();
            results.extend(RunResult::each_route(maze, vehicle, &mut planner, routes));
        }
        results
    });
    results.into_iter().flatten().collect()
}

/// Returns an error unless each count is one.
fn check_single(option: &str, counts: &[(&str, usize)]) -> Result<(), UsageError> {
    match counts.iter().find(|(_, count)| *count != 1) {
        None => Ok(()),
        Some((thing, count)) => {
            let message = format!("{option} takes one {thing}, found {count}");
            Err(UsageError::new("fast-run", message))
        }
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
