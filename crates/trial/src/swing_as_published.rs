//! Swing exactly as it was published, with its heuristic and its faults.

use std::collections::VecDeque;

use mmsim_maze::{Cell, KnownMaze, Pose, Walls};

use crate::one_sided_walls::OneSidedWalls;
use crate::race::moved;
use crate::robot::{Action, Robot};
use crate::swing::{KeyPoints, Variant};

/// The published robot that visits key points, step by step as it was published.
///
/// [`SwingRobot`](crate::SwingRobot) is the same idea with a correct A* search. This robot differs
/// as the published program does:
///
/// - Its heuristic is not the Manhattan distance in the west column and in the south row, so some
///   paths are longer than necessary.
/// - A wall closes a side only for a robot that comes from the side on which the wall was seen.
/// - The robot plans each race step with unknown walls open, so it explores during the race.
/// - It does not notice moves that a wall has cut short.
/// - If there is no path to the next key point, the published program crashes. This robot then
///   [fails](Action::Fail).
#[derive(Clone, Debug)]
pub struct SwingAsPublished {
    walls: OneSidedWalls,
    pose: Pose,
    start: Pose,
    centre: Cell,
    /// The maze without inner walls. The robot does not notice that a wall cuts a move short.
    open: Walls,
    /// The key points that the robot has not reached in this run.
    key_points: VecDeque<Cell>,
    /// The key point to which there is no path.
    unreachable: Option<Cell>,
}

impl SwingAsPublished {
    /// Creates a robot that makes one of the tours of the published report. Some labels in the
    /// report do not match the tours that its figures come from; these are the tours of the figures.
    ///
    /// | variant | key points | tour |
    /// |---|---|---|
    /// | [`JustArrive`](Variant::JustArrive) | | centre |
    /// | [`ArriveAndBack`](Variant::ArriveAndBack) | | centre, start, bottom right |
    /// | [`All`](Variant::All) | 0 | centre, start, centre (not in the report) |
    /// | [`All`](Variant::All) | 1 | centre, top left, start, centre, top right, centre, bottom right, centre |
    /// | [`All`](Variant::All) | 2 | centre, top left, bottom right, centre, start, centre, top right, centre |
    /// | [`All`](Variant::All) | 3 | centre, top left, bottom right, centre, top right, centre, start, centre |
    pub fn new(unexplored: &KnownMaze, variant: Variant, key_points: KeyPoints) -> Self {
        Self::with_tour(unexplored, &Self::tour(unexplored, variant, key_points))
    }

    /// Returns the key points of a tour, in the order in which the robot visits them.
    pub fn tour(unexplored: &KnownMaze, variant: Variant, key_points: KeyPoints) -> Vec<Cell> {
        let (size, start) = (unexplored.size(), unexplored.start());
        let (c, s) = (centre(unexplored), start.cell);
        let (east, north) = (size.width() - 1, size.height() - 1);
        let (tl, tr, br) = (Cell::new(0, north), Cell::new(east, north), Cell::new(east, 0));
        let tour: &[Cell] = match (variant, key_points.number()) {
            (Variant::JustArrive, _) => &[c],
            (Variant::ArriveAndBack, _) => &[c, s, br],
            (Variant::All, 0) => &[c, s, c],
            (Variant::All, 1) => &[c, tl, s, c, tr, c, br, c],
            (Variant::All, 2) => &[c, tl, br, c, s, c, tr, c],
            (Variant::All, _) => &[c, tl, br, c, tr, c, s, c],
        };
        tour.to_vec()
    }

    /// Creates a robot that visits these cells in this order before its race.
    pub fn with_tour(unexplored: &KnownMaze, tour: &[Cell]) -> Self {
        Self {
            walls: OneSidedWalls::new(unexplored.size()),
            pose: unexplored.start(),
            start: unexplored.start(),
            centre: centre(unexplored),
            open: Walls::open(unexplored.size()),
            key_points: tour.iter().copied().collect(),
            unreachable: None,
        }
    }

    /// Returns the published heuristic: the number of columns plus the number of rows between two
    /// cells, but the width of the maze minus one for a cell in the west column, plus nothing for a
    /// cell in the south row.
    fn heuristic(&self, from: Cell, to: Cell) -> u16 {
        let columns =
            if from.x == 0 { self.open.size().width() - 1 } else { from.x.abs_diff(to.x) };
        let rows = if from.y == 0 { 0 } else { from.y.abs_diff(to.y) };
        u16::from(columns) + u16::from(rows)
    }
}

/// Returns the cell north-west of the middle of the maze.
fn centre(unexplored: &KnownMaze) -> Cell {
    let size = unexplored.size();
    Cell::new((size.width() / 2).saturating_sub(1), size.height() / 2)
}

impl Robot for SwingAsPublished {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        let Some(&target) = self.key_points.front() else {
            self.pose = self.start;
            self.key_points.push_back(self.centre);
            return Action::Reset;
        };
        self.walls.observe(self.pose, sensors);
        let straight =
            self.walls.first_straight(self.pose.cell, target, |cell| self.heuristic(cell, target));
        let action = straight.and_then(|(heading, cells)| {
            Action::towards(self.pose.heading, heading, cells.min(Action::MAX_CELLS as usize))
        });
        let Some(action) = action else {
            self.unreachable = Some(target);
            return Action::Fail;
        };
        if let Action::Move { rotation, cells } = action {
            self.pose = moved(&self.open, self.pose, rotation, cells);
        }
        if self.pose.cell == target {
            self.key_points.pop_front();
        }
        action
    }

    fn failure(&self) -> Option<String> {
        self.unreachable
            .map(|target| format!("no path to {target}, so the published robot crashes"))
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::tests::{actions, check_noisy_trials};
    use crate::trial::{TrialOutcome, run_trial};

    fn maze(text: &str) -> Maze {
        text.parse().unwrap()
    }

    #[test]
    fn joins_cells_and_moves_back_without_a_turn() {
        let maze =
            maze("o---o\n| G |\no   o\n|   |\no   o\n|   |\no   o\n|   |\no   o\n| S |\no---o\n");
        let tour = [4, 0, 4].map(|y| Cell::new(0, y));
        let mut robot = SwingAsPublished::with_tour(&KnownMaze::unexplored(&maze), &tour);
        let actions = actions(&maze, &mut robot);
        let expected = ["(0, 3)", "(0, 1)", "(0, -3)", "(0, -1)", "(0, 3)", "(0, 1)"];
        assert_eq!(actions[..6], expected);
        assert_eq!(actions[6], "(Reset, Reset)");
    }

    #[test]
    fn a_key_point_without_a_path_crashes_the_program() {
        let maze = maze("o---o---o\n|   | G |\no---o   o\n| S     |\no---o---o\n");
        let tour = [Cell::new(1, 1), Cell::new(0, 1)];
        let mut robot = SwingAsPublished::with_tour(&KnownMaze::unexplored(&maze), &tour);
        assert_eq!(robot.failure(), None);
        assert_eq!(run_trial(&maze, &mut robot), TrialOutcome::Failed);
        let expected = "no path to (0, 1), so the published robot crashes";
        assert_eq!(robot.failure().as_deref(), Some(expected));
    }

    #[test]
    fn tours_have_the_key_points_of_the_report() {
        let unexplored = KnownMaze::new(
            mmsim_maze::MazeSize::new(12, 12).unwrap(),
            Cell::new(0, 0),
            mmsim_maze::CellSet::EMPTY,
        );
        let names = |variant, corners: usize| {
            let tour = SwingAsPublished::tour(&unexplored, variant, KeyPoints::ALL[corners]);
            let name = |cell: &Cell| match (cell.x, cell.y) {
                (5, 6) => "C",
                (0, 0) => "S",
                (0, 11) => "TL",
                (11, 11) => "TR",
                (11, 0) => "BR",
                _ => "?",
            };
            tour.iter().map(name).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(names(Variant::JustArrive, 3), "C");
        assert_eq!(names(Variant::ArriveAndBack, 3), "C S BR");
        let all = [0, 1, 2, 3].map(|corners| names(Variant::All, corners));
        let expected = ["C S C", "C TL S C TR C BR C", "C TL BR C S C TR C", "C TL BR C TR C S C"];
        assert_eq!(all, expected);
    }

    #[test]
    fn noisy_sensors_are_harmless() {
        check_noisy_trials(|maze| {
            let unexplored = KnownMaze::unexplored(maze);
            SwingAsPublished::new(&unexplored, Variant::All, KeyPoints::default())
        });
    }
}
