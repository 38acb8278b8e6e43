//! One moment of a run: its state, and figures.

use mmsim_drawing::TRAIL_CELLS;
use mmsim_maze::Pose;
use mmsim_recording::Block;
use serde::Serialize;

use crate::api_error::ApiError;
use crate::costs::Cost;
use crate::source::Source;

/// What is told of a moment.
#[derive(Debug, Serialize)]
pub(crate) struct StateView {
    at: usize,
    /// How many states the run has by now.
    states: usize,
    /// The message `S`, as it was sent.
    state: Vec<u8>,
    steps: u64,
    turns: u64,
    visited: usize,
    open: Option<u16>,
    closed: Option<u16>,
    solved: bool,
    /// Numbers of cells, y × width + x.
    trail: Vec<u16>,
}

impl StateView {
    /// The moment of this state of a run.
    pub(crate) fn of(source: &Source, run: u32, at: usize) -> Result<Self, ApiError> {
        let (described, states) = (source.describe(run)?, source.around(run, at)?);
        let missing = || ApiError::failed("expected a state");
        let message = states.get(at).ok_or_else(missing)?;
        let (_, map) = described.read(message)?;
        let tally = states.motion_count(at).ok_or_else(missing)?;
        let cost = Cost::of(&map);
        let trail = cells(source, run, at)?;
        let width = u16::from(described.size.width());
        Ok(Self {
            at,
            states: source.states(run)?,
            state: message.to_vec(),
            steps: tally.steps,
            turns: tally.turns,
            visited: map.visited().len(),
            open: cost.open,
            closed: cost.closed,
            solved: cost.solved(),
            trail: trail.iter().map(|[x, y]| u16::from(*y) * width + u16::from(*x)).collect(),
        })
    }
}

/// Where the mouse was in the states up to this one, x and y of the cells, oldest first.
pub(crate) fn cells(source: &Source, run: u32, at: usize) -> Result<Vec<[u8; 2]>, ApiError> {
    let (mut index, mut cells) = (at.saturating_sub(TRAIL_CELLS - 1), Vec::new());
    while index <= at {
        let end = ((index / Block::STATES + 1) * Block::STATES).min(at + 1);
        let states = source.around(run, end - 1)?;
        for index in index..end {
            let pose = states.message(index).and_then(|message| message.pose().ok());
            cells.extend(pose.map(|Pose { cell, .. }| [cell.x, cell.y]));
        }
        index = end;
    }
    Ok(cells)
}
