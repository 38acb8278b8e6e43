//! The phases and the trail of the mouse at each state of a run, computed from few states.

use std::borrow::Borrow;
use std::sync::{Mutex, MutexGuard, PoisonError};

use mmsim_maze::{Cell, MazeSize, Pose};
use mmsim_recording::{Block, States};

use crate::movement::MovementRules;
use crate::phases::{Phases, RunFigures};
use crate::trail::Trail;

/// The cells of runs with more states are not read.
const MAX_RUN_STATES: usize = 4096;

/// The maximum number of stored trails of a run.
const MAX_TRAILS: usize = 256;

/// What the mouse did up to each state of a growing run. The index stores the phases at the beginning
/// of each block and up to 256 trails, so it reads only few states after it has read a state once.
///
/// ```
/// use mmsim_maze::Maze;
/// use mmsim_recording::{Block, History};
/// use mmsim_run::{MovementRules, RunIndex};
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let mut history = History::new(maze.size());
/// history.push(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// history.push(b"S\x01\x00EC\x01\x00C\x0d\x17")?;
/// let index = RunIndex::new(maze.size(), MovementRules::from_maze(&maze));
/// let block = |state| history.block(state / Block::STATES).and_then(Block::unpack).ok_or(state);
/// let (phases, trail) = index.at(1, block).expect("a state");
/// assert!(phases.is_goal_reached());
/// assert_eq!(trail.passages().len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct RunIndex {
    rules: MovementRules,
    stored: Mutex<Stored>,
}

/// What the mouse did in the first states of a run.
type Prefix = (Phases, Trail);

#[derive(Debug)]
struct Stored {
    /// The phases before the first state of each block.
    phases: Vec<Phases>,
    /// The trail before each state whose index is a multiple of `stride`.
    trails: Vec<Trail>,
    /// The number of states from one stored trail to the next, a multiple of [`Block::STATES`].
    stride: usize,
    /// The prefix that was computed last.
    recent: Prefix,
}

impl RunIndex {
    /// Creates the index of a run of which no state has been read.
    pub fn new(size: MazeSize, rules: MovementRules) -> Self {
        let (phases, trail) = (Phases::default(), Trail::new(size));
        let (trails, recent) = (vec![trail.clone()], (phases, trail));
        let stored = Stored { phases: vec![phases], trails, stride: Block::STATES, recent };
        Self { rules, stored: Mutex::new(stored) }
    }

    /// Returns the number of states that [`at`](Self::at) must read.
    pub fn missing_states(&self, state: usize) -> usize {
        state + 1 - self.lock().nearest(state + 1).0.states as usize
    }

    /// Returns the phases and the trail up to a state. `block` returns the block that contains a
    /// state. Other threads can use the index while a block is read.
    ///
    /// # Errors
    /// Returns the error of `block`.
    pub fn at<B: Borrow<States>, E>(
        &self,
        state: usize,
        mut block: impl FnMut(usize) -> Result<B, E>,
    ) -> Result<Prefix, E> {
        let end = state + 1;
        let (mut phases, mut trail) = self.lock().nearest(end);
        while (phases.states as usize) < end {
            let next = phases.states as usize;
            let stop = ((next / Block::STATES + 1) * Block::STATES).min(end);
            let states = block(stop - 1)?;
            for (pose, has_restart) in states.borrow().poses(next).take(stop - next) {
                self.add(&mut phases, pose, has_restart);
                trail.add(&self.rules, &phases);
            }
            if (phases.states as usize) < stop {
                // The block is shorter than it should be.
                break;
            }
            self.lock().store((&phases, &trail));
        }
        self.lock().recent = (phases, trail.clone());
        Ok((phases, trail))
    }

    /// Returns the phases up to a state, like [`at`](Self::at).
    ///
    /// # Errors
    /// Returns the error of `block`.
    pub fn phases<B: Borrow<States>, E>(
        &self,
        state: usize,
        mut block: impl FnMut(usize) -> Result<B, E>,
    ) -> Result<Phases, E> {
        let number = state / Block::STATES;
        let stored = self.lock().phases.get(number).copied();
        let Some(mut phases) = stored else { return Ok(self.at(state, block)?.0) };
        let states = block(state)?;
        let count = state % Block::STATES + 1;
        for (pose, has_restart) in states.borrow().poses(number * Block::STATES).take(count) {
            self.add(&mut phases, pose, has_restart);
        }
        Ok(phases)
    }

    /// Returns the cells of a run in order, or none of a run with more than 4096 states. `block` returns
    /// the block that contains a state.
    ///
    /// # Errors
    /// Returns the error of `block`.
    pub fn cells<B: Borrow<States>, E>(
        &self,
        run: RunFigures,
        mut block: impl FnMut(usize) -> Result<B, E>,
    ) -> Result<Vec<Cell>, E> {
        let (mut next, end, mut cells) = (run.first as usize, run.last as usize + 1, Vec::new());
        if end.saturating_sub(next) > MAX_RUN_STATES {
            return Ok(cells);
        }
        while next < end {
            let stop = ((next / Block::STATES + 1) * Block::STATES).min(end);
            for (pose, _) in block(next)?.borrow().poses(next).take(stop - next) {
                pose.inspect(|pose| self.rules.extend_path(&mut cells, pose.cell));
            }
            next = stop;
        }
        Ok(cells)
    }

    fn add(&self, phases: &mut Phases, pose: Option<Pose>, has_restart: bool) {
        match pose {
            Some(pose) => phases.add(&self.rules, pose, has_restart),
            None => phases.skip(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Stored> {
        self.stored.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stored {
    /// Returns the longest stored prefix of at most `end` states.
    fn nearest(&self, end: usize) -> Prefix {
        let last = (end / self.stride).min(self.trails.len() - 1);
        let states = last * self.stride;
        if (states..=end).contains(&(self.recent.0.states as usize)) {
            self.recent.clone()
        } else {
            (self.phases[states / Block::STATES], self.trails[last].clone())
        }
    }

    /// Stores a prefix that ends at the end of a block, if it is the next one to be stored.
    fn store(&mut self, (phases, trail): (&Phases, &Trail)) {
        let states = phases.states as usize;
        if states == self.phases.len() * Block::STATES {
            self.phases.push(*phases);
        }
        if states == self.trails.len() * self.stride {
            self.trails.push(trail.clone());
            if self.trails.len() > MAX_TRAILS {
                self.trails = self.trails.drain(..).step_by(2).collect();
                self.stride *= 2;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, Pose, WyRand};
    use mmsim_protocol::state_bytes;
    use mmsim_recording::History;

    use super::*;

    #[test]
    fn prefixes_do_not_depend_on_the_order_of_requests() {
        const STATES: usize = 2 * MAX_TRAILS * Block::STATES + 1000;
        let indices = [0, 1, 255, 256, 511, 512, 70_000, 131_071, 131_072, STATES - 1];
        let size = MazeSize::new(5, 3).unwrap();
        let (mut history, mut trail, mut expected) = (History::new(size), Trail::new(size), vec![]);
        let rules = MovementRules::new(
            Pose::new(Cell::new(0, 0), Heading::North),
            size.central_cells(),
            None,
        );
        let (mut rng, mut phases) = (WyRand::new(1), Phases::default());
        for index in 0..STATES {
            let [x, y, ..] = rng.next_u64().to_le_bytes();
            let pose = Pose::new(Cell::new(x % 5, y % 3), Heading::ALL[usize::from(x) % 4]);
            let letter = u8::try_from(pose.heading.letter()).unwrap();
            let mut state = vec![b'S', pose.cell.x, pose.cell.y, letter];
            state.resize(state_bytes(size), b'C');
            history.push(&state).unwrap();
            phases.add(&rules, pose, false);
            trail.add(&rules, &phases);
            if indices.contains(&index) {
                expected.push((index, (phases, trail.clone())));
            }
        }
        let run = RunIndex::new(size, rules);
        let read = |index| {
            assert!(run.stored.try_lock().is_ok(), "locked while a block is read");
            block(&history, index)
        };
        let at = |index| run.at(index, read);
        let missing = at(STATES).unwrap_err();
        assert_eq!(missing, STATES);
        let (forward, backward) = (expected.iter(), expected.iter().rev());
        for (index, expected) in forward.clone().chain(backward).chain(forward.skip(4)) {
            assert!(at(*index).unwrap() == *expected, "{index}");
            assert_eq!(run.phases(*index, read).unwrap(), expected.0, "{index}");
        }
        let stored = run.stored.into_inner().unwrap();
        assert_eq!((stored.stride, stored.trails.len()), (4 * Block::STATES, 129));
    }

    fn block(history: &History, index: usize) -> Result<States, usize> {
        let block = history.block(index / Block::STATES).and_then(Block::unpack);
        block.filter(|states| states.get(index).is_some()).ok_or(index)
    }
}
