//! `mmsim contest`: mice compete under the rules of a contest.

pub(crate) mod args;
mod text;

use std::io::Write;

use args::ContestArgs;
use mmsim_compare::{ComparedMouse, Contest, ContestEntry, ContestRun, MazeColumns, MazeResult};
use mmsim_maze::Escaped;
use mmsim_run::{Ending, Timing};
use serde::Serialize;

use crate::args::CommandResult;
use crate::inputs::Inputs;
use crate::output::{print, print_csv, print_pretty_json};
use crate::vehicle::warn_about;

pub(crate) fn run(args: &ContestArgs) -> CommandResult {
    let mice = args.search.select("contest")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.mazes);
    let figures = args.search.run(&mice, &mazes, args.vehicle.clone())?;
    warn_about(&args.vehicle);
    let timing = Timing { vehicle: args.vehicle.clone(), search_speed: args.search_speed };
    let names: Vec<&str> = mice.iter().map(ComparedMouse::name).collect();
    let contest = Contest::new(&names, &mazes, &figures, &timing, args.rules());
    if args.json {
        print_pretty_json(&contest)?;
    } else if args.csv {
        print_csv(|csv| contest.mazes.iter().try_for_each(|maze| write_csv(maze, csv)))?;
    } else if !mazes.is_empty() {
        print(&text::text(&contest))?;
    }
    Ok(all_readable)
}

/// The attempt of a mouse in a maze. The field names are CSV column names.
#[derive(Debug, Serialize)]
struct EntryColumns<'a> {
    rank: Option<usize>,
    mouse: &'a str,
    score_s: Option<f64>,
    /// The times of the run that counts.
    time_s: Option<f64>,
    rest_to_rest_s: Option<f64>,
    start_s: Option<f64>,
    search_run_s: Option<f64>,
    search_time_s: Option<f64>,
    runs: usize,
    touched: bool,
    goal_reached: bool,
    ending: Ending,
    error: Option<String>,
}

/// Writes the attempt of each mouse as one line of CSV, best mice first. Writes a header first if
/// nothing has been written yet. Escapes control characters, so that each attempt stays on one line.
fn write_csv(result: &MazeResult, csv: &mut csv::Writer<impl Write>) -> csv::Result<()> {
    let escaped = |text: &str| Escaped(text).to_string();
    let MazeColumns { path, name, width, height } = &result.maze;
    let (path, name) = (escaped(path), escaped(name));
    let maze = MazeColumns { path, name, width: *width, height: *height };
    result.entries.iter().try_for_each(|ContestEntry { rank, mouse, attempt }| {
        let best = attempt.best_run();
        let columns = EntryColumns {
            rank: *rank,
            mouse,
            score_s: attempt.score_s,
            time_s: best.map(|run| run.time_s),
            rest_to_rest_s: best.and_then(|run: &ContestRun| run.rest_to_rest_s),
            start_s: best.map(|run| run.start_s),
            search_run_s: attempt.runs.first().map(|run| run.time_s),
            search_time_s: attempt.search_time_s,
            runs: attempt.runs.len(),
            touched: attempt.touched,
            goal_reached: attempt.goal_reached,
            ending: attempt.ending,
            error: attempt.error.as_deref().map(escaped),
        };
        csv.serialize((&maze, columns))
    })
}
