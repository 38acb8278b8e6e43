//! `mmsim contest`: mice compete under the rules of a contest.

mod text;

use std::io::Write;
use std::time::Duration;

use clap::Args;
use clap::builder::PossibleValue;
use mmsim_compare::{
    ComparedMouse, Contest, ContestEntry, ContestRun, MazeColumns, MazeResult, RuleSet, Rules,
};
use mmsim_fastrun::Vehicle;
use mmsim_maze::Escaped;
use mmsim_run::Ending;
use serde::Serialize;

use crate::args::{CommandResult, one_of, parse_seconds};
use crate::output::{csv_text, print, print_pretty_json};
use crate::searches::SearchArgs;
use crate::selection::Inputs;
use crate::vehicle::{VEHICLES, parse_vehicle, warn_about};

const AFTER_HELP: &str = "\
Examples:
  mmsim contest harbour                            let all strategies compete in a bundled maze
  mmsim contest mazes/ --rules apec                compete in each maze of a folder, for points
  mmsim contest harbour --mouse mine=./my-mouse    let your own mouse compete with the strategies
  mmsim contest harbour --vehicle ares             let all mice search and run as a hobby mouse
  mmsim contest mazes/ --csv > scores.csv          write a CSV file, one line per mouse and maze
  mmsim contest harbour --json                     print all runs as JSON

Each mouse searches the maze, returns to the start, and then runs as often as the rules and the time
allow. --vehicle sets the speed of its searches and of its fast runs. A mouse that does not return
to the start by itself, is reset or runs into a wall counts as touched. In each maze, a mouse gets
a point for each mouse that it beats. docs/contest.md describes the model and the ranking.

The exit code is 0 if all mazes could be read, regardless of the scores.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct ContestArgs {
    #[command(flatten)]
    search: SearchArgs,
    /// Rules for the score
    #[arg(
        long,
        value_name = "RULES",
        default_value = RuleSet::BestRun.name(),
        value_parser = one_of(RuleSet::ALL, |rules| PossibleValue::new(rules.name()).help(rules.about()))
    )]
    rules: RuleSet,
    /// Give each mouse S seconds of simulated time for its search and all runs [default: by the rules]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    contest_time: Option<Duration>,
    /// Limit the number of runs, including the search run [default: by the rules]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    max_runs: Option<u32>,
    #[arg(
        long,
        value_name = "NAME|FILE",
        value_parser = parse_vehicle,
        help = format!("Vehicle: {VEHICLES} [default: {}]", Vehicle::DEFAULTS)
    )]
    vehicle: Option<Vehicle>,
    /// Print CSV: a header, and one line for each mouse in each maze
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl ContestArgs {
    /// Returns the rules with the given limits.
    fn rules(&self) -> Rules {
        let rules = self.rules.rules();
        Rules {
            time_limit: self.contest_time.map_or(rules.time_limit, |limit| limit.as_secs_f64()),
            max_runs: self.max_runs.or(rules.max_runs),
            ..rules
        }
    }
}

pub(crate) fn run(args: &ContestArgs) -> CommandResult {
    let mice = args.search.select("contest")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.search.mazes);
    let figures = args.search.run(&mice, &mazes, args.vehicle.clone(), false, 1)?;
    args.vehicle.iter().for_each(warn_about);
    let names: Vec<&str> = mice.iter().map(ComparedMouse::name).collect();
    let contest = Contest::new(&names, &mazes, &figures, args.vehicle.clone(), args.rules());
    if args.json {
        print_pretty_json(&contest)?;
    } else if args.csv {
        print(&csv_text(|csv| contest.mazes.iter().try_for_each(|maze| write_csv(maze, csv)))?)?;
    } else if !mazes.is_empty() {
        print(&text::text(&contest))?;
    }
    Ok(all_readable)
}

/// The attempt of a mouse in a maze. The field names are CSV column names.
#[derive(Debug, Serialize)]
struct EntryColumns<'a> {
    vehicle: &'a str,
    rank: Option<usize>,
    mouse: &'a str,
    points: f64,
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
    let MazeColumns { path, maze, width, height } = &result.maze;
    let (path, maze) = (escaped(path), escaped(maze));
    let maze = MazeColumns { path, maze, width: *width, height: *height };
    result.entries.iter().try_for_each(|ContestEntry { rank, mouse, points, attempt }| {
        let best = attempt.best_run();
        let columns = EntryColumns {
            vehicle: &result.vehicle,
            rank: *rank,
            mouse,
            points: *points,
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
