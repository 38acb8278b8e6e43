//! A robot that moves at random.

use mmsim_maze::{KnownMaze, WyRand};

use crate::robot::{Action, Robot, Rotation};
use crate::survey::Survey;

/// The published benchmark robot that moves at random. In each step the robot picks one of the open
/// directions (left, ahead or right) and moves 1 to 3 cells in this direction. In a dead end, the
/// robot reverses 1 to 3 cells. The robot resets as soon as it is in the goal. The same seed gives the same moves.
#[derive(Clone, Debug)]
pub struct RandomWalk {
    survey: Survey,
    rng: WyRand,
    is_racing: bool,
}

impl RandomWalk {
    /// Creates a robot at the start of its first run.
    pub fn new(unexplored: KnownMaze, seed: u64) -> Self {
        Self { survey: Survey::new(unexplored), rng: WyRand::new(seed), is_racing: false }
    }

    fn random_move(&mut self, sensors: [u8; 3]) -> Action {
        let mut open = Rotation::ALL.into_iter().zip(sensors).filter(|&(_, cells)| cells > 0);
        let count = open.clone().count();
        match open.nth(self.rng.index(count)) {
            Some((rotation, free)) => Action::Move { rotation, cells: self.random_cells(free) },
            None => Action::Move { rotation: Rotation::None, cells: -self.random_cells(u8::MAX) },
        }
    }

    /// Returns a random number of cells that the robot can move if `free` cells are free.
    fn random_cells(&mut self, free: u8) -> i8 {
        let max = i8::try_from(free).unwrap_or(i8::MAX).min(Action::MAX_CELLS);
        1 + i8::try_from(self.rng.below(max.unsigned_abs().into())).unwrap_or(0)
    }
}

impl Robot for RandomWalk {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.survey.observe(sensors);
        let action = if self.survey.is_in_goal() && !self.is_racing {
            self.is_racing = true;
            Action::Reset
        } else {
            self.random_move(sensors)
        };
        self.survey.apply(action);
        action
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::trial::{TrialOutcome, run_trial};

    #[test]
    fn the_same_seed_gives_the_same_score() {
        let maze: Maze =
            "o---o---o---o\n|         G |\no   o---o---o\n| S     |   |\no---o---o---o\n"
                .parse()
                .unwrap();
        let outcome =
            |seed| run_trial(&maze, &mut RandomWalk::new(KnownMaze::unexplored(&maze), seed));
        assert!(matches!(outcome(1), TrialOutcome::Scored(_)), "{:?}", outcome(1));
        assert_eq!(outcome(1), outcome(1));
        assert!((2..9).any(|seed| outcome(seed) != outcome(1)));
    }

    #[test]
    fn moves_only_in_open_directions() {
        let mut robot = RandomWalk::new(
            KnownMaze::new(
                mmsim_maze::MazeSize::CLASSIC,
                mmsim_maze::Cell::new(0, 0),
                mmsim_maze::CellSet::EMPTY,
            ),
            1,
        );
        for _ in 0..100 {
            let right = Action::Move { rotation: Rotation::Right, cells: 1 };
            assert_eq!(robot.next_move([0, 0, 1]), right);
            let Action::Move { rotation, cells } = robot.next_move([u8::MAX, 2, 0]) else {
                panic!("a reset")
            };
            let max = if rotation == Rotation::Left { 3 } else { 2 };
            assert!(rotation != Rotation::Right && (1..=max).contains(&cells));
            let Action::Move { rotation, cells } = robot.next_move([0; 3]) else {
                panic!("a reset")
            };
            assert!(rotation == Rotation::None && (-3..=-1).contains(&cells), "a dead end");
        }
    }
}
