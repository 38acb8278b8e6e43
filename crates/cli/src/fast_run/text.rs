//! Runs as text: descriptions, and a table with means over the mazes.

use mmsim_fastrun::{STANDARD_GRAVITY, Segment};
use mmsim_maze::{Escaped, counted};

use super::driven::{DrivenRun, RouteChoice, RunResult};
use super::report::SegmentReport;
use crate::grid::{aligned, titled, wrapped};

/// Describes a run: its times, its length, its turns and its text form.
pub(super) fn describe(driven: &DrivenRun, with_segments: bool) -> String {
    let DrivenRun { maze, vehicle, route, run, trajectory, gate_to_gate, .. } = driven;
    let (time, length) = (trajectory.duration(), trajectory.length());
    let loss = match driven.loss {
        loss if loss > 0.0 => format!(", loss {loss:.2} %"),
        _ => String::new(),
    };
    let mean = if time > 0.0 { length / time } else { 0.0 };
    let cells = counted(run.cells().len().saturating_sub(1), "cell");
    let kinds: Vec<String> =
        driven.turns_by_kind().map(|(kind, count)| format!("{count} {kind}")).collect();
    let turns = match run.turns().len() {
        0 => "none".into(),
        count => format!("{count}: {}", kinds.join(", ")),
    };
    let text = format!(
        "{}: fastest run of {}{}\n\
         time      {time:.3} s from rest to rest, {gate_to_gate:.3} s from gate to gate{loss}\n\
         distance  {:.3} m, {cells}\n\
         speed     mean {:.3} m/s, top {:.3} m/s\n\
         turns     {turns}\n\
         run       {run}\n",
        maze.shown_path(),
        Escaped(vehicle.name()),
        route.restriction(),
        length / 1000.0,
        mean / 1000.0,
        trajectory.top_speed() / 1000.0,
    );
    let mut text: String = text.lines().map(|line| wrapped(line, " ", 10) + "\n").collect();
    if with_segments && !trajectory.segments().is_empty() {
        text.push('\n');
        text.push_str(&segments(trajectory.segments()));
    }
    text
}

/// Describes several runs with their straights and turns.
pub(super) fn describe_all(results: &[RunResult]) -> String {
    let text = |RunResult { maze, vehicle, driven, .. }: &RunResult| match driven {
        Ok(driven) => describe(driven, true),
        Err(error) => {
            let (maze, vehicle) = (maze.shown_path(), Escaped(vehicle.name()));
            wrapped(&format!("{maze}: {vehicle}: {error}"), " ", 2) + "\n"
        }
    };
    results.iter().map(text).collect::<Vec<_>>().join("\n")
}

fn segments(segments: &[Segment]) -> String {
    let head = ["", "steps", "mm", "entry mm/s", "top mm/s", "exit mm/s", "g", "s", "total s"];
    let mut rows = vec![head.map(String::from).to_vec()];
    rows.extend(segments.iter().map(SegmentReport::new).map(|segment| {
        let steps = segment.steps.map(|steps| steps.to_string());
        let acceleration = segment.centripetal_acceleration_mm_s2;
        vec![
            segment.segment,
            steps.unwrap_or_default(),
            format!("{:.1}", segment.length_mm),
            format!("{:.0}", segment.entry_speed_mm_s),
            format!("{:.0}", segment.top_speed_mm_s),
            format!("{:.0}", segment.exit_speed_mm_s),
            acceleration.map_or(String::new(), |mm_s2| format!("{:.2}", mm_s2 / STANDARD_GRAVITY)),
            format!("{:.4}", segment.duration_s),
            format!("{:.4}", segment.end_s),
        ]
    }));
    aligned(&rows)
}

/// Formats one line per run. If there are several mazes, appends the means of each vehicle and
/// route.
pub(super) fn table(results: &[RunResult]) -> String {
    let has_routes = results.iter().any(|result| result.route != RouteChoice::Fastest);
    let [time, gate, distance, turns] = ["time", "gate to gate", "distance", "slalom turns"];
    let loss = if has_routes { "     loss" } else { "" };
    let head = format!("{time:>8}  {gate:>12}  {distance:>8}  {turns:>12}{loss}");
    let mut rows = vec![row("maze".into(), "vehicle", has_routes.then_some("route"), head)];
    rows.extend(results.iter().map(|result| {
        let figures = match &result.driven {
            Ok(driven) => text(figures(driven), 0, has_routes),
            Err(error) => error.clone(),
        };
        let route = has_routes.then_some(result.route.name());
        row(result.maze.shown_path(), result.vehicle.name(), route, figures)
    }));
    let means = mean_rows(results, has_routes);
    if !means.is_empty() {
        rows.push(Vec::new());
        rows.extend(means);
    }
    titled(&rows) + &failures(results)
}

fn row(maze: String, vehicle: &str, route: Option<&str>, figures: String) -> Vec<String> {
    let names = [vehicle].into_iter().chain(route).map(String::from);
    [maze].into_iter().chain(names).chain([figures]).collect()
}

/// Returns the rows with the means of each vehicle and route, or none if there is only one maze.
fn mean_rows(results: &[RunResult], has_routes: bool) -> Vec<Vec<String>> {
    if results.iter().all(|result| result.maze.path == results[0].maze.path) {
        return Vec::new();
    }
    let is_same = |one: &RunResult, other: &RunResult| {
        (one.vehicle.name(), one.route) == (other.vehicle.name(), other.route)
    };
    let mut kinds: Vec<&RunResult> = Vec::new();
    for result in results {
        if !kinds.iter().any(|kind| is_same(kind, result)) {
            kinds.push(result);
        }
    }
    let mean = |result: &RunResult| {
        let same = results.iter().filter(|other| is_same(other, result));
        let driven = same.filter_map(|result| result.driven.as_ref().ok());
        let driven: Vec<[f64; 5]> = driven.map(figures).collect();
        let count = u32::try_from(driven.len()).ok().filter(|&count| count > 0)?;
        let sum = |index: usize| driven.iter().map(|figures| figures[index]).sum::<f64>();
        let means = [0, 1, 2, 3, 4].map(|index| sum(index) / f64::from(count));
        let maze = format!("mean of {}", counted(count, "maze"));
        let route = has_routes.then_some(result.route.name());
        Some(row(maze, result.vehicle.name(), route, text(means, 1, has_routes)))
    };
    kinds.into_iter().filter_map(mean).collect()
}

/// Returns a line with the number of mazes without a run, or an empty text if all have one.
fn failures(results: &[RunResult]) -> String {
    let failed = results.iter().filter(|result| result.driven.is_err());
    let mut failed: Vec<_> = failed.map(|result| &result.maze.path).collect();
    failed.dedup();
    match failed.len() {
        0 => String::new(),
        count => format!("{} without a run\n", counted(count, "maze")),
    }
}

/// The time from rest to rest and that from gate to gate in s, the distance in mm, the number of turns,
/// and the slowdown against the fastest run in percent.
fn figures(DrivenRun { trajectory, gate_to_gate, run, loss, .. }: &DrivenRun) -> [f64; 5] {
    // A run has at most a few hundred turns.
    #[allow(clippy::cast_precision_loss)]
    let turns = run.turns().len() as f64;
    [trajectory.duration(), *gate_to_gate, trajectory.length(), turns, *loss]
}

/// Formats figures or their means. The number of turns has the given number of decimals.
fn text(figures: [f64; 5], decimals: usize, has_routes: bool) -> String {
    let [time, gate_to_gate, length, turns, loss] = figures;
    let metres = length / 1000.0;
    let loss = if has_routes { format!("  {loss:>5.2} %") } else { String::new() };
    format!("{time:>6.3} s  {gate_to_gate:>10.3} s  {metres:>6.3} m  {turns:>12.decimals$}{loss}")
}
