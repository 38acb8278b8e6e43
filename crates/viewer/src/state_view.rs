//! The view of a state on the page.

use mmsim_drawing::TRAIL_CELLS;
use mmsim_maze::{Cell, Heading, KnownMaze, Pose, WallState};
use mmsim_recording::{Block, PhaseReport, Transition};
use serde::Serialize;

use crate::api_error::ApiError;
use crate::distances::DistanceBounds;
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
    /// The number of steps and quarter turns of all phases.
    steps: u64,
    turns: u64,
    phases: PhaseReport,
    /// The figures of a two-run trial.
    trial: Option<TrialReport>,
    /// Whether the mouse was put back to the start or jumped to another cell in this state.
    event: Option<ViewEvent>,
    visited: usize,
    /// The visited cells whose walls the client does not all know, as y × width + x, each with the
    /// headings of the unknown walls as bits: 1 north, 2 east, 4 south and 8 west.
    unknown_walls: Vec<(u16, u8)>,
    #[serde(flatten)]
    distances: DistanceBounds,
    #[serde(rename = "solved")]
    is_proven_optimal: bool,
    /// The most recently visited cells, as y × width + x, oldest first.
    trail: Vec<u16>,
    /// The indices in `trail` of the cells into which the mouse did not move from the cell before,
    /// because it was put back to the start or jumped.
    breaks: Vec<usize>,
}

/// A change of the pose that is not a movement. See [`Transition`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum ViewEvent {
    PutBack,
    Jump,
}

impl ViewEvent {
    const fn from_transition(transition: Option<Transition>) -> Option<Self> {
        match transition {
            Some(Transition::PutBack) => Some(Self::PutBack),
            Some(Transition::Jump) => Some(Self::Jump),
            Some(Transition::Move { .. }) | None => None,
        }
    }
}

/// The cells of a trail, oldest first.
pub(crate) struct Trail {
    pub(crate) cells: Vec<Cell>,
    /// The indices of the cells into which the mouse did not move from the cell before.
    pub(crate) breaks: Vec<usize>,
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
        let Trail { cells, breaks } = trail(source, run, index)?;
        Ok(Self {
            at: index,
            states: source.states(run)?,
            state: decoded.message.to_vec(),
            steps: phases.total.steps,
            turns: phases.total.turns,
            phases: PhaseReport::new(&phases, index, &times),
            trial: TrialReport::new(index, &times, |index| source.block(run, index).ok()),
            event: ViewEvent::from_transition(phases.transition),
            visited: decoded.map.visited().len(),
            unknown_walls: unknown_walls(&decoded.known),
            distances,
            is_proven_optimal: distances.is_proven_optimal(),
            trail: cells.iter().map(|cell| u16::from(cell.y) * width + u16::from(cell.x)).collect(),
            breaks,
        })
    }
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

/// Returns the trail of the mouse up to the state `last`.
pub(crate) fn trail(source: &Source, run: u32, last: usize) -> Result<Trail, ApiError> {
    let mut index = last.saturating_sub(TRAIL_CELLS - 1);
    let (mut trail, mut before) = (Trail { cells: Vec::new(), breaks: Vec::new() }, None::<Pose>);
    while index <= last {
        let end = ((index / Block::STATES + 1) * Block::STATES).min(last + 1);
        let states = source.block(run, end - 1)?;
        for index in index..end {
            let message = states.message(index);
            let Some(pose) = message.and_then(|message| message.pose().ok()) else { continue };
            let transition = before.map(|before| states.course().transition(before, pose));
            if ViewEvent::from_transition(transition).is_some() {
                trail.breaks.push(trail.cells.len());
            }
            trail.cells.push(pose.cell);
            before = Some(pose);
        }
        index = end;
    }
    Ok(trail)
}
