//! The view of a state on the page.

use mmsim_drawing::Passage;
use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, WallState};
use mmsim_protocol::Colour;
use mmsim_recording::{LegProgress, Notes, PhaseReport, Transition};
use serde::Serialize;

use crate::api_error::ApiError;
use crate::distances::DistanceBounds;
use crate::jobs::CancelToken;
use crate::routes;
use crate::source::Source;
use crate::trial::TrialReport;

/// A state of a run, with the values that the page shows.
#[derive(Debug, Serialize)]
pub(crate) struct StateView {
    /// The index of the state.
    at: usize,
    /// The current number of states of the run.
    states: usize,
    /// The state message `S`, exactly as the client sent it.
    state: Vec<u8>,
    phases: PhaseReport,
    /// The number of the current leg, and the steps since it began. See [`LegProgress`].
    leg: (u32, u32),
    /// The figures of a two-run trial.
    trial: Option<TrialReport>,
    /// Whether the mouse was put back at the start or jumped to another cell in this state.
    event: Option<ViewEvent>,
    visited: usize,
    /// The visited cells whose walls the client does not all know, as y × width + x, each with the
    /// headings of the unknown walls as bits: 1 north, 2 east, 4 south and 8 west.
    unknown_walls: Vec<(u16, u8)>,
    #[serde(flatten)]
    distances: DistanceBounds,
    #[serde(rename = "solved")]
    is_proven_optimal: bool,
    /// The passages of the trail, oldest first. A passage from (x, y) is encoded as
    /// 4 × (y × width + x) + the number of its heading, which is 0 for north, 1 for east, 2 for
    /// south and 3 for west.
    trail: Vec<u16>,
    /// The cells of the path that the mouse plans to take, as y × width + x. Empty if the weights
    /// lead nowhere.
    plan: Vec<u16>,
    /// The names of the mouse and of its strategy, if the client has sent them.
    mouse: Option<String>,
    strategy: Option<String>,
    /// The texts that the mouse displays, each with its cell as y × width + x.
    texts: Vec<(u16, String)>,
    /// The letter of the colour of each cell, or `-` for cells without a colour. Empty if no cell has
    /// a colour.
    colours: String,
    /// The walls that the mouse declares, as 2 × (y × width + x) for the north wall of a cell and
    /// 2 × (y × width + x) + 1 for its east wall, and whether the mouse declares the wall present.
    declared_walls: Vec<(u16, bool)>,
    /// The walls of the maze that the client reports as absent, encoded like `declared_walls`.
    missed_walls: Vec<u16>,
}

/// A change of the pose that is not a movement. See [`Transition`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum ViewEvent {
    Restart,
    Jump,
}

impl ViewEvent {
    const fn from_transition(transition: Option<Transition>) -> Option<Self> {
        match transition {
            Some(Transition::Restart) => Some(Self::Restart),
            Some(Transition::Jump) => Some(Self::Jump),
            Some(Transition::Move { .. }) | None => None,
        }
    }
}

impl StateView {
    pub(crate) fn new(source: &Source, run: u32, index: usize) -> Result<Self, ApiError> {
        let (description, states) = (source.describe(run)?, source.block(run, index)?);
        let decoded = description.decode(&states, index)?;
        let phases = states
            .phases(index)
            .ok_or_else(|| ApiError::internal(format!("cannot decode state {index}")))?;
        let distances = DistanceBounds::new(&decoded.known, decoded.is_trial);
        let width = u16::from(description.size.width());
        let times = source.times_to(run, index)?;
        let trail = source.trail(run, index, &CancelToken::default())?.passages();
        let notes = decoded.context.notes();
        let LegProgress { leg, steps } = phases.leg();
        let trial = decoded
            .is_trial
            .then(|| TrialReport::new(index, &times, |index| source.block(run, index).ok()));
        Ok(Self {
            at: index,
            states: source.states(run)?,
            state: decoded.message.to_vec(),
            phases: PhaseReport::new(&phases, index, &times),
            leg: (leg, steps),
            trial: trial.flatten(),
            event: ViewEvent::from_transition(phases.transition),
            visited: decoded.map.visited().len(),
            unknown_walls: unknown_walls(&decoded.known),
            distances,
            is_proven_optimal: distances.is_proven_optimal(),
            trail: trail
                .into_iter()
                .map(|Passage { from, heading }| {
                    4 * (u16::from(from.y) * width + u16::from(from.x)) + heading as u16
                })
                .collect(),
            plan: routes::cell_numbers(
                &routes::planned_path(&decoded.map, &decoded.state),
                description.size,
            ),
            mouse: notes.mouse().map(String::from),
            strategy: notes.strategy().map(String::from),
            texts: texts(notes, description.size),
            colours: colours(notes, description.size),
            declared_walls: declared_walls(notes, description.size),
            missed_walls: description
                .truth
                .as_ref()
                .map_or_else(Vec::new, |maze| missed_walls(&decoded.map, maze)),
        })
    }
}

fn texts(notes: &Notes, size: MazeSize) -> Vec<(u16, String)> {
    let texts = (0..).zip(size.cells()).map(|(index, cell)| (index, notes.text(cell)));
    let texts = texts.filter(|(_, text)| !text.is_empty());
    texts.map(|(index, text)| (index, text.to_string())).collect()
}

fn colours(notes: &Notes, size: MazeSize) -> String {
    let letters = size.cells().map(|cell| notes.colour(cell).map_or('-', Colour::letter));
    let letters: String = letters.collect();
    if letters.trim_start_matches('-').is_empty() { String::new() } else { letters }
}

/// Returns the north wall and the east wall of each cell, with their numbers in the view.
fn numbered_walls(size: MazeSize) -> impl Iterator<Item = (u16, Cell, Heading)> {
    let walls = size.cells().flat_map(|cell| [(cell, Heading::North), (cell, Heading::East)]);
    (0..).zip(walls).map(|(number, (cell, heading))| (number, cell, heading))
}

/// Returns the declared walls. See [`StateView::declared_walls`].
fn declared_walls(notes: &Notes, size: MazeSize) -> Vec<(u16, bool)> {
    let declared = |(number, cell, heading)| {
        let state = notes.declared_wall(cell, heading)?;
        Some((number, state == WallState::Present))
    };
    numbered_walls(size).filter_map(declared).collect()
}

/// Returns the walls that exist but are absent on the map. See [`StateView::missed_walls`].
fn missed_walls(map: &KnownMaze, maze: &Maze) -> Vec<u16> {
    let is_missed = |&(_, cell, heading): &(u16, Cell, Heading)| {
        maze.walls().has(cell, heading) && map.wall(cell, heading) == WallState::Absent
    };
    numbered_walls(map.size()).filter(is_missed).map(|(number, ..)| number).collect()
}

/// Returns the visited cells with unknown walls. See [`StateView::unknown_walls`].
fn unknown_walls(known: &KnownMaze) -> Vec<(u16, u8)> {
    let width = u16::from(known.size().width());
    let unknown_sides = |cell: Cell| {
        let is_unknown = |&heading: &Heading| known.wall(cell, heading) == WallState::Unknown;
        Heading::ALL
            .into_iter()
            .filter(is_unknown)
            .fold(0, |sides, heading| sides | 1 << heading as u8)
    };
    let cells = known.size().cells().filter(|&cell| known.visited().contains(cell));
    let cells =
        cells.map(|cell| (u16::from(cell.y) * width + u16::from(cell.x), unknown_sides(cell)));
    cells.filter(|&(_, sides)| sides != 0).collect()
}
