//! What the way to the goal costs by what a mouse knows, at one moment and over a run.

use mmsim_maze::{KnownMaze, Unknown};
use mmsim_solvers::Distances;
use serde::Serialize;

use crate::api_error::ApiError;
use crate::source::Source;

/// At how many states of a run costs are told at most.
const MAX_COSTS: usize = 512;

/// Steps from the start to the nearest goal cell, `None` where there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cost {
    /// With unknown walls open: no way is shorter.
    pub(crate) open: Option<u16>,
    /// With unknown walls closed: a way that is known.
    pub(crate) closed: Option<u16>,
}

impl Cost {
    pub(crate) fn of(map: &KnownMaze) -> Self {
        let over = |unknown| Distances::flood(map.walls(unknown), map.goals()).at(map.start());
        Self { open: over(Unknown::Open), closed: over(Unknown::Closed) }
    }

    /// Whether the known way is the shortest there is.
    pub(crate) fn solved(self) -> bool {
        self.closed.is_some() && self.open == self.closed
    }
}

/// Costs at every so many states of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Costs {
    /// How many states there were.
    states: usize,
    /// From each state told of to the next: a power of two.
    stride: usize,
    open: Vec<Option<u16>>,
    closed: Vec<Option<u16>>,
}

impl Default for Costs {
    fn default() -> Self {
        Self { states: 0, stride: 1, open: Vec::new(), closed: Vec::new() }
    }
}

impl Costs {
    /// Costs over a run as it is now; those that were told before are not computed again.
    pub(crate) fn over(source: &Source, run: u32) -> Result<Self, ApiError> {
        let (described, states) = (source.describe(run)?, source.states(run)?);
        let mut costs = source.costs(run);
        costs.grow(states, |index| {
            let block = source.read(run, index)?;
            let message = block.get(index).ok_or_else(|| ApiError::failed("expected a state"))?;
            Ok::<_, ApiError>(Cost::of(&described.read(message)?.1))
        })?;
        source.keep_costs(run, costs.clone());
        Ok(costs)
    }

    fn grow<E>(
        &mut self,
        states: usize,
        mut cost_at: impl FnMut(usize) -> Result<Cost, E>,
    ) -> Result<(), E> {
        self.states = states;
        while states.div_ceil(self.stride) > MAX_COSTS {
            self.stride *= 2;
            for costs in [&mut self.open, &mut self.closed] {
                let mut index = 0;
                costs.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
            }
        }
        for index in (0..states).step_by(self.stride).skip(self.open.len()) {
            let Cost { open, closed } = cost_at(index)?;
            self.open.push(open);
            self.closed.push(closed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize, WallState};

    use super::*;

    #[test]
    fn unknown_walls_are_open_or_closed() {
        let size = MazeSize::new(3, 1).unwrap();
        let goals = [Cell::new(2, 0)].into_iter().collect();
        let mut map = KnownMaze::new(size, Cell::new(0, 0), goals);
        assert_eq!(Cost::of(&map), Cost { open: Some(2), closed: None });
        assert!(!Cost::of(&map).solved());
        for x in 0..2 {
            map.set_wall(Cell::new(x, 0), Heading::East, WallState::Absent);
        }
        assert_eq!(Cost::of(&map), Cost { open: Some(2), closed: Some(2) });
        assert!(Cost::of(&map).solved());
        map.set_wall(Cell::new(0, 0), Heading::East, WallState::Present);
        assert_eq!(Cost::of(&map), Cost { open: None, closed: None });
        assert!(!Cost::of(&map).solved(), "no way is no solution");
    }

    #[test]
    fn costs_that_grow_are_those_told_at_once() {
        let cost_at = |index: usize| {
            let open = u16::try_from(index % 60_000).ok();
            Ok::<_, ()>(Cost { open, closed: open.filter(|open| open % 3 == 0) })
        };
        let mut grown = Costs::default();
        for states in [0, 1, 2, 511, 512, 513, 514, 1024, 1025, 5000, 100_000] {
            let mut at_once = Costs::default();
            at_once.grow(states, cost_at).unwrap();
            grown.grow(states, cost_at).unwrap();
            assert_eq!(grown, at_once);
            assert!(grown.open.len() <= MAX_COSTS && grown.open.len() == grown.closed.len());
            assert_eq!(grown.open.len(), states.div_ceil(grown.stride));
            if let Some(last) = grown.open.len().checked_sub(1) {
                assert_eq!(grown.open[last], cost_at(last * grown.stride).unwrap().open);
            }
        }
        assert_eq!(grown.stride, 256);
    }
}
