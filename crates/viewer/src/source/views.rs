//! What the page shows of a source and of each of its states.

use mmsim_client::BUNDLED_MOUSE_NAME;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_maze::{KnownMaze, Maze, MazeSize, Pose, Unknown, WallState};
use mmsim_protocol::Colour;
use mmsim_recording::{Integrity, Notes, ReadError, Recording};
use mmsim_run::{
    LegProgress, StateFigures, TrialReport, planned_path, shortest_path, trial_status,
};
use mmsim_solvers::MazeFacts;
use serde::Serialize;

use crate::http::jobs::{ApiResult, CancelToken};
use crate::source::fast_runs::{Vehicles, driven};
use crate::source::{RECORDED_RUN, StateSource};

/// The message that the page shows for a recording that was not closed.
const NOT_CLOSED: &str = "not closed: the recording was truncated or is still being written";

/// The properties of the current run of a source.
#[derive(Serialize)]
pub(crate) struct SourceInfo {
    id: String,
    run: u32,
    title: String,
    /// The name of the maze.
    maze: String,
    width: u8,
    height: u8,
    /// The name of the vehicle that the page selects.
    vehicle: String,
    start: [u8; 2],
    goals: Vec<[u8; 2]>,
    states: usize,
    state_bytes: usize,
    /// Whether the true maze is known.
    truth: bool,
    shortest_path: Option<u16>,
    /// The cells of a shortest path of the true maze or, in a two-run trial, the cells in which the
    /// steps of a fastest race end, as y × width + x.
    route: Vec<usize>,
    /// The name of the robot, if the source is a two-run trial.
    mouse: Option<String>,
    /// The minimum number of steps of a race in a two-run trial.
    race_optimum: Option<usize>,
    /// The integrity of a recording: `closed`, `cut` or `damaged`.
    integrity: Option<&'static str>,
    /// A description of the problem if the recording was not closed or is damaged.
    note: Option<String>,
}

impl SourceInfo {
    /// Describes a source. `mouse` is the name of the robot if the source is known to be a two-run
    /// trial.
    pub(crate) fn new(
        id: String,
        source: &StateSource,
        vehicles: &Vehicles,
        mouse: Option<String>,
    ) -> ApiResult<Self> {
        let (run, description, states) = source.current_run()?;
        let info = &description.info;
        let (integrity, note) = match source.integrity() {
            None => (None, None),
            Some(Integrity::Closed) => (Some("closed"), None),
            Some(Integrity::Truncated { .. }) => (Some("cut"), Some(NOT_CLOSED.to_string())),
            Some(Integrity::Damaged { intact, reason }) => {
                (Some("damaged"), Some(format!("damaged after byte {intact}: {reason}")))
            }
        };
        let truth = description.truth.as_ref();
        let reported = source.last_context(run, states).and_then(|context| {
            trial_status(context.notes())?;
            Some(context.notes().mouse().unwrap_or_default().to_string())
        });
        let mouse = mouse.or(reported);
        let path = truth.map_or_else(Vec::new, |maze| shortest_path(maze, mouse.is_some()));
        Ok(Self {
            id,
            run,
            title: description.title.clone(),
            maze: info.maze.clone(),
            width: info.width,
            height: info.height,
            vehicle: vehicles.selected(description.size).name().into(),
            start: info.start,
            goals: info.goals.clone(),
            states,
            state_bytes: mmsim_protocol::state_bytes(description.size),
            truth: truth.is_some(),
            shortest_path: truth.and_then(|maze| MazeFacts::new(maze).shortest_path),
            // The path has a cell more than steps, and none if the goal is unreachable.
            race_optimum: mouse.as_ref().and_then(|_| path.len().checked_sub(1)),
            route: path.into_iter().filter_map(|cell| description.size.index(cell)).collect(),
            mouse,
            integrity,
            note,
        })
    }
}

/// A state of a run, with the values that the page shows.
#[derive(Debug, Serialize)]
pub(crate) struct StateView {
    /// The index of the state.
    at: usize,
    /// The current number of states of the run.
    states: usize,
    /// The number of requests with annotations that a live simulation has answered. After a further one,
    /// the last state may show other texts, colours and walls.
    annotations: Option<u64>,
    /// The state message `S`, exactly as the client sent it.
    state: Vec<u8>,
    #[serde(flatten)]
    figures: StateFigures,
    /// What the mouse is doing, in a sentence.
    sentence: String,
    /// The number of the current leg, and the steps since it began. See [`LegProgress`].
    leg: (u32, u32),
    /// The visited cells whose walls the client does not all know, as y × width + x, each with the
    /// headings of the unknown walls as bits: 1 north, 2 east, 4 south and 8 west.
    unknown_walls: Vec<(usize, u8)>,
    /// The passages of the trail, oldest first. A passage from (x, y) is encoded as
    /// 4 × (y × width + x) + the number of its heading, which is 0 for north, 1 for east, 2 for
    /// south and 3 for west.
    trail: Vec<usize>,
    /// The cells of the path that the mouse plans to take, as y × width + x. Empty if the weights
    /// lead nowhere.
    plan: Vec<usize>,
    /// The names of the mouse and of its strategy, if the client has sent them.
    mouse: Option<String>,
    strategy: Option<String>,
    /// The texts that the mouse displays, each with its cell as y × width + x.
    texts: Vec<(usize, String)>,
    /// The letter of the colour of each cell, or `-` for cells without a colour. Empty if no cell has
    /// a colour.
    colours: String,
    /// The walls that the mouse declares, as 2 × (y × width + x) for the north wall of a cell and
    /// 2 × (y × width + x) + 1 for its east wall, and whether the mouse declares the wall present.
    declared_walls: Vec<(usize, bool)>,
    /// The walls of the maze that the client reports as absent, encoded like `declared_walls`.
    missed_walls: Vec<usize>,
}

impl StateView {
    /// Describes a state. The vehicle of `planner` times the runs.
    pub(crate) fn new(
        source: &StateSource,
        run: u32,
        index: usize,
        planner: &mut Planner,
    ) -> ApiResult<Self> {
        let (description, states) = (source.describe(run)?, source.block(run, index)?);
        let annotations = source.annotations();
        let decoded = description.decode(&states, index, &source.trailing(run, index)?)?;
        let times = source.times_to(run, index)?;
        let (phases, trail) = source.run_to(run, index, &CancelToken::default())?;
        let notes = decoded.context.notes();
        let LegProgress { leg, steps } = phases.leg();
        let block = |index| source.block(run, index).ok();
        let trial = TrialReport::new(notes, &*source.index(run)?, index, &times, block);
        let number = |cell| description.size.index(cell);
        let passage = |Pose { cell, heading }| Some(4 * number(cell)? + heading as usize);
        let weight = |cell| decoded.state.weights().at(cell);
        let plan = planned_path(&decoded.map, decoded.state.pose(), weight);
        let truth = description.truth.as_ref();
        let runs = source.index(run)?;
        let cells = |figures| runs.cells(figures, |state| source.block(run, state));
        let driven = match phases.fast_runs {
            0 => None,
            _ => driven(source, run, index, &CancelToken::default())?,
        };
        let way = (driven.and_then(Result::ok), |run| cells(run).unwrap_or_default());
        let maps = [&decoded.map, &decoded.known];
        let figures = StateFigures::new(&phases, planner, way, &times, maps, trial);
        Ok(Self {
            at: index,
            states: source.states(run)?,
            annotations,
            state: decoded.message.to_vec(),
            sentence: figures.sentence(),
            figures,
            leg: (leg, steps),
            unknown_walls: unknown_walls(&decoded.known),
            trail: trail.passages().into_iter().filter_map(passage).collect(),
            plan: plan.into_iter().filter_map(number).collect(),
            mouse: notes.mouse().map(String::from),
            strategy: notes.strategy().map(String::from),
            texts: texts(notes, description.size),
            colours: colours(notes, description.size),
            declared_walls: declared_walls(notes, description.size),
            missed_walls: truth.map_or_else(Vec::new, |maze| missed_walls(&decoded.map, maze)),
        })
    }
}

/// What a recorded run is about, for the list of recordings.
#[derive(Debug, Default, Serialize)]
pub(crate) struct RecordingSummary {
    /// The name of the mouse or, of a bundled mouse, the name of its strategy.
    mouse: Option<String>,
    maze: Option<String>,
    /// What the mouse has achieved, in words, or the reason why the recording cannot be read.
    result: String,
}

impl RecordingSummary {
    pub(crate) fn new(read: Result<Recording, ReadError>) -> ApiResult<Self> {
        let recording = match read {
            Ok(recording) => recording,
            Err(error) => return Ok(Self { result: error.to_string(), ..Self::default() }),
        };
        let (maze, states) = (recording.info().maze.clone(), recording.history().len());
        let Some(last) = states.checked_sub(1) else {
            return Ok(Self { maze: Some(maze), result: "no states".into(), mouse: None });
        };
        let source = StateSource::recording(&maze, recording);
        let mut planner = Planner::new(Vehicle::default_for(source.describe(RECORDED_RUN)?.size));
        let StateView { mouse, strategy, figures, .. } =
            StateView::new(&source, RECORDED_RUN, last, &mut planner)?;
        let mouse = mouse.filter(|name| name != BUNDLED_MOUSE_NAME).or(strategy);
        Ok(Self { mouse, maze: Some(maze), result: figures.result() })
    }
}

fn texts(notes: &Notes, size: MazeSize) -> Vec<(usize, String)> {
    let texts = (0..).zip(size.cells()).map(|(index, cell)| (index, notes.text(cell)));
    let texts = texts.filter(|(_, text)| !text.is_empty());
    texts.map(|(index, text)| (index, text.to_string())).collect()
}

fn colours(notes: &Notes, size: MazeSize) -> String {
    let letters = size.cells().map(|cell| notes.colour(cell).map_or('-', Colour::letter));
    let letters: String = letters.collect();
    if letters.trim_start_matches('-').is_empty() { String::new() } else { letters }
}

/// Returns the declared walls. See [`StateView::declared_walls`].
fn declared_walls(notes: &Notes, size: MazeSize) -> Vec<(usize, bool)> {
    let declared = size.inner_walls().filter_map(|wall| {
        let state = notes.declared_wall(wall.cell, wall.heading)?;
        Some((size.wall_index(wall)?, state == WallState::Present))
    });
    declared.collect()
}

/// Returns the walls that exist but are absent on the map. See [`StateView::missed_walls`].
fn missed_walls(map: &KnownMaze, maze: &Maze) -> Vec<usize> {
    let missed = map.size().inner_walls().filter(|wall| {
        maze.walls().has(wall.cell, wall.heading)
            && map.wall(wall.cell, wall.heading) == WallState::Absent
    });
    missed.filter_map(|wall| map.size().wall_index(wall)).collect()
}

/// Returns the visited cells with unknown walls. See [`StateView::unknown_walls`].
fn unknown_walls(known: &KnownMaze) -> Vec<(usize, u8)> {
    let cells = known.visited().iter().filter_map(|cell| {
        let [certain, possible] =
            [Unknown::Open, Unknown::Closed].map(|unknown| known.walls(unknown).sides(cell).bits());
        Some((known.size().index(cell)?, possible & !certain))
    });
    cells.filter(|&(_, sides)| sides != 0).collect()
}
