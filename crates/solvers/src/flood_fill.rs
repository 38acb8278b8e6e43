//! The flood-fill strategy, which goes to the neighbour nearest to the goal.

use mmsim_maze::{Cell, KnownMaze, MazeSize, Pose, Unknown};

use crate::flood::{Distances, UNREACHABLE};
use crate::strategy::{Move, SearchError, Strategy, step_to_least};

/// A strategy that goes to the neighbour with the shortest optimistic distance to the goal. The
/// strategy floods the maze again only if new walls change a distance.
///
/// The weight of a cell is its distance in steps to the goal. The strategy always reaches the goal,
/// or reports that the goal is unreachable.
#[derive(Clone, Debug)]
pub struct FloodFill {
    distances: Distances,
    has_begun: bool,
}

impl FloodFill {
    /// Creates the strategy in its initial state.
    pub const fn new() -> Self {
        Self { distances: Distances::unreachable(MazeSize::CLASSIC), has_begun: false }
    }
}

impl Default for FloodFill {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for FloodFill {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let open = map.walls(Unknown::Open);
        if self.has_begun {
            self.distances.update(open, map.goals(), pose.cell);
        } else {
            self.distances.reflood(open, map.goals());
            self.has_begun = true;
        }
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        step_to_least(map, pose, self.distances.raw_around(pose.cell).map(u32::from))
            .filter(|&(_, steps)| steps < UNREACHABLE.into())
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::GoalUnreachable { cell: pose.cell })
    }

    fn reconsider(&mut self) {
        self.has_begun = false;
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        self.distances.at(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Outcome, search};

    #[test]
    fn learns_from_dead_ends_and_reaches_the_goal() {
        let maze = "\
o---o---o---o
|       | G |
o   o   o   o
|   |   |   |
o   o---o   o
| S |       |
o   o   o   o
|           |
o---o---o---o
";
        let outcome = search(FloodFill::new(), maze, 100);
        assert_eq!(outcome.result, Ok(Move::Stop));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o
        | 8   9 | ^ |
        o   o   o   o
        | 7 |10 | 1 |
        o   o---o   o
        | 6 | 3   2 |
        o   o   o   o
        | 5   4   3 |
        o---o---o---o
        ");
    }

    #[test]
    fn reports_an_unreachable_goal() {
        let maze = "\
o---o---o
|   | G |
o   o---o
| S     |
o---o---o
";
        let Outcome { result, steps, .. } = search(FloodFill::new(), maze, 100);
        assert!(matches!(result, Err(SearchError::GoalUnreachable { .. })), "{result:?}");
        assert!(steps <= 3, "it reports this after {steps} steps");
    }
}
