//! The left-wall follower.

use mmsim_maze::{Cell, KnownMaze, Pose, Step};

use crate::strategy::{Move, SearchError, Strategy, open_steps};

/// A left-wall follower, which takes the first open step in the order left, front, right, back.
///
/// A wall follower never reaches a goal whose walls are not connected to the outer wall, and most
/// contest mazes have such a goal. The left-wall follower is the simplest strategy and serves as an
/// example. The weight of every cell is 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeftWall;

impl LeftWall {
    /// Creates the strategy.
    pub const fn new() -> Self {
        Self
    }
}

impl Strategy for LeftWall {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        let is_open = |wanted: &Step| open_steps(map, pose).any(|(step, _)| step == *wanted);
        [Step::Left, Step::Front, Step::Right, Step::Back]
            .into_iter()
            .find(is_open)
            .map(Move::Step)
            .ok_or(SearchError::BoxedIn { cell: pose.cell })
    }

    fn weight(&self, _: Cell) -> Option<u16> {
        Some(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::search;

    #[test]
    fn reaches_a_goal_on_the_outer_wall() {
        let maze = "\
o---o---o---o
|         G |
o   o---o---o
| S         |
o---o---o---o
";
        let outcome = search(LeftWall::new(), maze, 100);
        assert_eq!((outcome.result, outcome.steps), (Ok(Move::Stop), 3));
    }

    #[test]
    fn circles_an_island_until_the_limit() {
        let maze = "\
o---o---o---o---o
|               |
o   o---o   o   o
|   |     G |   |
o   o   o---o   o
| S             |
o---o---o---o---o
";
        let outcome = search(LeftWall::new(), maze, 1000);
        assert_eq!(outcome.steps, 1000);
    }
}
