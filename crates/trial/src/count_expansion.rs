//! Count expansion, the published benchmark robot, which uses A* without a heuristic.

use mmsim_maze::{KnownMaze, Unknown};
use mmsim_solvers::centre;

use crate::one_sided_walls::OneSidedWalls;
use crate::race::straight;
use crate::robot::{Action, Robot, Rotation};
use crate::survey::Survey;

/// The published benchmark robot, which plans like the published
/// [`SwingRobot`](crate::SwingRobot), but uses A* with the heuristic set to zero. The robot moves
/// to the centre, resets, and races to the centre. The robot's scores equal the published scores.
///
/// Before each step the robot plans with A* again, with unknown walls open, and moves up to 3 cells
/// along the first straight of the path.
///
/// The robot records a wall only on the side from which it saw the wall, so a plan may still cross
/// it from the opposite side. The race is planned in the same way as the exploration, so the robot
/// may enter unexplored cells during the race.
///
/// The robot differs from the published code in two ways: it turns on the spot if it has not seen
/// the walls behind it, and it [gives up](Action::GiveUp) if no goal cell is reachable. In large
/// mazes the robot may exceed the step limit.
#[derive(Clone, Debug)]
pub struct CountExpansion {
    survey: Survey,
    walls: OneSidedWalls,
    has_visited_goal: bool,
    is_racing: bool,
}

impl CountExpansion {
    /// Creates a robot at the start of its first run.
    pub const fn new(unexplored: KnownMaze) -> Self {
        let walls = OneSidedWalls::new(unexplored.size());
        let survey = Survey::new(unexplored);
        Self { survey, walls, has_visited_goal: false, is_racing: false }
    }

    /// Returns the next step towards the centre, or `None` if the goal is unreachable.
    fn step(&self) -> Option<Action> {
        let (map, pose) = (self.survey.map(), self.survey.pose());
        let target = centre(map.goals(), map.walls(Unknown::Open), pose.cell)?;
        if target == pose.cell {
            return Some(if self.has_visited_goal && !self.is_racing {
                Action::Reset
            } else {
                Action::STAY
            });
        }
        let (heading, cells) = self.walls.first_straight(pose.cell, target, |_| 0)?;
        let seen = straight(map.walls(Unknown::Closed), pose.cell, heading).take(cells).count();
        // If the walls behind the robot are unknown, a turn on the spot reveals them.
        let turn = Action::Move { rotation: Rotation::Right, cells: 0 };
        Some(Action::towards(pose.heading, heading, seen).unwrap_or(turn))
    }
}

impl Robot for CountExpansion {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.survey.observe(sensors);
        self.walls.observe(self.survey.pose(), sensors);
        let action = self.step().unwrap_or(Action::GiveUp);
        self.is_racing |= action == Action::Reset;
        self.survey.apply(action);
        self.has_visited_goal |= self.survey.is_in_goal();
        action
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::tests::{actions, check_noisy_trials};
    use crate::trial::{TrialOutcome, run_trial};

    fn robot(maze: &Maze) -> CountExpansion {
        CountExpansion::new(KnownMaze::unexplored(maze))
    }

    fn steps(text: &str) -> Vec<String> {
        let maze: Maze = text.parse().unwrap();
        actions(&maze, &mut robot(&maze))
    }

    #[test]
    fn cells_of_a_straight_are_joined_to_one_step() {
        let corridor = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";
        assert_eq!(steps(corridor), ["(90, 3)", "(Reset, Reset)", "(90, 3)"]);
    }

    #[test]
    fn turns_before_moving_back_into_the_unknown() {
        let south = "o---o\n| S |\no   o\n| G |\no---o\n";
        assert_eq!(steps(south), ["(90, 0)", "(90, 1)", "(Reset, Reset)", "(0, -1)"]);
    }

    #[test]
    fn start_in_the_goal_and_unreachable_goal() {
        assert_eq!(steps("o---o\n|SG |\no---o\n"), ["(0, 0)", "(Reset, Reset)", "(0, 0)"]);
        let maze: Maze = "o---o\n| G |\no---o\n| S |\no---o\n".parse().unwrap();
        assert_eq!(run_trial(&maze, &mut robot(&maze)), TrialOutcome::GaveUp);
    }

    #[test]
    fn noisy_sensors_are_harmless() {
        check_noisy_trials(robot);
    }
}
