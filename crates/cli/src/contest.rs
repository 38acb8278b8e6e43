//! `mmsim contest`: mice compete under the rules of a contest.

pub(crate) mod args;
mod attempt;
mod rules;
mod standings;
mod text;

use args::ContestArgs;
use attempt::Attempt;
use mmsim_fastrun::Planner;
use rules::Rules;
use serde::Serialize;
use standings::{MazeResult, Standing};

use crate::compare::candidate::Candidate;
use crate::compare::search_speed::SearchSpeed;
use crate::compare::{search_all, unique_names};
use crate::exploration::Exploration;
use crate::inputs::Inputs;
use crate::output::{print, print_csv, print_pretty_json};
use crate::parallel::map_each;
use crate::usage::CommandResult;
use crate::vehicle::warn_about;

/// The results of a contest. The field names are JSON keys.
#[derive(Debug, Serialize)]
struct Contest {
    rules: &'static str,
    time_limit_s: f64,
    max_runs: Option<u32>,
    search_share: f64,
    touch_penalty_s: f64,
    vehicle: String,
    search_speed: SearchSpeed,
    standings: Vec<Standing>,
    mazes: Vec<MazeResult>,
    /// The names of the mazes whose goal is unreachable.
    skipped: Vec<String>,
}

pub(crate) fn run(args: &ContestArgs) -> CommandResult {
    let candidates = args.candidates.select("contest")?;
    let Inputs { mazes, all_readable } = Inputs::read_distinct_or_default(&args.mazes);
    let rules = args.rules();
    let exploration = Exploration::new(args.vehicle.clone(), args.candidates.tolerance());
    let figures = search_all(&candidates, &mazes, args.limits(), &exploration, args.jobs)?;
    warn_about(&args.vehicle);
    let planner = Planner::new(args.vehicle.clone());
    let names = unique_names(&mazes);
    let indices: Vec<usize> = (0..mazes.len()).collect();
    let results = map_each(&indices, |&maze| {
        let selected = &mazes[maze];
        let mut planner = planner.clone();
        // A maze is skipped if its goal is unreachable.
        planner
            .plan(selected.maze.walls(), selected.maze.start().cell, selected.maze.goals())
            .ok()?;
        let attempts = candidates.iter().zip(&figures).map(|(candidate, figures)| {
            let speed = args.search_speed;
            let figures = &figures[maze];
            let attempt = Attempt::new(&mut planner, &selected.maze, figures, speed, &rules);
            (candidate.name().to_string(), attempt)
        });
        Some(MazeResult::new(selected, &names[maze], attempts.collect()))
    });
    let is_skipped = |(_, result): &(&String, &Option<MazeResult>)| result.is_none();
    let skipped = names.iter().zip(&results).filter(is_skipped).map(|(name, _)| name.clone());
    let skipped = skipped.collect();
    let results: Vec<MazeResult> = results.into_iter().flatten().collect();
    let Rules { time_limit, max_runs, search_share, touch_penalty } = rules;
    let contest = Contest {
        rules: args.rules.name(),
        time_limit_s: time_limit,
        max_runs,
        search_share,
        touch_penalty_s: touch_penalty,
        vehicle: args.vehicle.name().into(),
        search_speed: args.search_speed,
        standings: Standing::all(candidates.iter().map(Candidate::name), &results),
        mazes: results,
        skipped,
    };
    if args.json {
        print_pretty_json(&contest)?;
    } else if args.csv {
        print_csv(|csv| contest.mazes.iter().try_for_each(|maze| maze.write_csv(csv)))?;
    } else if !mazes.is_empty() {
        print(&contest.text())?;
    }
    Ok(all_readable)
}
