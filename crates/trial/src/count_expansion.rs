//! Count expansion: the published benchmark that floods and does not aim.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Unknown, WallState, Walls};

use crate::{Action, Robot, Rotation, Survey};

/// Count expansion: the A* of the published report on [`Swing`](crate::Swing) with the heuristic set
/// to zero. It goes to the goal, resets, and races.
///
/// Before each step it floods the maze from all goal cells over the walls noted so far, others taken
/// as open, and counts cells as the flood comes to them. Cells equally far from the goal expand
/// column by column from the west, and in a column from the south. From each cell it goes on to the
/// first neighbour, of those to the north, west, east and south, with a lower count.
///
/// It notes only the four sides of the cells where its steps end. It joins equal moves to one of up
/// to 2 cells, in the race up to 3, as far as its sensors see. Out of a dead end it turns on the spot
/// to the right when it explores, and backs a cell in the race.
///
/// The report tells the idea and the figures, not these details: they were searched for, as the rule
/// whose figures in the three published mazes come nearest to the report's. Four of six are equal.
///
/// In large mazes it may need more steps than there are. Where no goal cell can be reached it
/// [says so](Action::GiveUp).
#[derive(Clone, Debug)]
pub struct CountExpansion {
    survey: Survey,
    been_in_goal: bool,
    races: bool,
}

const ORDER: [Heading; 4] = [Heading::North, Heading::West, Heading::East, Heading::South];

impl CountExpansion {
    /// A robot that has not begun yet.
    pub const fn new(before: KnownMaze) -> Self {
        Self { survey: Survey::new(before), been_in_goal: false, races: false }
    }

    fn note(&mut self, sensors: [u8; 3]) {
        let pose = self.survey.pose();
        let sides = [pose.heading.left(), pose.heading, pose.heading.right()];
        for (side, open) in sides.into_iter().zip(sensors) {
            if self.survey.map().size().neighbour(pose.cell, side).is_some() {
                let wall = if open == 0 { WallState::Present } else { WallState::Absent };
                self.survey.believe(pose.cell, side, wall);
            }
        }
        self.survey.visit();
    }

    /// The next step towards the goal, `None` if it is cut off.
    fn step(&self, sensors: [u8; 3]) -> Option<Action> {
        let pose = self.survey.pose();
        let walls = self.survey.map().walls(Unknown::Open);
        let counts = Counts::flood(walls, self.survey.goals());
        let heading = counts.next(walls, pose.cell)?;
        if heading == pose.heading.back() {
            let is_open = self.survey.map().wall(pose.cell, heading) == WallState::Absent;
            // Nothing may be known of what lies behind: a turn on the spot lets it see.
            return Some(if self.races && is_open {
                Action::towards(pose.heading, heading, 1)
            } else {
                Action::Move { rotation: Rotation::Right, cells: 0 }
            });
        }
        let [left, ahead, right] = sensors;
        let sees = match heading {
            _ if heading == pose.heading => ahead,
            _ if heading == pose.heading.left() => left,
            _ => right,
        };
        let most = if self.races { Action::MOST_CELLS } else { 2 };
        let mut cell = pose.cell;
        let mut cells = 0;
        while cells < most.min(i8::try_from(sees).unwrap_or(i8::MAX))
            && counts.next(walls, cell) == Some(heading)
        {
            cell = cell.neighbour(heading)?;
            cells += 1;
        }
        Some(Action::towards(pose.heading, heading, cells))
    }

    /// Goes, and notes that there is no wall where it went.
    fn go(&mut self, action: Action) {
        let from = self.survey.pose().cell;
        self.survey.go(action);
        let pose = self.survey.pose();
        if let Action::Move { cells, .. } = action {
            let towards = if cells < 0 { pose.heading.back() } else { pose.heading };
            let mut here = from;
            while let Some(next) = here.neighbour(towards).filter(|_| here != pose.cell) {
                self.survey.believe(here, towards, WallState::Absent);
                here = next;
            }
        }
    }
}

impl Robot for CountExpansion {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        self.note(sensors);
        let action = match (self.survey.is_in_goal(), self.races) {
            (true, false) if self.been_in_goal => Action::Reset,
            // Only a step that ends in the goal counts.
            (true, _) => Action::STAY,
            (false, _) => self.step(sensors).unwrap_or(Action::GiveUp),
        };
        self.races |= action == Action::Reset;
        self.go(action);
        self.been_in_goal |= self.survey.is_in_goal();
        action
    }
}

/// How many cells a flood from the goal had come to before each cell.
struct Counts([u16; MazeSize::MAX_AREA]);

impl Counts {
    const NONE: u16 = u16::MAX;

    fn flood(walls: &Walls, goals: &CellSet) -> Self {
        let mut counts = Self([Self::NONE; MazeSize::MAX_AREA]);
        let mut wave: Vec<Cell> =
            goals.iter().filter(|&cell| walls.size().contains(cell)).collect();
        wave.sort_unstable_by_key(|cell| (cell.x, cell.y));
        let mut count = 0;
        for &cell in &wave {
            counts.0[Self::index(cell)] = count;
            count += 1;
        }
        while !wave.is_empty() {
            let mut next_wave = Vec::new();
            for cell in wave {
                for next in ORDER.into_iter().filter_map(|heading| open(walls, cell, heading)) {
                    let counted = &mut counts.0[Self::index(next)];
                    if *counted == Self::NONE {
                        *counted = count;
                        count += 1;
                        next_wave.push(next);
                    }
                }
            }
            next_wave.sort_unstable_by_key(|cell| (cell.x, cell.y));
            wave = next_wave;
        }
        counts
    }

    /// Where to go on from `cell`: `None` where the flood came first and where it never came.
    fn next(&self, walls: &Walls, cell: Cell) -> Option<Heading> {
        let here = self.0[Self::index(cell)];
        let is_lower = |next| self.0[Self::index(next)] < here;
        ORDER.into_iter().find(|&heading| open(walls, cell, heading).is_some_and(is_lower))
    }

    fn index(cell: Cell) -> usize {
        usize::from(cell.y) * usize::from(MazeSize::MAX_SIDE) + usize::from(cell.x)
    }
}

/// The neighbour, unless there is a wall between.
fn open(walls: &Walls, cell: Cell, heading: Heading) -> Option<Cell> {
    walls.size().neighbour(cell, heading).filter(|_| !walls.has(cell, heading))
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::{Ending, Noise, Trial, try_robot, try_watched};

    fn steps(text: &str) -> Vec<String> {
        let maze: Maze = text.parse().unwrap();
        let mut robot = CountExpansion::new(KnownMaze::before(&maze));
        let mut steps = Vec::new();
        try_watched(&maze, &mut robot, &mut Noise::none(), |_, _, action| {
            steps.push(action.to_string());
        });
        steps
    }

    #[test]
    fn moves_are_joined_further_in_the_race() {
        let corridor = "o---o---o---o---o\n| S           G |\no---o---o---o---o\n";
        assert_eq!(steps(corridor), ["(90, 2)", "(0, 1)", "(Reset, Reset)", "(90, 3)"]);
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
        let mut robot = CountExpansion::new(KnownMaze::before(&maze));
        assert_eq!(try_robot(&maze, &mut robot), Ending::GaveUp);
    }

    #[test]
    fn sensors_that_err_do_no_harm() {
        let text = "o---o---o---o\n|         G |\no   o---o   o\n| S         |\no---o---o---o\n";
        let maze: Maze = text.parse().unwrap();
        for seed in 0..50 {
            let mut robot = CountExpansion::new(KnownMaze::before(&maze));
            let mut noise = Noise::new(0.3, seed);
            let in_maze = |trial: &Trial<'_>, _, _| {
                assert!(maze.size().contains(trial.pose().cell));
            };
            try_watched(&maze, &mut robot, &mut noise, in_maze);
        }
    }
}
