//! Count expansion, the published benchmark robot, which uses A* without a heuristic.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Unknown};
use mmsim_solvers::centre;

use crate::action::{Action, Rotation};
use crate::race::straight;
use crate::robot::Robot;
use crate::survey::Survey;
use crate::trial::sensor_headings;

/// The published benchmark robot, which plans like the published
/// [`SwingRobot`](crate::SwingRobot), but uses A* with the heuristic set to zero. The robot moves
/// to the centre, resets, and races to the centre. The robot's scores equal the published scores.
///
/// Before each step the robot floods the maze from its position, with unknown walls open, and
/// numbers the cells in the order in which the flood reaches them. Cells at the same distance are
/// expanded column by column from west to east, and within a column from south to north. Each cell
/// is expanded to the north, west, south and east, in that order. The plan is traced back from the
/// centre by moving from each cell to the neighbour with the lowest number. The robot moves up to 3
/// cells along the first straight of the plan.
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
    /// For each heading of [`ORDER`], the set of cells from which a wall was seen in that
    /// direction.
    walls: [CellSet; 4],
    has_visited_goal: bool,
    is_racing: bool,
}

const ORDER: [Heading; 4] = [Heading::North, Heading::West, Heading::South, Heading::East];

impl CountExpansion {
    /// Creates a robot at the start of its first run.
    pub const fn new(unexplored: KnownMaze) -> Self {
        let survey = Survey::new(unexplored);
        Self { survey, walls: [CellSet::EMPTY; 4], has_visited_goal: false, is_racing: false }
    }

    fn observe(&mut self, sensors: [u8; 3]) {
        self.survey.observe(sensors);
        let pose = self.survey.pose();
        let sides = sensor_headings(pose.heading);
        for (heading, walls) in ORDER.into_iter().zip(&mut self.walls) {
            let Some(side) = sides.iter().position(|&side| side == heading) else { continue };
            let mut here = pose.cell;
            for _ in 0..sensors[side] {
                walls.remove(here);
                let Some(next) = self.survey.map().size().neighbour(here, heading) else { break };
                here = next;
            }
            walls.insert(here);
        }
    }

    /// Returns the neighbour of `cell` in direction `ORDER[place]`, or `None` if a wall was seen
    /// from `cell` in that direction.
    fn beyond(&self, cell: Cell, place: usize) -> Option<Cell> {
        let next = self.survey.map().size().neighbour(cell, ORDER[place]);
        next.filter(|_| !self.walls[place].contains(cell))
    }

    /// Floods the maze from the cell `from`. Returns, for each reached cell, the number of cells
    /// reached before it.
    fn counts(&self, from: Cell) -> [Option<u16>; MazeSize::MAX_AREA] {
        let mut counts = [None; MazeSize::MAX_AREA];
        let mut open = BinaryHeap::from([Reverse((0_u16, from.x, from.y))]);
        counts[index(from)] = Some(0);
        let mut count = 0;
        while let Some(Reverse((steps, x, y))) = open.pop() {
            for next in (0..4).filter_map(|place| self.beyond(Cell::new(x, y), place)) {
                let counted = &mut counts[index(next)];
                if counted.is_none() {
                    count += 1;
                    *counted = Some(count);
                    open.push(Reverse((steps + 1, next.x, next.y)));
                }
            }
        }
        counts
    }

    /// Returns the heading and the length in cells of the first straight of the path to `target`.
    fn plan(&self, target: Cell) -> Option<(Heading, usize)> {
        let counts = self.counts(self.survey.pose().cell);
        let (mut cell, mut straight) = (target, None);
        while counts[index(cell)]? > 0 {
            let before = (0..4).filter_map(|place| {
                let size = self.survey.map().size();
                let before = size.neighbour(cell, ORDER[place].back())?;
                self.beyond(before, place)?;
                Some((counts[index(before)]?, before, ORDER[place]))
            });
            let (_, before, heading) = before.min_by_key(|&(count, ..)| count)?;
            straight = match straight {
                Some((same, cells)) if same == heading => Some((heading, cells + 1)),
                _ => Some((heading, 1)),
            };
            cell = before;
        }
        straight
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
        let (heading, cells) = self.plan(target)?;
        let seen = straight(map.walls(Unknown::Closed), pose.cell, heading).take(cells).count();
        // If the walls behind the robot are unknown, a turn on the spot reveals them.
        let turn = Action::Move { rotation: Rotation::Right, cells: 0 };
        Some(Action::towards(pose.heading, heading, seen).unwrap_or(turn))
    }
}

impl Robot for CountExpansion {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.observe(sensors);
        let action = self.step().unwrap_or(Action::GiveUp);
        self.is_racing |= action == Action::Reset;
        self.survey.apply(action);
        self.has_visited_goal |= self.survey.is_in_goal();
        action
    }
}

fn index(cell: Cell) -> usize {
    usize::from(cell.y) * usize::from(MazeSize::MAX_SIDE) + usize::from(cell.x)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::robot::run_trial;
    use crate::robot::tests::{actions, check_noisy_trials};
    use crate::trial::TrialOutcome;

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
