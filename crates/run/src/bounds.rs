//! Bounds on the distance from the start to the goal, for a single state or for sampled states of a
//! run.

use mmsim_maze::{KnownMaze, Unknown};
use mmsim_solvers::PathBounds;
use mmsim_trial::race_optimum;
use serde::Serialize;

/// The maximum number of sampled states of a run.
const MAX_SAMPLES: usize = 512;

/// Computes the bounds of the shortest path in cells or, in a two-run trial, of the fastest race in time
/// steps. The bounds are proven if they are equal.
///
/// ```
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_run::bounds;
/// let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse()?;
/// let map = KnownMaze::unexplored(&maze);
/// assert_eq!(bounds(&map, false).optimistic, Some(2));
/// assert_eq!(bounds(&map, true).optimistic, Some(1));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub fn bounds(map: &KnownMaze, is_trial: bool) -> PathBounds {
    if !is_trial {
        return PathBounds::new(map);
    }
    let race = |unknown| race_optimum(map.walls(unknown), map.start().cell, map.goals());
    PathBounds { optimistic: race(Unknown::Open), pessimistic: race(Unknown::Closed) }
}

/// The bounds at the states of a run whose index is a multiple of `stride`. The field names are JSON
/// keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BoundsHistory {
    /// The number of states of the run.
    states: usize,
    /// The number of states from one sample to the next, a power of two.
    stride: usize,
    optimistic: Vec<Option<u16>>,
    pessimistic: Vec<Option<u16>>,
}

impl Default for BoundsHistory {
    fn default() -> Self {
        Self { states: 0, stride: 1, optimistic: Vec::new(), pessimistic: Vec::new() }
    }
}

impl BoundsHistory {
    /// Extends the history to `states` states without recomputing existing samples.
    ///
    /// # Errors
    /// Returns the error of `sample`, which returns the bounds at a state.
    pub fn extend<E>(
        &mut self,
        states: usize,
        mut sample: impl FnMut(usize) -> Result<PathBounds, E>,
    ) -> Result<(), E> {
        self.states = states;
        while states.div_ceil(self.stride) > MAX_SAMPLES {
            self.stride *= 2;
            for samples in [&mut self.optimistic, &mut self.pessimistic] {
                *samples = samples.iter().copied().step_by(2).collect();
            }
        }
        for index in (0..states).step_by(self.stride).skip(self.optimistic.len()) {
            let bounds = sample(index)?;
            self.optimistic.push(bounds.optimistic);
            self.pessimistic.push(bounds.pessimistic);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize, WallState};

    use super::*;

    #[test]
    fn bounds_assume_unknown_walls_open_or_closed() {
        let size = MazeSize::new(3, 1).unwrap();
        let goals = [Cell::new(2, 0)].into_iter().collect();
        let mut map = KnownMaze::new(size, Cell::new(0, 0), goals);
        assert_eq!(bounds(&map, false), PathBounds { optimistic: Some(2), pessimistic: None });
        assert!(!bounds(&map, false).is_proven());
        for x in 0..2 {
            map.set_wall(Cell::new(x, 0), Heading::East, WallState::Absent);
        }
        assert_eq!(bounds(&map, false), PathBounds { optimistic: Some(2), pessimistic: Some(2) });
        assert!(bounds(&map, false).is_proven());
        map.set_wall(Cell::new(0, 0), Heading::East, WallState::Present);
        assert_eq!(bounds(&map, false), PathBounds { optimistic: None, pessimistic: None });
        assert!(!bounds(&map, false).is_proven(), "without a path, no path is optimal");
    }

    #[test]
    fn extending_equals_recomputing() {
        let sample = |index: usize| {
            let optimistic = u16::try_from(index % 60_000).ok();
            let pessimistic = optimistic.filter(|steps| steps % 3 == 0);
            Ok::<_, ()>(PathBounds { optimistic, pessimistic })
        };
        let mut grown = BoundsHistory::default();
        for states in [0, 1, 2, 511, 512, 513, 514, 1024, 1025, 5000, 100_000] {
            let mut fresh = BoundsHistory::default();
            fresh.extend(states, sample).unwrap();
            grown.extend(states, sample).unwrap();
            assert_eq!(grown, fresh);
            assert!(
                grown.optimistic.len() <= MAX_SAMPLES
                    && grown.optimistic.len() == grown.pessimistic.len()
            );
            assert_eq!(grown.optimistic.len(), states.div_ceil(grown.stride));
            if let Some(last) = grown.optimistic.len().checked_sub(1) {
                let expected = sample(last * grown.stride).unwrap();
                assert_eq!(grown.optimistic[last], expected.optimistic);
            }
        }
        assert_eq!(grown.stride, 256);
    }
}
