//! `mmsim compare`: compare mice on collections of mazes.

pub(crate) mod args;
mod text;

use std::cell::RefCell;
use std::io::Write;

use args::CompareArgs;
use mmsim_compare::{MouseSummary, NamedMaze, SearchComparison, SearchRow};
use mmsim_drawing::DrivenPath;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::Escaped;
use mmsim_report::MousePath;
use mmsim_run::{Timing, plan};
use serde::Serialize;

use crate::args::CommandResult;
use crate::inputs::Inputs;
use crate::output::{
    check_folder, create_folder, print, print_csv, print_pretty_json, replace, write_charts,
};
use crate::vehicle::warn_about;

pub(crate) fn run(args: &CompareArgs) -> CommandResult {
    let mice = args.search.select("compare")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.mazes);
    // Before searches that may take minutes.
    args.charts.as_deref().map_or(Ok(()), create_folder)?;
    args.html.as_deref().map_or(Ok(()), check_folder)?;
    let vehicle = args.vehicle.clone().unwrap_or_else(Vehicle::expert);
    let figures = args.search.run(&mice, &mazes, vehicle)?;
    let timing = args.vehicle.clone().map(|vehicle| {
        warn_about(&vehicle);
        Timing { vehicle, search_speed: args.search_speed }
    });
    let report = SearchComparison::new(&mice, &mazes, figures, timing.as_ref());
    if args.json {
        print_pretty_json(&report.mice)?;
    } else if args.csv {
        print_csv(|csv| report.mice.iter().try_for_each(|mouse| write_csv(mouse, csv)))?;
    } else if !mazes.is_empty() {
        print(&text::text(&report))?;
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
    struct StrategyColumn<'a> {
        strategy: &'a str,
    }
    let strategy = StrategyColumn { strategy: &mouse.strategy };
    let escaped = |text: &String| Escaped(text).to_string();
    mouse.mazes.iter().cloned().try_for_each(|SearchRow { mut maze, mut figures, times }| {
        (maze.path, maze.name) = (escaped(&maze.path), escaped(&maze.name));
        figures.error = figures.error.as_ref().map(escaped);
        match times {
            Some(times) => csv.serialize((&strategy, maze, figures, times)),
            None => csv.serialize((&strategy, maze, figures)),
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
