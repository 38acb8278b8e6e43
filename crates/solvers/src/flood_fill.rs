//! Flood fill: always downhill towards the goal.

use mmsim_maze::{Cell, KnownMaze, MazeSize, Pose, Unknown};

use crate::flood::{Distances, UNREACHABLE};
use crate::strategy::{Move, SearchError, Strategy, step_to_least};

/// Flood fill: takes unknown walls as open, floods the maze from the goal whenever new walls change anything, and goes
/// to the neighbour nearest to the goal.
///
/// Its weights are distances to the goal in steps. It reaches the goal wherever there is a way,
/// and says so where there is none.
#[derive(Clone, Debug)]
pub struct FloodFill {
    distances: Distances,
    begun: bool,
}

impl FloodFill {
    /// A search that has not begun yet.
    pub const fn new() -> Self {
        Self { distances: Distances::unreachable(MazeSize::CLASSIC), begun: false }
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
        if self.begun {
            self.distances.update(open, map.goals(), pose.cell);
        } else {
            self.distances.refill(open, map.goals());
            self.begun = true;
        }
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        step_to_least(map, pose, self.distances.raw_around(pose.cell).map(u32::from))
            .filter(|&(_, steps)| steps < UNREACHABLE.into())
            .map(|(step, _)| Move::Step(step))
            .ok_or(SearchError::GoalUnreachable { cell: pose.cell })
    }

    fn weight(&self, cell: Cell) -> u16 {
        self.distances.raw(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Outcome, search};

    #[test]
    fn it_goes_to_the_goal_and_learns_from_dead_ends() {
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
    fn a_goal_without_a_way_is_reported() {
        let maze = "\
o---o---o
|   | G |
o   o---o
| S     |
o---o---o
";
        let Outcome { result, steps, .. } = search(FloodFill::new(), maze, 100);
        assert!(matches!(result, Err(SearchError::GoalUnreachable { .. })), "{result:?}");
        assert!(steps <= 3, "it knows after {steps} steps");
    }
}
