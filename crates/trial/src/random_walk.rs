//! A robot that moves at random.

use fastrand::Rng;
use mmsim_maze::KnownMaze;

use crate::action::Action;
use crate::robot::Robot;
use crate::survey::Survey;

/// The published benchmark robot that moves at random. In each step the robot makes a random turn
/// and moves 0 to 3 cells forwards. The robot resets as soon as it is in the goal. The same seed
/// gives the same moves.
#[derive(Clone, Debug)]
pub struct RandomWalk {
    survey: Survey,
    rng: Rng,
    is_racing: bool,
}

impl RandomWalk {
    /// Creates a robot at the start of its first run.
    pub fn new(unexplored: KnownMaze, seed: u64) -> Self {
        Self { survey: Survey::new(unexplored), rng: Rng::with_seed(seed), is_racing: false }
    }
}

impl Robot for RandomWalk {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.survey.observe(sensors);
        let action = if self.survey.is_in_goal() && !self.is_racing {
            self.is_racing = true;
            Action::Reset
        } else {
            Action::from_numbers(90 * self.rng.i64(-1..=1), self.rng.i64(0..=3))
        };
        self.survey.apply(action);
        action
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::robot::run_trial;
    use crate::trial::TrialOutcome;

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
}
