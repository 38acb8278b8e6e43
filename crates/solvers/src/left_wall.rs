//! Left wall: the left hand on the wall.

use mmsim_maze::{Cell, KnownMaze, Pose, Step};

use crate::strategy::{Move, SearchError, Strategy, steps_from};

/// Left wall: keeps the left hand on the wall, that is, takes the first open way of left, front,
/// right, back.
///
/// Its weights are all 0. It never reaches a goal that stands on an island of walls, which contest
/// mazes see to; it is here as the simplest mouse there is.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeftWall;

impl LeftWall {
    /// A search that has not begun yet.
    pub const fn new() -> Self {
        Self
    }
}

impl Strategy for LeftWall {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        if map.goals().contains(pose.cell) {
            return Ok(Move::Stop);
        }
        let is_open = |wanted: &Step| steps_from(map, pose).any(|(step, _)| step == *wanted);
        [Step::Left, Step::Front, Step::Right, Step::Back]
            .into_iter()
            .find(is_open)
            .map(Move::Step)
            .ok_or(SearchError::BoxedIn { cell: pose.cell })
    }

    fn weight(&self, _: Cell) -> u16 {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::search;

    #[test]
    fn it_follows_the_wall_to_the_goal() {
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
    fn it_circles_an_island_for_ever() {
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
