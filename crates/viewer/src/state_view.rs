//! The view of a state on the page.

use mmsim_drawing::TRAIL_CELLS;
use mmsim_maze::Cell;
use mmsim_recording::Block;
use serde::Serialize;

use crate::api_error::ApiError;
use crate::distances::DistanceBounds;
use crate::source::Source;

/// A state of a run, with the values that the page shows.
#[derive(Debug, Serialize)]
pub(crate) struct StateView {
    /// The index of the state.
    at: usize,
    /// The current number of states of the run.
    states: usize,
    /// The state message `S`, exactly as the client sent it.
    state: Vec<u8>,
    steps: u64,
    turns: u64,
    visited: usize,
    #[serde(flatten)]
    distances: DistanceBounds,
    #[serde(rename = "solved")]
    is_proven_optimal: bool,
    /// The most recently visited cells, as y × width + x, oldest first.
    trail: Vec<u16>,
}

impl StateView {
    pub(crate) fn new(source: &Source, run: u32, index: usize) -> Result<Self, ApiError> {
        let (description, states) = (source.describe(run)?, source.block(run, index)?);
        let decoded = description.decode(&states, index)?;
        let motion = states
            .motion_count(index)
            .ok_or_else(|| ApiError::internal(format!("cannot decode state {index}")))?;
        let distances = DistanceBounds::new(&decoded.map);
        let width = u16::from(description.size.width());
        let trail = trail(source, run, index)?;
        Ok(Self {
            at: index,
            states: source.states(run)?,
            state: decoded.message.to_vec(),
            steps: motion.steps,
            turns: motion.turns,
            visited: decoded.map.visited().len(),
            distances,
            is_proven_optimal: distances.is_proven_optimal(),
            trail: trail.iter().map(|cell| u16::from(cell.y) * width + u16::from(cell.x)).collect(),
        })
    }
}

/// Returns the trail of the mouse up to the state `last`, oldest cell first.
pub(crate) fn trail(source: &Source, run: u32, last: usize) -> Result<Vec<Cell>, ApiError> {
    let (mut index, mut cells) = (last.saturating_sub(TRAIL_CELLS - 1), Vec::new());
    while index <= last {
        let end = ((index / Block::STATES + 1) * Block::STATES).min(last + 1);
        let states = source.block(run, end - 1)?;
        for index in index..end {
            let pose = states.message(index).and_then(|message| message.pose().ok());
            cells.extend(pose.map(|pose| pose.cell));
        }
        index = end;
    }
    Ok(cells)
}
