//! A table of runs, with means over the mazes.

use mmsim_maze::Escaped;

use super::args::RouteChoice;
use super::driven::{Driven, RunResult};
use crate::grid::{padded, widest};
use crate::output::counted;

/// Formats one line per run. If there are several mazes, appends the means of each vehicle and
/// route.
pub(super) fn table(results: &[RunResult]) -> String {
    let has_routes = results.iter().any(|result| result.route != RouteChoice::Fastest);
    let mut lines: Vec<Line> =
        results.iter().map(|result| Line::from_result(result, has_routes)).collect();
    let means = mean_lines(results, has_routes);
    let has_means = !means.is_empty();
    lines.extend(means);
    let head = Line::head(has_routes);
    let width =
        |column: fn(&Line) -> &String| widest([&head].into_iter().chain(&lines).map(column));
    let (maze_width, vehicle_width, route_width) =
        (width(|line| &line.maze), width(|line| &line.vehicle), width(|line| &line.route));
    let format_line = |Line { maze, vehicle, route, figures }: &Line| {
        let route = if has_routes { padded(route, route_width) + "  " } else { String::new() };
        let (maze, vehicle) = (padded(maze, maze_width), padded(vehicle, vehicle_width));
        format!("{maze}  {vehicle}  {route}{figures}\n")
    };
    let mut text = format_line(&head);
    for (index, line) in lines.iter().enumerate() {
        if has_means && index == results.len() {
            text.push('\n');
        }
        text += &format_line(line);
    }
    text + &failures(results)
}

/// The cells of a line of the table.
struct Line {
    maze: String,
    vehicle: String,
    route: String,
    /// The figures of the run, or the reason why there is none.
    figures: String,
}

impl Line {
    fn head(has_routes: bool) -> Self {
        let [time, gate, distance, turns] = ["time", "gate to gate", "distance", "slalom turns"];
        let loss = if has_routes { "      loss" } else { "" };
        Self {
            maze: "maze".into(),
            vehicle: "vehicle".into(),
            route: "route".into(),
            figures: format!("{time:>9}  {gate:>12}  {distance:>9}  {turns:>12}{loss}"),
        }
    }

    fn from_result(result: &RunResult, has_routes: bool) -> Self {
        Self {
            maze: result.maze.shown_path(),
            vehicle: Escaped(result.vehicle.name()).to_string(),
            route: result.route.name().into(),
            figures: match &result.driven {
                Ok(driven) => Figures::from_driven(driven).text(0, has_routes),
                Err(error) => error.clone(),
            },
        }
    }
}

/// Returns the lines with the means of each vehicle and route, or none if there is only one maze.
fn mean_lines(results: &[RunResult], has_routes: bool) -> Vec<Line> {
    // The first maze has each vehicle and route once, and all mazes have the same ones.
    let is_first = |result: &&RunResult| result.maze.path == results[0].maze.path;
    let first: Vec<&RunResult> = results.iter().take_while(is_first).collect();
    if first.len() == results.len() {
        return Vec::new();
    }
    let mean = |(index, result): (usize, &&RunResult)| {
        let same = results.iter().skip(index).step_by(first.len());
        let driven: Vec<Figures> = same
            .filter_map(|result| result.driven.as_ref().ok())
            .map(Figures::from_driven)
            .collect();
        let mean = Figures::mean(&driven)?;
        let line = Line::from_result(result, has_routes);
        let maze = format!("mean of {}", counted(driven.len() as u64, "maze"));
        Some(Line { maze, figures: mean.text(1, has_routes), ..line })
    };
    first.iter().enumerate().filter_map(mean).collect()
}

/// Returns a line with the number of mazes without a run, or an empty text if all have one.
fn failures(results: &[RunResult]) -> String {
    let mut failed: Vec<_> = results
        .iter()
        .filter(|result| result.driven.is_err())
        .map(|result| &result.maze.path)
        .collect();
    failed.dedup();
    match failed.len() {
        0 => String::new(),
        count => format!("{} without a run\n", counted(count as u64, "maze")),
    }
}

/// The figures of a run, or means of several runs.
#[derive(Default)]
struct Figures {
    time: f64,
    gate_to_gate: f64,
    /// The distance, in mm.
    length: f64,
    turns: f64,
    /// The slowdown against the fastest run, in percent.
    loss: f64,
}

impl Figures {
    fn from_driven(driven: &Driven) -> Self {
        // A run has at most a few hundred turns.
        #[allow(clippy::cast_precision_loss)]
        Self {
            time: driven.trajectory.duration(),
            gate_to_gate: driven.gate_to_gate,
            length: driven.trajectory.length(),
            turns: driven.run.turns().len() as f64,
            loss: driven.loss,
        }
    }

    /// Returns the means, or `None` if there are no runs.
    fn mean(all: &[Self]) -> Option<Self> {
        #[allow(clippy::cast_precision_loss)]
        let count = (!all.is_empty()).then_some(all.len() as f64)?;
        let mean = |figure: fn(&Self) -> f64| all.iter().map(figure).sum::<f64>() / count;
        Some(Self {
            time: mean(|one| one.time),
            gate_to_gate: mean(|one| one.gate_to_gate),
            length: mean(|one| one.length),
            turns: mean(|one| one.turns),
            loss: mean(|one| one.loss),
        })
    }

    /// Formats the figures. The number of turns has the given number of decimals.
    fn text(&self, decimals: usize, has_routes: bool) -> String {
        let Self { time, gate_to_gate, length, turns, loss } = self;
        let metres = length / 1000.0;
        let loss = if has_routes { format!("  {loss:>6.2} %") } else { String::new() };
        format!(
            "{time:>7.3} s  {gate_to_gate:>10.3} s  {metres:>7.3} m  {turns:>12.decimals$}{loss}"
        )
    }
}
