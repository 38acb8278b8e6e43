//! Bounds on the distance from the start to the goal, for a single state or for sampled states of a
//! run.

use mmsim_maze::{KnownMaze, Unknown};
use mmsim_solvers::steps_between;
use mmsim_trial::race_optimum;
use serde::Serialize;

/// The maximum number of sampled states of a run.
const MAX_SAMPLES: usize = 512;

/// Bounds on the number of steps from the start to the nearest goal cell. A bound is `None` if
/// there is no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct DistanceBounds {
    /// A lower bound: the distance if all unknown walls are open.
    #[serde(rename = "open")]
    pub(crate) optimistic: Option<u16>,
    /// An upper bound: the distance if all unknown walls are closed.
    #[serde(rename = "closed")]
    pub(crate) pessimistic: Option<u16>,
}

impl DistanceBounds {
    /// Computes the bounds of the shortest path in cells or, in a two-run trial, of the fastest race
    /// in time steps.
    pub(crate) fn new(map: &KnownMaze, is_trial: bool) -> Self {
        let (start, goals) = (map.start().cell, map.goals());
        let distance = |unknown| {
            let walls = map.walls(unknown);
            if is_trial {
                race_optimum(walls, start, goals)
            } else {
                steps_between(walls, start, goals)
            }
        };
        Self { optimistic: distance(Unknown::Open), pessimistic: distance(Unknown::Closed) }
    }

    /// Returns true if the shortest known path is proven optimal.
    pub(crate) fn is_proven_optimal(self) -> bool {
        self.pessimistic.is_some() && self.optimistic == self.pessimistic
    }
}

/// Distance bounds at the states of a run whose index is a multiple of `stride`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct DistanceHistory {
    /// The number of states of the run.
    states: usize,
    /// The number of states from one sample to the next, a power of two.
    stride: usize,
    #[serde(rename = "open")]
    optimistic: Vec<Option<u16>>,
    #[serde(rename = "closed")]
    pessimistic: Vec<Option<u16>>,
}

impl Default for DistanceHistory {
    fn default() -> Self {
        Self { states: 0, stride: 1, optimistic: Vec::new(), pessimistic: Vec::new() }
    }
}

impl DistanceHistory {
    /// Extends the history to `states` states without recomputing existing samples.
    pub(crate) fn extend<E>(
        &mut self,
        states: usize,
        mut sample: impl FnMut(usize) -> Result<DistanceBounds, E>,
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
        assert_eq!(
            DistanceBounds::new(&map, false),
            DistanceBounds { optimistic: Some(2), pessimistic: None }
        );
        assert!(!DistanceBounds::new(&map, false).is_proven_optimal());
        for x in 0..2 {
            map.set_wall(Cell::new(x, 0), Heading::East, WallState::Absent);
        }
        assert_eq!(
            DistanceBounds::new(&map, false),
            DistanceBounds { optimistic: Some(2), pessimistic: Some(2) }
        );
        assert!(DistanceBounds::new(&map, false).is_proven_optimal());
        map.set_wall(Cell::new(0, 0), Heading::East, WallState::Present);
        assert_eq!(
            DistanceBounds::new(&map, false),
            DistanceBounds { optimistic: None, pessimistic: None }
        );
        assert!(
            !DistanceBounds::new(&map, false).is_proven_optimal(),
            "without a path, no path is optimal"
        );
    }

    #[test]
    fn extending_equals_recomputing() {
        let sample = |index: usize| {
            let optimistic = u16::try_from(index % 60_000).ok();
            let pessimistic = optimistic.filter(|steps| steps % 3 == 0);
            Ok::<_, ()>(DistanceBounds { optimistic, pessimistic })
        };
        let mut grown = DistanceHistory::default();
        for states in [0, 1, 2, 511, 512, 513, 514, 1024, 1025, 5000, 100_000] {
            let mut fresh = DistanceHistory::default();
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
