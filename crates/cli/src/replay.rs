//! `mmsim replay`: show a recording.

pub(crate) mod args;

use std::path::Path;
use std::sync::Arc;

use jiff::Timestamp;
use jiff::tz::TimeZone;
use mmsim_maze::{Cell, Escaped, Heading, KnownMaze, Maze, MazeSize, Pose, WallState};
use mmsim_protocol::{Info, Matrix, State, StateMessage};
use mmsim_recording::{Block, Integrity, MemoryBudget, PhaseReport, Recording, Transition};
use mmsim_solvers::{MazeFacts, PathBounds};
use mmsim_viewer::{DEFAULT_VIEWER_PORT, ViewerConfig};
use serde::{Serialize, Serializer};

use crate::args::ViewerArgs;
use crate::interrupt::Interrupt;
use crate::output::{counted, goal_away, print, print_json};
use crate::playback::{is_undamaged, no_state};
use crate::retention::recording_budget;
use crate::screen::{pictures, wide_or_compact};
use crate::usage::CommandResult;
use crate::{page, phase_table, stderr};
use args::ReplayArgs;

pub(crate) fn run(args: &ReplayArgs) -> CommandResult {
    let budget = recording_budget(&args.reading);
    let recording = Recording::open_within(&args.file, &budget)?;
    if args.serve {
        return serve(args, recording, budget);
    }
    let index = args.at.or(recording.history().len().checked_sub(1));
    let shown = index.and_then(|index| StateReport::read(&recording, index));
    if let (Some(index), None) = (args.at, &shown) {
        return Err(no_state(&args.file, &recording, index).into());
    }
    if args.json {
        print_json(&ReplayReport::new(args, &recording, shown))?;
    } else {
        print(&text(args, &recording, shown.as_ref()))?;
    }
    Ok(is_undamaged(&args.file, &recording))
}

/// Shows the recording in a browser.
fn serve(args: &ReplayArgs, recording: Recording, budget: Arc<MemoryBudget>) -> CommandResult {
    let viewer_port = Some(args.viewer_port.unwrap_or(DEFAULT_VIEWER_PORT));
    let viewer_args = ViewerArgs { viewer_port, open: args.open, no_viewer: false };
    let viewer = page::bind(&viewer_args, "127.0.0.1")?;
    let interrupt = Interrupt::catch()?;
    stderr::write_in_background();
    print(&text(args, &recording, None))?;
    let title = args.file.file_name().unwrap_or_default().to_string_lossy().to_string();
    let config = ViewerConfig::default().with_budget(budget).with_recording(&title, recording);
    page::serve(viewer, config, &viewer_args)?;
    interrupt.wait();
    Ok(true)
}

/// Formats the summary, the maze and one state of the recording.
fn text(args: &ReplayArgs, recording: &Recording, shown: Option<&StateReport>) -> String {
    let (info, size) = (recording.info(), recording.size());
    let goal = recording.maze().map(|maze| goal_away(MazeFacts::new(maze).shortest_path));
    let goal = goal.map(|goal| format!(", {goal}")).unwrap_or_default();
    let maze = recording
        .maze()
        .filter(|_| args.at.is_none())
        .map(|maze| wide_or_compact([maze.to_string(), maze.picture().compact().to_string()]));
    let (maze, state) = (maze.unwrap_or_default(), shown.map_or("", |shown| &shown.text));
    let (file, summary) = (Escaped(args.file.display()), summary(recording));
    format!("{file}: {}, {size}{goal}\n{summary}\n{maze}{state}", info.name)
}

/// Formats the number of states, the duration and the integrity of the recording.
fn summary(recording: &Recording) -> String {
    let states = counted(recording.history().len() as u64, "state");
    let time = began(recording).zip(recording.times().last()).map(|(began, last)| {
        let local = began.to_zoned(TimeZone::system()).strftime("%Y-%m-%d %H:%M:%S");
        format!(" in {:.3} s, from {local}", milliseconds(recording, last) / 1e3)
    });
    let ending = match recording.integrity() {
        Integrity::Closed => "closed properly".into(),
        Integrity::Truncated { intact, length } => {
            format!("not closed: the first {intact} of {length} bytes are intact")
        }
        Integrity::Damaged { intact, .. } => format!("damaged after byte {intact}"),
    };
    format!("{states}{}, {ending}", time.unwrap_or_default())
}

fn began(recording: &Recording) -> Option<Timestamp> {
    Timestamp::from_nanosecond(recording.times().iter().next()?.into()).ok()
}

/// Returns the time since the first state in milliseconds.
#[expect(clippy::cast_precision_loss, reason = "times below 2^53 ns (104 days) are exact")]
fn milliseconds(recording: &Recording, time: u64) -> f64 {
    let first = recording.times().iter().next().unwrap_or(time);
    time.saturating_sub(first) as f64 / 1e6
}

/// The report on one state. The field names are JSON keys.
#[derive(Serialize)]
struct StateReport {
    index: usize,
    #[serde(flatten)]
    pose: PoseAt,
    visited_cells: usize,
    phases: PhaseReport,
    /// `put back` if the mouse was put back to the start in this state, `jump` if it appeared in
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
    text: String,
}

impl StateReport {
    fn read(recording: &Recording, index: usize) -> Option<Self> {
        let block = recording.history().block(index / Block::STATES)?;
        let states = block.unpack()?;
        let state = State::decode(states.get(index)?, recording.size()).ok()?;
        let phases = states.phases(index)?;
        let event = event(phases.transition);
        let here = match phases.transition {
            Some(Transition::PutBack) => ", put back to the start",
            Some(Transition::Jump) => ", jumped to this cell",
            Some(Transition::Move { .. }) | None => "",
        };
        let report = PhaseReport::new(&phases, index, recording.times());
        let (pose, unexplored) = (state.pose(), recording.info().known_maze()?);
        let map = state.map(unexplored.start().cell, *unexplored.goals());
        let context = states.context(index)?;
        let bounds = PathBounds::new(&context.known_maze(&state, &unexplored, recording.maze()));
        let weight = |cell| state.weights().at(cell).map_or(0, u16::from);
        let Pose { cell, heading } = pose;
        let pose_at = PoseAt::new(recording, recording.times().get(index)?, pose);
        let read = context.known_maze(&state, &unexplored, None);
        let wrong_walls = recording.maze().map(|maze| wrong_walls(&map, &read, maze));
        let visited = counted(map.visited().len() as u64, "cell");
        let wrong = wrong_walls.filter(|&count| count > 0);
        let wrong = wrong.map(|count| format!(", {} wrong", counted(count as u64, "wall")));
        let (wrong, picture) =
            (wrong.unwrap_or_default(), wide_or_compact(pictures(&map, pose, weight)));
        Some(Self {
            index,
            visited_cells: map.visited().len(),
            phases: report,
            event,
            optimistic_distance: bounds.optimistic,
            pessimistic_distance: bounds.pessimistic,
            proven: bounds.is_proven(),
            wrong_walls,
            weights: columns(recording.size(), state.weights()),
            walls: columns(recording.size(), state.walls()),
            map: map.picture().with_mouse(pose).to_string(),
            text: format!(
                "state {index} after {:.3} ms: {cell} heading {heading}{here}, {visited} \
                 visited{wrong}\n{}{}\n{picture}",
                pose_at.ms,
                phases_text(&report),
                bounds_text(bounds),
            ),
            pose: pose_at,
        })
    }
}

/// Formats the figures of the phases up to a state and the number of events.
fn phases_text(report: &PhaseReport) -> String {
    let times = |count: u32| counted(count, "time");
    let put_back = format!("put back to the start {}", times(report.put_backs));
    let jumped = format!("jumped to another cell {}", times(report.jumps));
    let events = [(report.put_backs, put_back), (report.jumps, jumped)].into_iter();
    let events = events.filter(|&(count, _)| count > 0);
    events.fold(phase_table::table(report), |text, (_, event)| text + &event + "\n")
}

/// Formats the bounds of the shortest path from the start to the goal.
fn bounds_text(PathBounds { optimistic, pessimistic, .. }: PathBounds) -> String {
    match (optimistic, pessimistic) {
        (None, _) => "shortest path: the goal is unreachable".into(),
        (Some(steps), None) => format!("shortest path: at least {}", counted(steps, "step")),
        (Some(least), Some(most)) if least == most => {
            format!("shortest path: {}, proven", counted(least, "step"))
        }
        (Some(least), Some(most)) => format!("shortest path: {least} to {most} steps"),
    }
}

/// Returns the name of an event: a transition that is not a movement.
const fn event(transition: Option<Transition>) -> Option<&'static str> {
    match transition {
        Some(Transition::PutBack) => Some("put back"),
        Some(Transition::Jump) => Some("jump"),
        Some(Transition::Move { .. }) | None => None,
    }
}

/// Returns the columns of a matrix from west to east, each from south to north.
fn columns(size: MazeSize, matrix: Matrix<'_>) -> Vec<Vec<u8>> {
    let column = |x| (0..size.height()).filter_map(|y| matrix.at(Cell::new(x, y))).collect();
    (0..size.width()).map(column).collect()
}

/// Counts the walls that the client reports incorrectly. `map` contains all walls that the client
/// reports, and `read` those that it has also read: a client that marks a cell as visited before it
/// reads the walls does not report that they are absent.
fn wrong_walls(map: &KnownMaze, read: &KnownMaze, maze: &Maze) -> usize {
    let sides = |cell| [Heading::North, Heading::East].map(|heading| (cell, heading));
    let is_wrong = |&(cell, heading): &(Cell, Heading)| {
        let is_present = maze.walls().has(cell, heading);
        match map.wall(cell, heading) {
            WallState::Present => !is_present,
            WallState::Absent => is_present && read.wall(cell, heading) == WallState::Absent,
            WallState::Unknown => false,
        }
    };
    map.size().cells().flat_map(sides).filter(is_wrong).count()
}

/// The JSON report on a recording.
#[derive(Serialize)]
struct ReplayReport<'a> {
    path: &'a Path,
    #[serde(flatten)]
    info: &'a Info,
    /// The time of the first state, in UTC.
    began: Option<String>,
    /// The integrity of the file: `closed`, `cut` or `damaged`.
    ending: &'static str,
    /// The length of the intact part in bytes, or `None` if the file was closed properly.
    whole_bytes: Option<u64>,
    maze: Option<String>,
    /// The pose in each state, or `None` if `--at` is set.
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<Poses<'a>>,
    /// The state that `--at` selects, or the last state.
    state: Option<StateReport>,
}

/// Serializes the poses in all states as a sequence, decoding them one at a time.
struct Poses<'a>(&'a Recording);

impl Serialize for Poses<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(recording) = self;
        let (history, times) = (recording.history(), recording.times());
        serializer.collect_seq(history.iter().zip(times.iter()).map_while(|(message, time)| {
            let pose = StateMessage::new(&message, recording.size()).ok()?.pose().ok()?;
            Some(PoseAt::new(recording, time, pose))
        }))
    }
}

/// A pose and its time. The field names are JSON keys.
#[derive(Serialize)]
struct PoseAt {
    ms: f64,
    cell: [u8; 2],
    heading: char,
}

impl PoseAt {
    fn new(recording: &Recording, time: u64, Pose { cell, heading }: Pose) -> Self {
        let ms = milliseconds(recording, time);
        Self { ms, cell: [cell.x, cell.y], heading: heading.letter() }
    }
}

impl<'a> ReplayReport<'a> {
    fn new(args: &'a ReplayArgs, recording: &'a Recording, state: Option<StateReport>) -> Self {
        let (ending, whole_bytes) = match recording.integrity() {
            Integrity::Closed => ("closed", None),
            Integrity::Truncated { intact, .. } => ("cut", Some(*intact)),
            Integrity::Damaged { intact, .. } => ("damaged", Some(*intact)),
        };
        Self {
            path: &args.file,
            info: recording.info(),
            began: began(recording).map(|began| began.to_string()),
            ending,
            whole_bytes,
            maze: recording.maze().map(ToString::to_string),
            poses: args.at.is_none().then_some(Poses(recording)),
            state,
        }
    }
}
