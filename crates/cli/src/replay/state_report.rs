//! The report on one state of a recording.

use mmsim_maze::{Cell, Escaped, KnownMaze, MazeSize, Pose, Unknown};
use mmsim_protocol::{Matrix, State};
use mmsim_recording::{Block, PhaseReport, Recording, Transition};
use mmsim_solvers::PathBounds;
use mmsim_trial::race_optimum;
use mmsim_viewer::TrialReport;
use serde::Serialize;

use super::PoseAt;
use crate::output::counted;
use crate::phase_table;
use crate::screen::{pictures, wide_or_compact};

/// The report on one state. The field names are JSON keys.
#[derive(Serialize)]
pub(super) struct StateReport {
    index: usize,
    #[serde(flatten)]
    pose: PoseAt,
    visited_cells: usize,
    phases: PhaseReport,
    /// The figures of a two-run trial. The distances of a trial are in time steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    trial: Option<TrialReport>,
    /// `restart` if the mouse was put back at the start in this state, `jump` if it appeared in
    /// another cell, or `None` if it moved.
    event: Option<&'static str>,
    /// The distance from the start to the goal if all unknown walls are open, or `None` if there is
    /// no path.
    optimistic_distance: Option<u16>,
    /// The distance from the start to the goal if all unknown walls are closed, or `None` if there
    /// is no path.
    pessimistic_distance: Option<u16>,
    /// True if the shortest known path is proven to be the shortest.
    proven: bool,
    /// The number of walls that the client reports incorrectly, or `None` if the recording has no
    /// maze.
    wrong_walls: Option<usize>,
    /// The weight of cell (x, y) is `weights[x][y]`.
    weights: Vec<Vec<u8>>,
    walls: Vec<Vec<u8>>,
    map: String,
    /// The status line and the map, for the text output.
    #[serde(skip)]
    pub(super) text: String,
}

impl StateReport {
    pub(super) fn read(recording: &Recording, index: usize) -> Option<Self> {
        let block = recording.history().block(index / Block::STATES)?;
        let states = block.unpack()?;
        let state = State::decode(states.get(index)?, recording.size()).ok()?;
        let phases = states.phases(index)?;
        let event = event(phases.transition);
        let here = match phases.transition {
            Some(Transition::Restart) => ", put back at the start",
            Some(Transition::Jump) => ", jumped to this cell",
            Some(Transition::Move { .. }) | None => "",
        };
        let report = PhaseReport::new(&phases, index, recording.times());
        let (pose, unexplored) = (state.pose(), recording.info().known_maze()?);
        let context = states.context(index)?;
        let map = context.claimed_maze(&state, &unexplored);
        let block =
            |index: usize| recording.history().block(index / Block::STATES)?.unpack().map(Box::new);
        let trial = TrialReport::new(index, recording.times(), block);
        let known = context.known_maze(&state, &unexplored, recording.maze());
        let bounds = bounds(&known, trial.is_some());
        let weight = |cell| state.weights().at(cell).map_or(0, u16::from);
        let Pose { cell, heading } = pose;
        let pose_at = PoseAt::new(recording, recording.times().get(index)?, pose);
        let wrong_walls = recording.maze().map(|maze| map.wrong_walls(maze.walls()).count());
        let visited = counted(map.visited().len() as u64, "cell");
        let wrong = wrong_walls.filter(|&count| count > 0);
        let wrong = wrong.map(|count| format!(", {} wrong", counted(count as u64, "wall")));
        let (wrong, picture) =
            (wrong.unwrap_or_default(), wide_or_compact(pictures(&map, pose, weight)));
        let runs = trial.as_ref().map_or_else(|| phases_text(&report), trial_text);
        let text = format!(
            "state {index} after {:.3} ms: {cell} heading {heading}{here}, {visited} visited{wrong}\n\
             {runs}{}\n{picture}",
            pose_at.ms,
            bounds_text(bounds, trial.is_some()),
        );
        Some(Self {
            index,
            visited_cells: map.visited().len(),
            phases: report,
            trial,
            event,
            optimistic_distance: bounds.optimistic,
            pessimistic_distance: bounds.pessimistic,
            proven: bounds.is_proven(),
            wrong_walls,
            weights: columns(recording.size(), state.weights()),
            walls: columns(recording.size(), state.walls()),
            map: map.picture().with_mouse(pose).to_string(),
            text,
            pose: pose_at,
        })
    }
}

/// Formats the figures of the phases up to a state and the number of events.
fn phases_text(report: &PhaseReport) -> String {
    let times = |count: u32| counted(count, "time");
    let restart = format!("put back at the start {}", times(report.restarts));
    let jumped = format!("jumped to another cell {}", times(report.jumps));
    let events = [(report.restarts, restart), (report.jumps, jumped)].into_iter();
    let events = events.filter(|&(count, _)| count > 0);
    events.fold(phase_table::table(report), |text, (_, event)| text + &event + "\n")
}

/// Formats the figures of a trial up to a state.
fn trial_text(TrialReport { robot, status, run_1, run_2, score }: &TrialReport) -> String {
    let robot = Escaped(robot.as_deref().unwrap_or("robot"));
    let score = score.as_ref().map(|score| format!(", score {score}")).unwrap_or_default();
    let runs = [("run 1", Some(*run_1)), ("run 2", *run_2)];
    let rows = runs.into_iter().filter_map(|(name, run)| Some((name.to_string(), run?)));
    format!("two-run trial of {robot}: {status}{score}\n{}", phase_table::run_table(rows))
}

/// Computes the bounds of the shortest path in cells or, in a trial, of the fastest race in time
/// steps.
fn bounds(known: &KnownMaze, is_trial: bool) -> PathBounds {
    if !is_trial {
        return PathBounds::new(known);
    }
    let race = |unknown| race_optimum(known.walls(unknown), known.start().cell, known.goals());
    PathBounds { optimistic: race(Unknown::Open), pessimistic: race(Unknown::Closed) }
}

/// Formats the bounds of the shortest path from the start to the goal.
fn bounds_text(bounds: PathBounds, is_trial: bool) -> String {
    let name = if is_trial { "fastest race" } else { "shortest path" };
    match (bounds.optimistic, bounds.pessimistic) {
        (None, _) => format!("{name}: the goal is unreachable"),
        (Some(steps), None) => format!("{name}: at least {}", counted(steps, "step")),
        (Some(least), Some(most)) if least == most => {
            format!("{name}: {}, proven", counted(least, "step"))
        }
        (Some(least), Some(most)) => format!("{name}: {least} to {most} steps"),
    }
}

/// Returns the name of an event: a transition that is not a movement.
const fn event(transition: Option<Transition>) -> Option<&'static str> {
    match transition {
        Some(Transition::Restart) => Some("restart"),
        Some(Transition::Jump) => Some("jump"),
        Some(Transition::Move { .. }) | None => None,
    }
}

/// Returns the columns of a matrix from west to east, each from south to north.
fn columns(size: MazeSize, matrix: Matrix<'_>) -> Vec<Vec<u8>> {
    let column = |x| (0..size.height()).filter_map(|y| matrix.at(Cell::new(x, y))).collect();
    (0..size.width()).map(column).collect()
}
