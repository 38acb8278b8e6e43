//! `mmsim compare`: compare mice on collections of mazes.

mod side_by_side;

use std::cell::RefCell;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_compare::{
    Baseline, Change, ComparedMouse, MouseSummary, NamedMaze, SearchComparison, SearchRow,
};
use mmsim_drawing::DrivenPath;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{Escaped, counted};
use mmsim_report::{MeasureStatistics, MousePath};
use mmsim_run::plan;
use mmsim_solvers::Tolerance;
use serde::Serialize;

use crate::args::CommandResult;
use crate::grid::{stacked, wrapped};
use crate::output::{
    check_folder, create_folder, csv_text, print, print_pretty_json, replace, warn, write_charts,
};
use crate::searches::SearchArgs;
use crate::selection::Inputs;
use crate::vehicle::{GivenVehicle, VEHICLES, parse_given_vehicle, warn_about};

const AFTER_HELP: &str = "\
Examples:
  mmsim compare                                   compare all strategies in the default mazes
  mmsim compare mazes/ --mouse mine=./my-mouse    compare your own mouse with the strategies
  mmsim compare mazes/ --mouse new=./mouse --mouse \"old=python3 old.py\" --strategies none
  mmsim compare mazes/ --html report.html         write a report with charts and pictures
  mmsim compare harbour my-maze.txt --strategies flood-fill,swing
  mmsim compare --open harbour --strategies flood-fill,swing
                                                  show both searches side by side in a browser
  mmsim compare mazes/ --vehicle ares             let all mice search and run as a hobby mouse
  mmsim compare mazes/ --tables                   add tables of all measures
  mmsim compare mazes/ --save base.json           save the results
  mmsim compare mazes/ --against base.json        fail if a mouse has become worse since
  mmsim compare mazes/ --csv > searches.csv       write a CSV file, one line per search
  mmsim compare mazes/ --json                     print searches and statistics as JSON

A mouse is a program for the simulator mms, or a client that connects to the address in the
environment variable MMSIM_ENDPOINT; {endpoint} in its arguments stands for the same address. A
mouse runs once in each maze, in parallel on all processors. It has finished if it has reached the
goal and not moved for two seconds. Failures are counted and listed; the other searches continue.

Mice are ranked by the mazes that they solved, then by the time that they lose to the best possible:
the shortest search of all mice in the maze, followed by the fastest run of the maze. A mouse that
does not return to the start is carried back. docs/compare.md explains all figures.

The exit code is 0 if all mazes could be read, regardless of the results. With --against, it is 1 if
a mouse does not solve a maze any more, or takes longer there than --allow accepts.";

/// The group of `--open`, which clap requires even beside arguments that conflict with it.
const OPENING: &str = "opening";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    search: SearchArgs,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_given_vehicle,
        help = format!("Vehicle: {VEHICLES} [default: {}]", Vehicle::DEFAULTS)
    )]
    vehicle: Option<GivenVehicle>,
    /// Stop a mouse of your own when it reaches the goal
    #[arg(long, requires = "mouse")]
    stop_at_goal: bool,
    /// Add tables of all measures, and name all mazes that a mouse did not solve
    #[arg(long, conflicts_with_all = ["json", "csv"])]
    tables: bool,
    /// Show the searches in one maze side by side in a browser, until Ctrl-C
    #[arg(
        long,
        group = OPENING,
        conflicts_with_all = [
            "misread", "misread_fixed", "misread_seed", "recover", "tables", "json", "csv", "html",
            "charts", "repeat", "save", "against", "allow",
            "max_states", "jobs",
        ]
    )]
    open: bool,
    /// Port of the viewer page; 0 picks a free port [default: 6575, or a free port if 6575 is in use]
    #[arg(long, value_name = "PORT", requires = OPENING)]
    viewer_port: Option<u16>,
    /// Run each mouse of your own N times in each maze, and report the mazes in which its runs differ
    #[arg(long, value_name = "N", default_value_t = 1, requires = "mouse", value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Write a report to FILE: one HTML page with tables, charts and pictures
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the charts as SVG files to DIR
    #[arg(long, value_name = "DIR")]
    charts: Option<PathBuf>,
    /// Save the results to FILE as JSON, for a later comparison with --against
    #[arg(long, value_name = "FILE", conflicts_with_all = ["against", "allow"])]
    save: Option<PathBuf>,
    /// Report in which mazes the mice are better and worse than in FILE, which --save has written
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Accept times that are up to SHARE longer than in the file of --against, such as 5% or 0.05
    #[arg(long, value_name = "SHARE", default_value_t = Tolerance::ZERO, requires = "against")]
    allow: Tolerance,
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
    [&args.html, &args.save].into_iter().flatten().try_for_each(|file| check_folder(file))?;
    let baseline = args.against.as_deref().map(|file| read_baseline(file, &mice)).transpose()?;
    if args.open && (all_readable || !mazes.is_empty()) {
        return side_by_side::open(args, &mice, &mazes);
    }
    let vehicle = args.vehicle.as_ref().map(|given| given.vehicle.clone());
    let figures =
        args.search.run(&mice, &mazes, vehicle.clone(), args.stop_at_goal, args.repeat)?;
    vehicle.iter().for_each(warn_about);
    let senses = args.search.senses();
    let mut report = SearchComparison::new(&mice, &mazes, figures, vehicle.clone(), &senses);
    if let Some(file) = &args.save {
        if !all_readable {
            let file = Escaped(file.display());
            return Err(format!("{file} was not written, because a maze could not be read").into());
        }
        replace(file, &serde_json::to_vec_pretty(&report.mice)?)?;
    }
    let mut is_worse = false;
    if let (Some(baseline), Some(file)) = (&baseline, &args.against) {
        let names = report.comparison.mazes();
        for mouse in &mut report.mice {
            mouse.changes = baseline.changes(mouse, names)?;
            is_worse |= warn_of_changes(mouse, file, args.allow);
        }
    }
    if args.json {
        print_pretty_json(&report.mice)?;
    } else if args.csv {
        print(&csv_text(|csv| report.mice.iter().try_for_each(|mouse| write_csv(mouse, csv)))?)?;
    } else if !mazes.is_empty() {
        print(&text(&report, args))?;
    }
    if mazes.is_empty() {
        return Ok(all_readable);
    }
    if let Some(folder) = &args.charts {
        write_charts(folder, &report.comparison)?;
    }
    if let Some(file) = &args.html {
        replace(file, html(report, &mazes, vehicle).as_bytes())?;
    }
    Ok(all_readable && !is_worse)
}

/// Reads a saved comparison, which must have one of the mice.
fn read_baseline(file: &Path, mice: &[ComparedMouse]) -> Result<Baseline, String> {
    let path = Escaped(file.display().to_string());
    let bytes = fs::read(file).map_err(|error| format!("cannot read {path}: {error}"))?;
    let baseline: Baseline = serde_json::from_slice(&bytes).map_err(|error| {
        format!("{path}: expected the JSON that `mmsim compare --save` writes: {error}")
    })?;
    for name in mice.iter().map(ComparedMouse::name).filter(|name| !baseline.has(name)) {
        let names = baseline.names();
        warn(format_args!("{path} has no mouse called {name}, but {names}"));
    }
    let is_known = |mouse: &ComparedMouse| baseline.has(mouse.name());
    let has_any = mice.iter().any(is_known);
    has_any.then_some(baseline).ok_or_else(|| format!("{path} has none of these mice"))
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
    mouse.mazes.iter().cloned().try_for_each(
        |SearchRow { mut maze, mut figures, times, .. }| {
            (maze.path, maze.maze) = (escaped(&maze.path), escaped(&maze.maze));
            figures.error = figures.error.as_ref().map(escaped);
            match times {
                Some(times) => csv.serialize((&name, maze, figures, times)),
                None => csv.serialize((&name, maze, figures)),
            }
        },
    )
}

/// Returns the report as an HTML page, with pictures of the searches or, if there is a vehicle, of the
/// fast runs.
fn html(report: SearchComparison, mazes: &[NamedMaze], vehicle: Option<Vehicle>) -> String {
    let planner = vehicle.map(|vehicle| RefCell::new(Planner::new(vehicle)));
    let caption = match planner {
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

/// Returns the ranking, what each mouse loses where, and, if they were asked for, all tables.
fn text(report: &SearchComparison, args: &CompareArgs) -> String {
    let notes: String = report.notes.iter().map(|note| wrapped(note, " ", 2) + "\n").collect();
    let ranking = stacked(&report.comparison.overview) + &notes;
    let verdicts = report.ranked().into_iter().map(|mouse| verdict(report, mouse, args)).collect();
    let changes: String = report.mice.iter().filter_map(|mouse| changes(mouse, args)).collect();
    let tables = report.statistics.iter().map(table);
    let tables = [stacked(&report.overview)].into_iter().chain(tables).filter(|_| args.tables);
    let changes = Some(changes).filter(|text| !text.is_empty());
    [ranking, verdicts].into_iter().chain(changes).chain(tables).collect::<Vec<_>>().join("\n")
}

/// Prints to stderr why a mouse is worse than in the saved comparison, and returns true if it is.
fn warn_of_changes(mouse: &MouseSummary, file: &Path, allowed: Tolerance) -> bool {
    let Some(changes) = &mouse.changes else { return false };
    let (name, file) = (Escaped(&mouse.mouse), Escaped(file.display()));
    if changes.is_empty() {
        warn(format_args!("{file} has none of the mazes of {name}"));
        return true;
    }
    if changes.missing_mazes > 0 {
        let missing = counted(changes.missing_mazes, "maze");
        warn(format_args!("{name} has not searched {missing} of {file}"));
        return true;
    }
    let exceeding: Vec<_> = changes.exceeding(allowed.ratio()).map(Change::text).collect();
    if let Some(first) = exceeding.first() {
        let mazes = counted(exceeding.len(), "maze");
        warn(format_args!(
            "{name} is worse than {file} by more than {allowed} in {mazes}: {first}"
        ));
    }
    !exceeding.is_empty()
}

/// Returns what is better and worse for a mouse than in the saved comparison.
fn changes(mouse: &MouseSummary, args: &CompareArgs) -> Option<String> {
    let (changes, file) = (mouse.changes.as_ref()?, args.against.as_ref()?);
    let name = Escaped(&mouse.mouse);
    let head = format!("{name} against {}: {}", Escaped(file.display()), changes.counts());
    let worse = changes.worse.iter().map(|change| format!("  worse: {}", change.text()));
    let better = changes.better.iter().map(|change| format!("  better: {}", change.text()));
    let lines = [head].into_iter().chain(worse).chain(better);
    Some(lines.map(|line| wrapped(&line, " ", 4) + "\n").collect())
}

/// Returns why a mouse loses time, in which mazes, and the command that shows one of them.
fn verdict(report: &SearchComparison, mouse: &MouseSummary, args: &CompareArgs) -> String {
    let MouseSummary { mouse: name, ranking, .. } = mouse;
    let why = wrapped(&format!("{}: {}", Escaped(name), ranking.why()), " ", 2);
    let mazes = ranking.mazes(args.tables);
    let mazes = mazes.iter().map(|line| wrapped(&format!("  {line}"), " ", 4));
    let misreads = args.search.senses().misreadings.probability > 0.0;
    let command = side_by_side::command(report, args, mouse).filter(|_| !misreads);
    [why].into_iter().chain(mazes).chain(command).map(|line| line + "\n").collect()
}

/// Returns the table of a measure.
fn table(statistics: &MeasureStatistics) -> String {
    let (table, caption) = (stacked(&statistics.table()), wrapped(&statistics.caption(), " ", 2));
    format!("{}\n{table}{caption}\n", statistics.measure.heading())
}
