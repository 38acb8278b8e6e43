//! Count expansion: the published benchmark that floods and does not aim.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Unknown};
use mmsim_solvers::centre;

use crate::race::straight;
use crate::{Action, Robot, Rotation, Survey};

/// Count expansion: the A* of the published [`Swing`](crate::Swing) with the heuristic set to zero.
/// It goes to the centre, resets, and races there. Its figures equal the published ones.
///
/// Before each step it floods the maze from where it stands over the walls noted so far, others
/// taken as open, and counts cells as the flood comes to them. Cells equally far from it expand
/// column by column from the west, and in a column from the south, to the north, west, south and
/// east. From the centre the plan then goes back to the neighbour with the lowest count, and so on:
/// not always the shortest way. Of that it takes the first straight, up to 3 cells.
///
/// Where its sensors see a wall, it notes it on the near side only and still plans to pass from the
/// far side. In the race it plans in the same way, so that it tries ways which it has never seen.
///
/// The rules are those of the published code. In addition it turns on the spot where it has not seen
/// what lies behind, and [says so](Action::GiveUp) where no goal cell can be reached. In large
/// mazes it may need more steps than there are.
#[derive(Clone, Debug)]
pub struct CountExpansion {
    survey: Survey,
    /// Cells with a wall to the north of them, and so on by [`ORDER`], as seen from within.
    walls: [CellSet; 4],
    been_in_goal: bool,
    races: bool,
}

const ORDER: [Heading; 4] = [Heading::North, Heading::West, Heading::South, Heading::East];

impl CountExpansion {
    /// A robot that has not begun yet.
    pub const fn new(before: KnownMaze) -> Self {
        let survey = Survey::new(before);
        Self { survey, walls: [CellSet::EMPTY; 4], been_in_goal: false, races: false }
    }

    fn observe(&mut self, sensors: [u8; 3]) {
        self.survey.observe(sensors);
        let pose = self.survey.pose();
        let sides = [pose.heading.left(), pose.heading, pose.heading.right()];
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

    /// The cell on the other side, unless a wall was noted on this one.
    fn beyond(&self, cell: Cell, place: usize) -> Option<Cell> {
        let next = self.survey.map().size().neighbour(cell, ORDER[place]);
        next.filter(|_| !self.walls[place].contains(cell))
    }

    /// How many cells a flood from `from` had come to before each cell.
    fn counts(&self, from: Cell) -> Counts {
        let mut counts = Counts([None; MazeSize::MAX_AREA]);
        let mut open = BinaryHeap::from([Reverse((0_u16, from.x, from.y))]);
        counts.0[index(from)] = Some(0);
        let mut count = 0;
        while let Some(Reverse((steps, x, y))) = open.pop() {
            for next in (0..4).filter_map(|place| self.beyond(Cell::new(x, y), place)) {
                let counted = &mut counts.0[index(next)];
                if counted.is_none() {
                    count += 1;
                    *counted = Some(count);
                    open.push(Reverse((steps + 1, next.x, next.y)));
                }
            }
        }
        counts
    }

    /// The first straight on the way to `target`: where it goes and how many cells.
    fn plan(&self, target: Cell) -> Option<(Heading, usize)> {
        let counts = self.counts(self.survey.pose().cell);
        let (mut cell, mut straight) = (target, None);
        while counts.of(cell)? > 0 {
            let before = (0..4).filter_map(|place| {
                let size = self.survey.map().size();
                let before = size.neighbour(cell, ORDER[place].back())?;
                self.beyond(before, place)?;
                Some((counts.of(before)?, before, ORDER[place]))
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

    /// The next step towards the centre, `None` if the goal is cut off.
    fn step(&self) -> Option<Action> {
        let (map, pose) = (self.survey.map(), self.survey.pose());
        let target = centre(map.goals(), map.walls(Unknown::Open), pose.cell)?;
        if target == pose.cell {
            return Some(if self.been_in_goal && !self.races {
                Action::Reset
            } else {
                Action::STAY
            });
        }
        let (heading, cells) = self.plan(target)?;
        let seen = straight(map.walls(Unknown::Closed), pose.cell, heading).take(cells).count();
        // Nothing may be known of what lies behind: a turn on the spot lets it see.
        let turn = Action::Move { rotation: Rotation::Right, cells: 0 };
        let cells = i8::try_from(seen).ok().filter(|&cells| cells > 0);
        Some(cells.map_or(turn, |cells| Action::towards(pose.heading, heading, cells)))
    }
}

impl Robot for CountExpansion {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.observe(sensors);
        let action = self.step().unwrap_or(Action::GiveUp);
        self.races |= action == Action::Reset;
        self.survey.go(action);
        self.been_in_goal |= self.survey.is_in_goal();
        action
    }
}

struct Counts([Option<u16>; MazeSize::MAX_AREA]);

impl Counts {
    fn of(&self, cell: Cell) -> Option<u16> {
        self.0[index(cell)]
    }
}

fn index(cell: Cell) -> usize {
    usize::from(cell.y) * usize::from(MazeSize::MAX_SIDE) + usize::from(cell.x)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::{Ending, Noise, Trial, try_robot, try_watched};

    fn steps(text: &str) -> Vec<String> {
        let maze: Maze = text.parse().unwrap();
        let mut robot = CountExpansion::new(KnownMaze::unexplored(&maze));
        let mut steps = Vec::new();
        try_watched(&maze, &mut robot, &mut Noise::none(), |_, _, action| {
            steps.push(action.to_string());
        });
        steps
    }

    #[test]
    fn equal_moves_are_joined() {
        let corridor = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";
        assert_eq!(steps(corridor), ["(90, 3)", "(Reset, Reset)", "(90, 3)"]);
    }

    #[test]
    fn what_lies_behind_is_looked_at_first() {
        let south = "o---o\n| S |\no   o\n| G |\no---o\n";
        assert_eq!(steps(south), ["(90, 0)", "(90, 1)", "(Reset, Reset)", "(0, -1)"]);
    }

    #[test]
    fn a_start_in_the_goal_and_a_goal_cut_off() {
        assert_eq!(steps("o---o\n|SG |\no---o\n"), ["(0, 0)", "(Reset, Reset)", "(0, 0)"]);
        let maze: Maze = "o---o\n| G |\no---o\n| S |\no---o\n".parse().unwrap();
        let mut robot = CountExpansion::new(KnownMaze::unexplored(&maze));
        assert_eq!(try_robot(&maze, &mut robot), Ending::GaveUp);
    }

    #[test]
    fn sensors_that_err_do_no_harm() {
        let text = "o---o---o---o\n|         G |\no   o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for seed in 0..50 {
            let mut robot = CountExpansion::new(KnownMaze::unexplored(&maze));
            let mut noise = Noise::new(0.3, seed);
            let in_maze = |trial: &Trial<'_>, _, _| {
                assert!(maze.size().contains(trial.pose().cell));
            };
            try_watched(&maze, &mut robot, &mut noise, in_maze);
        }
    }
}
