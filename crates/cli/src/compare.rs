//! `mmsim compare`: compare mice on collections of mazes.

use std::cell::RefCell;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use mmsim_compare::{MouseSummary, NamedMaze, SearchComparison, SearchRow};
use mmsim_drawing::DrivenPath;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::Escaped;
use mmsim_report::MousePath;
use mmsim_run::plan;
use serde::Serialize;

use crate::args::CommandResult;
use crate::grid::aligned;
use crate::output::{
    check_folder, create_folder, csv_text, list_reasons, print, print_pretty_json, replace,
    write_charts,
};
use crate::searches::SearchArgs;
use crate::selection::Inputs;
use crate::vehicle::{VEHICLES, parse_vehicle, warn_about};

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
    #[command(flatten)]
    search: SearchArgs,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!(
            "Calculate the times of fast runs for a vehicle: {VEHICLES}. Without it, \
             fastest-path-search explores for {}",
            Vehicle::DEFAULTS
        )
    )]
    vehicle: Option<Vehicle>,
    /// Stop a mouse of your own when it reaches the goal
    #[arg(long, requires = "mouse")]
    stop_at_goal: bool,
    /// Write a report to FILE: one HTML page with tables, charts and pictures
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the charts as SVG files to DIR
    #[arg(long, value_name = "DIR")]
    charts: Option<PathBuf>,
    /// Print CSV: a header and one line per search
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print a JSON array
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &CompareArgs) -> CommandResult {
    let mice = args.search.select("compare")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.search.mazes);
    // Before searches that may take minutes.
    args.charts.as_deref().map_or(Ok(()), create_folder)?;
    args.html.as_deref().map_or(Ok(()), check_folder)?;
    let figures = args.search.run(&mice, &mazes, args.vehicle.clone(), args.stop_at_goal)?;
    args.vehicle.iter().for_each(warn_about);
    let senses = args.search.senses();
    let report = SearchComparison::new(&mice, &mazes, figures, args.vehicle.as_ref(), &senses);
    if args.json {
        print_pretty_json(&report.mice)?;
    } else if args.csv {
        print(&csv_text(|csv| report.mice.iter().try_for_each(|mouse| write_csv(mouse, csv)))?)?;
    } else if !mazes.is_empty() {
        print(&text(&report))?;
    }
    if mazes.is_empty() {
        return Ok(all_readable);
    }
    if let Some(folder) = &args.charts {
        write_charts(folder, &report.comparison)?;
    }
    if let Some(file) = &args.html {
        replace(file, html(report, &mazes, args.vehicle.as_ref()).as_bytes())?;
    }
    Ok(all_readable)
}

/// Writes each search of a mouse as one line of CSV. Writes a header first if nothing has been written
/// yet. Escapes control characters, so that each search stays on one line.
fn write_csv(mouse: &MouseSummary, csv: &mut csv::Writer<impl Write>) -> csv::Result<()> {
    #[derive(Serialize)]
    struct MouseColumn<'a> {
        mouse: &'a str,
    }
    let name = MouseColumn { mouse: &mouse.mouse };
    let escaped = |text: &String| Escaped(text).to_string();
    mouse.mazes.iter().cloned().try_for_each(|SearchRow { mut maze, mut figures, times }| {
        (maze.path, maze.maze) = (escaped(&maze.path), escaped(&maze.maze));
        figures.error = figures.error.as_ref().map(escaped);
        match times {
            Some(times) => csv.serialize((&name, maze, figures, times)),
            None => csv.serialize((&name, maze, figures)),
        }
    })
}

/// Returns the report as an HTML page, with pictures of the searches or, if there is a vehicle, of the
/// fast runs.
fn html(report: SearchComparison, mazes: &[NamedMaze], vehicle: Option<&Vehicle>) -> String {
    let planner = vehicle.map(|vehicle| RefCell::new(Planner::new(vehicle.clone())));
    let caption = match vehicle {
        Some(_) => "The lines are the fast runs.",
        None => {
            "The lines are whole searches: the search run and, if the mouse returns to the start, the \
             return run."
        }
    };
    report.comparison.with_pictures_caption(caption).html(|mouse, maze| {
        let figures = &report.mice[mouse].mazes[maze].figures;
        let maze = &mazes[maze].maze;
        let Some(planner) = &planner else {
            return Some(MousePath::through_cells(maze, &figures.path));
        };
        let mut planner = planner.borrow_mut();
        let trajectory = plan(&mut planner, maze, &figures.outcome)?;
        let trajectory = trajectory.drive(planner.vehicle()).ok()?;
        Some(MousePath { maze, points: DrivenPath::from_trajectory("", &trajectory).outline() })
    })
}

/// Returns the overview, the notes, the other tables, and the failures of each mouse.
fn text(report: &SearchComparison) -> String {
    let measures = report.measures.iter().zip(&report.statistics);
    let tables = measures.filter(|(measure, _)| measure.is_in_text).map(|(_, statistics)| {
        let differences = match statistics.candidates.len() {
            0 | 1 => "",
            _ => " Differences over the mazes that both mice solved.",
        };
        format!("{}{}{differences}\n", aligned(&statistics.table()), statistics.caption())
    });
    let notes = report.comparison.notes.iter().map(|note| format!("{note}\n"));
    let failures = (0..report.mice.len()).filter_map(|mouse| failures(report, mouse));
    let overview = aligned(&report.comparison.overview);
    [overview].into_iter().chain(notes).chain(tables).chain(failures).collect::<Vec<_>>().join("\n")
}

/// Lists the most frequent reasons why a mouse failed.
fn failures(report: &SearchComparison, mouse: usize) -> Option<String> {
    let MouseSummary { mouse: name, mazes, .. } = &report.mice[mouse];
    let failures = report.comparison.failures().iter().filter(|one| one.candidate == mouse);
    let reasons = failures.map(|one| (&*one.reason, &*mazes[one.maze].maze.path));
    list_reasons(&format!("{name} failed"), reasons)
}
