//! The text output: the rules, the tables and the mice without a fast run.

use mmsim_compare::{Attempt, Contest, ContestEntry, ContestVehicle, MazeResult, Rules, Standing};
use mmsim_maze::{Escaped, counted};
use mmsim_report::list_reasons;

use crate::grid::{stacked, wrapped};

/// The maximum number of mazes that are named for a reason.
const MAX_MAZES: usize = 4;
/// The maximum number of reasons that are listed for a mouse.
const MAX_REASONS: usize = 5;

/// Returns the rules, the runs in one maze or the scores in several mazes, and the mice without a
/// fast run.
pub(super) fn text(contest: &Contest) -> String {
    let mut sections = vec![head(contest)];
    match &contest.mazes[..] {
        [] => {}
        [maze] => sections.push(table(maze)),
        mazes => sections.extend([standings_table(contest), scores_table(contest, mazes)]),
    }
    sections
        .extend(contest.standings.iter().filter_map(|standing| reasons(contest, &standing.mouse)));
    if !contest.skipped.is_empty() {
        let count = counted(contest.skipped.len(), "maze");
        let names = Escaped(contest.skipped.join(", "));
        let skipped = format!("Skipped {count} with an unreachable goal: {names}");
        sections.push(wrapped(&skipped, " ", 2) + "\n");
    }
    sections.join("\n")
}

fn head(contest: &Contest) -> String {
    let Rules { name, time_limit, max_runs, search_share, touch_penalty } = &contest.rules;
    let runs = match max_runs {
        Some(1) => "the search run".into(),
        Some(max) => format!("the best of {max} runs"),
        None => "the best run".into(),
    };
    let share = match *search_share {
        share if share > 0.0 => format!(" + 1/{:.0} of the time before it", 1.0 / share),
        _ => String::new(),
    };
    let penalty = match *touch_penalty {
        penalty if penalty > 0.0 => format!(" + {penalty} s after a touch"),
        _ => String::new(),
    };
    let text = format!(
        "Rules {name}: {runs} within {time_limit} s. Times in seconds.\n\
         Score: time of the run{share}{penalty}."
    );
    let vehicle = |vehicle: &ContestVehicle| {
        let ContestVehicle { vehicle, search_speed_mm_s, search_turn_time_s } = vehicle;
        let mazes = contest.mazes.iter().filter(|maze| maze.vehicle == *vehicle).count();
        let mazes = match contest.vehicles.len() {
            1 => String::new(),
            _ => format!(" in {}", counted(mazes, "maze")),
        };
        format!(
            "Vehicle {}{mazes}; searches at {search_speed_mm_s} mm/s and {search_turn_time_s} s per \
             quarter turn.",
            Escaped(vehicle)
        )
    };
    let lines = text.lines().map(String::from).chain(contest.vehicles.iter().map(vehicle));
    lines.map(|line| wrapped(&line, " ", 2) + "\n").collect()
}

/// Returns the ranking. A mouse without rivals gets no points.
fn standings_table(contest: &Contest) -> String {
    let has_rivals = contest.standings.len() > 1;
    let common = contest.mazes.iter().filter(|maze| maze.is_scored_by_all()).count();
    let head = ["", "mouse", "points", "mazes scored", "mazes won", "mean score"];
    let row = |standing: &Standing| {
        let Standing { rank, mouse, points, scored, wins, mean_score_s } = standing;
        let scored = format!("{scored}/{}", contest.mazes.len());
        let points = if has_rivals { format!("{points:.1}") } else { "-".into() };
        [rank.to_string(), mouse.clone(), points, scored, wins.to_string(), seconds(*mean_score_s)]
    };
    let rows = [head.map(String::from)].into_iter().chain(contest.standings.iter().map(row));
    let table = stacked(&ranked(rows.collect()));
    let mazes = counted(common, "maze");
    format!("{table}Mean score: over {mazes} in which each mouse has a score.\n")
}

/// Returns a table with the score of each mouse in each maze.
fn scores_table(contest: &Contest, mazes: &[MazeResult]) -> String {
    let mice = || contest.standings.iter().map(|standing| &standing.mouse);
    let head: Vec<String> = ["maze".into()].into_iter().chain(mice().cloned()).collect();
    let rows = mazes.iter().map(|maze| {
        let scores =
            mice().map(|mouse| seconds(maze.entry(mouse).and_then(|entry| entry.attempt.score_s)));
        [maze.maze.maze.clone()].into_iter().chain(scores).collect()
    });
    stacked(&[head].into_iter().chain(rows).collect::<Vec<_>>())
}

/// Lists the most frequent reasons why a mouse made no fast run.
fn reasons(contest: &Contest, mouse: &str) -> Option<String> {
    let reasons = contest.mazes.iter();
    let reasons = reasons
        .filter_map(|maze| Some((maze.entry(mouse)?.attempt.error.as_deref()?, &*maze.maze.maze)));
    let reasons: Vec<_> = reasons.collect();
    let count = counted(reasons.len(), "maze");
    let title = wrapped(&format!("{} made no fast run in {count}:", Escaped(mouse)), " ", 2);
    let lines = list_reasons(reasons, MAX_MAZES, MAX_REASONS, " (see --json)").into_iter();
    let lines: Vec<_> = lines.map(|line| wrapped(&format!("  {line}"), " ", 4)).collect();
    (!lines.is_empty()).then(|| [&[title][..], &lines].concat().join("\n") + "\n")
}

/// Returns a table with the run of each mouse that counts.
fn table(result: &MazeResult) -> String {
    let head =
        ["", &result.maze.maze, "score", "best run", "begins at", "search run", "runs", "touched"];
    let row = |ContestEntry { rank, mouse, attempt, .. }: &ContestEntry| {
        let Attempt { score_s, runs, touched, .. } = attempt;
        let best = attempt.best_run();
        let search_run = runs.first().map(|run| run.time_s);
        [
            rank.map_or("-".into(), |rank| rank.to_string()),
            mouse.clone(),
            seconds(*score_s),
            seconds(best.map(|run| run.time_s)),
            seconds(best.map(|run| run.start_s)),
            seconds(search_run),
            runs.len().to_string(),
            if *touched { "yes" } else { "no" }.into(),
        ]
    };
    let head = head.map(String::from);
    stacked(&ranked([head].into_iter().chain(result.entries.iter().map(row)).collect()))
}

/// Joins the ranks and the names in the first two columns, which are then left-aligned.
fn ranked<const N: usize>(rows: Vec<[String; N]>) -> Vec<Vec<String>> {
    let width = rows.iter().map(|row| row[0].len()).max().unwrap_or(0);
    let join = |row: [String; N]| {
        let mut cells = row.into_iter();
        let (rank, name) = (cells.next().unwrap_or_default(), cells.next().unwrap_or_default());
        [format!("{rank:>width$} {name}")].into_iter().chain(cells).collect()
    };
    rows.into_iter().map(join).collect()
}

fn seconds(time: Option<f64>) -> String {
    time.map_or("-".into(), |time| format!("{time:.3}"))
}
