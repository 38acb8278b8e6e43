//! The trails of the mouse at the states of a run.

use std::borrow::Borrow;
use std::sync::{Mutex, PoisonError};

use mmsim_drawing::Trail;
use mmsim_maze::MazeSize;
use mmsim_recording::{Block, States, Transition};

/// The maximum number of stored trails of a run.
const MAX_TRAILS: usize = 256;

/// Stored trails of a run, so that the trail at any state can be computed from few states.
pub(crate) struct TrailHistory {
    /// The number of states from one stored trail to the next, a multiple of [`Block::STATES`].
    stride: usize,
    /// The trail before each state whose index is a multiple of `stride`.
    stored: Vec<Trail>,
    /// The trail that was computed last, and the number of its states.
    recent: (usize, Trail),
}

impl TrailHistory {
    pub(crate) fn new(size: MazeSize) -> Self {
        let trail = Trail::new(size);
        Self { stride: Block::STATES, stored: vec![trail.clone()], recent: (0, trail) }
    }

    /// Returns the longest stored trail of at most `end` states, and the number of its states.
    fn nearest(&self, end: usize) -> (usize, &Trail) {
        let last = (end / self.stride).min(self.stored.len() - 1);
        let states = last * self.stride;
        if (states..=end).contains(&self.recent.0) {
            (self.recent.0, &self.recent.1)
        } else {
            (states, &self.stored[last])
        }
    }

    /// Stores the trail of the first `states` states, if it is the next one to be stored.
    fn store(&mut self, states: usize, trail: &Trail) {
        if states != self.stored.len() * self.stride {
            return;
        }
        self.stored.push(trail.clone());
        if self.stored.len() > MAX_TRAILS {
            self.stored = self.stored.drain(..).step_by(2).collect();
            self.stride *= 2;
        }
    }
}

/// Returns the number of states that must be read to compute the trail up to the state with this
/// index.
pub(crate) fn missing_states(trails: &Mutex<TrailHistory>, index: usize) -> usize {
    let trails = trails.lock().unwrap_or_else(PoisonError::into_inner);
    index + 1 - trails.nearest(index + 1).0
}

/// Returns the trail up to the state with this index. `block` returns the block that contains a
/// state. The trails are not locked while a block is read.
pub(crate) fn trail<B: Borrow<States>, E>(
    trails: &Mutex<TrailHistory>,
    index: usize,
    mut block: impl FnMut(usize) -> Result<B, E>,
) -> Result<Trail, E> {
    let locked = || trails.lock().unwrap_or_else(PoisonError::into_inner);
    let end = index + 1;
    let (mut next, mut trail) = {
        let trails = locked();
        let (states, trail) = trails.nearest(end);
        (states, trail.clone())
    };
    while next < end {
        let stop = ((next / Block::STATES + 1) * Block::STATES).min(end);
        let states = block(stop - 1)?;
        let states = states.borrow();
        let mut transitions = states.transitions();
        for index in next..stop {
            if let Some(pose) = states.message(index).and_then(|message| message.pose().ok()) {
                trail.extend(pose, states.course().walls(), |last| {
                    transitions.to(index, last).is_some_and(Transition::is_move)
                });
            }
        }
        next = stop;
        locked().store(next, &trail);
    }
    locked().recent = (end, trail.clone());
    Ok(trail)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Pose, WyRand};
    use mmsim_protocol::state_bytes;
    use mmsim_recording::History;

    use super::*;

    #[test]
    fn trails_do_not_depend_on_the_order_of_requests() {
        const STATES: usize = 2 * MAX_TRAILS * Block::STATES + 1000;
        let indices = [0, 1, 255, 256, 511, 512, 70_000, 131_071, 131_072, STATES - 1];
        let size = MazeSize::new(5, 3).unwrap();
        let (mut history, mut trail, mut expected) = (History::new(size), Trail::new(size), vec![]);
        let mut rng = WyRand::new(1);
        for index in 0..STATES {
            let [x, y, ..] = rng.next_u64().to_le_bytes();
            let pose = Pose::new(Cell::new(x % 5, y % 3), Heading::ALL[usize::from(x) % 4]);
            let letter = u8::try_from(pose.heading.letter()).unwrap();
            let mut state = vec![b'S', pose.cell.x, pose.cell.y, letter];
            state.resize(state_bytes(size), b'C');
            history.push(&state).unwrap();
            let course = history.course();
            trail.extend(pose, course.walls(), |last| course.transition(last, pose).is_move());
            if indices.contains(&index) {
                expected.push((index, trail.clone()));
            }
        }
        let trails = Mutex::new(TrailHistory::new(size));
        let at = |index| {
            super::trail(&trails, index, |index| {
                assert!(trails.try_lock().is_ok(), "locked while a block is read");
                block(&history, index)
            })
        };
        let missing = at(STATES).unwrap_err();
        assert_eq!(missing, STATES);
        let (forward, backward) = (expected.iter(), expected.iter().rev());
        for (index, expected) in forward.clone().chain(backward).chain(forward.skip(4)) {
            assert!(at(*index).unwrap() == *expected, "{index}");
        }
        let trails = trails.into_inner().unwrap();
        assert_eq!((trails.stride, trails.stored.len()), (4 * Block::STATES, 129));
    }

    fn block(history: &History, index: usize) -> Result<States, usize> {
        let block = history.block(index / Block::STATES).and_then(Block::unpack);
        block.filter(|states| states.get(index).is_some()).ok_or(index)
    }
}
