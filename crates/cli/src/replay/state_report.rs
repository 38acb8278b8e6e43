//! The report on one state of a recording.

use mmsim_fastrun::Planner;
use mmsim_maze::{Cell, Escaped, MazeSize, Pose, counted};
use mmsim_protocol::{Matrix, State};
use mmsim_recording::{Block, Recording};
use mmsim_run::{
    Cause, EndFacts, Judge, MapFigures, MovementRules, PhaseReport, RunIndex, StateEvent,
    StateFigures, TrialReport, parse_driven_run,
};
use serde::Serialize;

use crate::grid::wrapped;
use crate::phase_table;
use crate::screen::{fitting, pictures};

/// The report on one state. The field names are JSON keys.
#[derive(Serialize)]
pub(super) struct StateReport {
    index: usize,
    #[serde(flatten)]
    pose: PoseAt,
    #[serde(flatten)]
    figures: StateFigures,
    /// The cause that the mouse has not reached the goal, in the last state.
    cause: Option<Cause>,
    /// The number of walls that the client reports incorrectly, or `None` if the recording has no
    /// maze.
    wrong_walls: Option<usize>,
    /// The weight of cell (x, y) is `weights[x][y]`.
    weights: Vec<Vec<u8>>,
    walls: Vec<Vec<u8>>,
    map: String,
    texts: Vec<CellText>,
    colours: Vec<CellColour>,
    /// The status line and the map, for the text output.
    #[serde(skip)]
    pub(super) text: String,
}

impl StateReport {
    /// Reads a state. The vehicle of `planner` times the runs.
    pub(super) fn read(recording: &Recording, index: usize, planner: &mut Planner) -> Option<Self> {
        let block = |index: usize| recording.history().block(index / Block::STATES)?.unpack();
        let states = block(index)?;
        let state = State::decode(states.get(index)?, recording.size()).ok()?;
        let (pose, unexplored) = (state.pose(), recording.info().known_maze()?);
        let rules = MovementRules::from_map(&unexplored, recording.maze());
        let run = RunIndex::new(recording.size(), rules);
        let (phases, _) = run.at(index, |index| block(index).ok_or(())).ok()?;
        let context = recording.context(&states, index)?;
        let map = context.claimed_maze(&state, &unexplored);
        let known = context.known_maze(&state, &unexplored, recording.maze());
        let times = recording.times();
        let trial = TrialReport::new(context.notes(), &run, index, times, block);
        let lines = if phases.fast_runs > 0 { recording.log() } else { Vec::new() };
        // The lines after the last state belong to the number of states.
        let end = index + usize::from(index + 1 == recording.history().len());
        let driven = lines
            .iter()
            .take_while(|line| line.state <= end)
            .filter_map(|line| parse_driven_run(&line.text, unexplored.start().cell)?.ok());
        let cells = |figures| run.cells(figures, |state| block(state).ok_or(()));
        let way = (driven.last(), |run| cells(run).unwrap_or_default());
        let maps = [&map, &known];
        let mut figures = StateFigures::new(&phases, planner, way, times, maps, trial);
        let is_last = index + 1 == recording.history().len();
        let cause = if is_last && figures.trial.is_none() { cause(recording) } else { None };
        figures.error = figures.error.or_else(|| Some(cause?.to_string()));
        let here = match figures.event {
            Some(StateEvent::Restart) => ", put back at the start",
            Some(StateEvent::Jump) => ", jumped to this cell",
            None => "",
        };
        let weight = |cell| state.weights().at(cell).map_or(0, u16::from);
        let Pose { cell, heading } = pose;
        let pose_at = PoseAt::new(recording, recording.times().get(index)?, pose);
        let wrong_walls = recording.maze().map(|maze| map.wrong_walls(maze.walls()).count());
        let visited = counted(figures.map.visited_cells, "cell");
        let wrong = wrong_walls.filter(|&count| count > 0);
        let wrong = wrong.map(|count| format!(", {} wrong", counted(count, "wall")));
        let (wrong, pictures) = (wrong.unwrap_or_default(), pictures(&map, pose, weight));
        let picture = fitting(&pictures);
        let runs = figures.trial.as_ref().map_or_else(|| phases_text(&figures), trial_text);
        let text = format!(
            "state {index} after {:.3} ms: {cell} heading {heading}{here}, {visited} visited{wrong}\n\
             {runs}{}\n{}{picture}",
            1e3 * pose_at.wall_time_s,
            bounds_text(figures.map, figures.trial.is_some()),
            figures
                .fastest_run
                .as_ref()
                .map(|run| wrapped(&run.to_string(), " ", 2) + "\n")
                .unwrap_or_default(),
        );
        let (notes, cells) = (context.notes(), || recording.size().cells());
        let texts = cells().map(|cell| (cell, notes.text(cell)));
        let texts = texts.filter(|(_, text)| !text.is_empty());
        let texts = texts.map(|(Cell { x, y }, text)| CellText { cell: [x, y], text: text.into() });
        let colours = cells().filter_map(|cell| {
            let colour = notes.colour(cell)?.letter();
            Some(CellColour { cell: [cell.x, cell.y], colour })
        });
        Some(Self {
            index,
            figures,
            cause,
            wrong_walls,
            weights: columns(recording.size(), state.weights()),
            walls: columns(recording.size(), state.walls()),
            texts: texts.collect(),
            colours: colours.collect(),
            map: map.picture().with_mouse(pose).to_string(),
            text,
            pose: pose_at,
        })
    }
}

/// Returns the cause that the mouse of a recording has not reached the goal, if the recording says how
/// the run ended.
fn cause(recording: &Recording) -> Option<Cause> {
    let history = recording.history();
    let mut lines =
        recording.log().into_iter().rev().take_while(|line| line.state == history.len());
    let facts = lines.find_map(|line| EndFacts::from_log_line(&line.text))?;
    Judge::from_history(recording.maze()?, history, &[], false).cause(&facts)
}

/// A text that the mouse displays. The field names are JSON keys.
#[derive(Serialize)]
struct CellText {
    cell: [u8; 2],
    text: String,
}

/// The letter of a colour that the mouse displays. The field names are JSON keys.
#[derive(Serialize)]
struct CellColour {
    cell: [u8; 2],
    colour: char,
}

/// A pose and its time. The field names are JSON keys.
#[derive(Serialize)]
pub(super) struct PoseAt {
    wall_time_s: f64,
    cell: [u8; 2],
    heading: char,
}

impl PoseAt {
    #[expect(clippy::cast_precision_loss, reason = "times below 2^53 ns (104 days) are exact")]
    pub(super) fn new(recording: &Recording, time: u64, Pose { cell, heading }: Pose) -> Self {
        let began = recording.times().iter().next().unwrap_or(time);
        let wall_time_s = time.saturating_sub(began) as f64 / 1e9;
        Self { wall_time_s, cell: [cell.x, cell.y], heading: heading.letter() }
    }
}

/// Formats the figures of the phases up to a state and the number of events.
fn phases_text(figures: &StateFigures) -> String {
    let report: &PhaseReport = &figures.phases;
    let times = |count: u32| counted(count, "time");
    let restart = format!("put back at the start {}", times(report.restarts));
    let jumped = format!("jumped to another cell {}", times(report.jumps));
    let events = [(report.restarts, restart), (report.jumps, jumped)].into_iter();
    let events = events.filter(|&(count, _)| count > 0);
    let table =
        events.fold(phase_table::table(report.rows()), |text, (_, event)| text + &event + "\n");
    format!("{table}{}\n", figures.goal())
}

/// Formats the figures of a trial up to a state.
fn trial_text(TrialReport { mouse, status, run_1, run_2, score }: &TrialReport) -> String {
    let robot = Escaped(mouse.as_deref().unwrap_or("robot"));
    let score = score.map(|score| format!(", score {score:.3}")).unwrap_or_default();
    let status = status.replace('_', " ");
    let runs = [("run 1", Some(*run_1)), ("run 2", *run_2)];
    let rows = runs.into_iter().filter_map(|(name, run)| Some((name.to_string(), run?)));
    format!("two-run trial of {robot}: {status}{score}\n{}", phase_table::table(rows))
}

/// Formats the bounds of the shortest path from the start to the goal.
fn bounds_text(map: MapFigures, is_trial: bool) -> String {
    let name = if is_trial { "fastest race" } else { "shortest path" };
    match (map.optimistic_distance, map.pessimistic_distance) {
        (None, _) => format!("{name}: the goal is unreachable"),
        (Some(steps), None) => format!("{name}: at least {}", counted(steps, "step")),
        (Some(least), Some(most)) if least == most => {
            format!("{name}: {}, proven", counted(least, "step"))
        }
        (Some(least), Some(most)) => format!("{name}: {least} to {most} steps"),
    }
}

/// Returns the columns of a matrix from west to east, each from south to north.
fn columns(size: MazeSize, matrix: Matrix<'_>) -> Vec<Vec<u8>> {
    let column = |x| (0..size.height()).filter_map(|y| matrix.at(Cell::new(x, y))).collect();
    (0..size.width()).map(column).collect()
}
