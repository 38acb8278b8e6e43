//! Random: the published benchmark that thinks least.

use fastrand::Rng;
use mmsim_maze::KnownMaze;

use crate::{Action, Robot, Survey};

/// Random: in each step any turn and any move, 0 to 3 cells ahead; it resets as soon as it has been
/// in the goal. The same seed gives the same moves.
#[derive(Clone, Debug)]
pub struct Random {
    survey: Survey,
    rng: Rng,
    races: bool,
}

impl Random {
    /// A robot that has not begun yet.
    pub fn new(before: KnownMaze, seed: u64) -> Self {
        Self { survey: Survey::new(before), rng: Rng::with_seed(seed), races: false }
    }
}

impl Robot for Random {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.survey.observe(sensors);
        let action = if self.survey.is_in_goal() && !self.races {
            self.races = true;
            Action::Reset
        } else {
            Action::from_numbers(90 * self.rng.i64(-1..=1), self.rng.i64(0..=3))
        };
        self.survey.go(action);
        action
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::{Ending, try_robot};

    #[test]
    fn the_same_seed_gives_the_same_score() {
        let maze: Maze =
            "o---o---o---o\n|         G |\no   o---o---o\n| S     |   |\no---o---o---o\n"
                .parse()
                .unwrap();
        let ending = |seed| try_robot(&maze, &mut Random::new(KnownMaze::unexplored(&maze), seed));
        assert!(matches!(ending(1), Ending::Scored(_)), "{:?}", ending(1));
        assert_eq!(ending(1), ending(1));
        assert!((2..9).any(|seed| ending(seed) != ending(1)));
    }
}
