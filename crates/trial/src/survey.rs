//! The map and pose that a robot keeps during a trial.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Pose, Unknown, WallState};

use crate::race::moved;
use crate::robot::Action;
use crate::trial::sensor_headings;

/// A robot's map of the maze, built from sensor readings, and its pose, tracked by dead reckoning.
///
/// ```
/// use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, WallState};
/// use mmsim_trial::{Action, Survey};
/// let map = KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), CellSet::EMPTY);
/// let mut survey = Survey::new(map);
/// survey.observe([0, 2, 0]);
/// assert_eq!(survey.map().wall(Cell::new(0, 2), Heading::North), WallState::Present);
/// survey.apply(Action::from_numbers(0, 2));
/// assert_eq!(survey.pose().cell, Cell::new(0, 2));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Survey {
    map: KnownMaze,
    pose: Pose,
}

impl Survey {
    /// Creates a survey with this map and the pose at the start, heading north.
    pub const fn new(map: KnownMaze) -> Self {
        let pose = map.start();
        Self { map, pose }
    }

    /// Sets the pose, for callers that do not rely on dead reckoning.
    pub const fn set_pose(&mut self, pose: Pose) {
        self.pose = pose;
    }

    /// Returns the known walls and the cells in which the sensors were read.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Returns the estimated pose.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns the goal cells.
    pub const fn goals(&self) -> &CellSet {
        self.map.goals()
    }

    /// Returns true if the estimated position is a goal cell.
    pub fn is_in_goal(&self) -> bool {
        self.goals().contains(self.pose.cell)
    }

    /// Adds sensor readings to the map and returns true if they changed the map. A reading
    /// overrides earlier readings that contradict it. The outer walls never change.
    pub fn observe(&mut self, sensors: [u8; 3]) -> bool {
        let Pose { cell, heading } = self.pose;
        self.map.visit(cell);
        let mut is_changed = false;
        for (heading, open) in sensor_headings(heading).into_iter().zip(sensors) {
            let mut here = cell;
            for _ in 0..open {
                let Some(next) = self.map.size().neighbour(here, heading) else { break };
                is_changed |= self.set_wall(here, heading, WallState::Absent);
                here = next;
            }
            is_changed |= self.set_wall(here, heading, WallState::Present);
        }
        is_changed
    }

    /// Sets the state of a wall and returns true if the state has changed.
    pub(crate) fn set_wall(&mut self, cell: Cell, heading: Heading, wall: WallState) -> bool {
        let is_changed = self.map.wall(cell, heading) != wall;
        self.map.set_wall(cell, heading, wall);
        is_changed
    }

    /// Marks the current cell as visited.
    pub(crate) fn visit(&mut self) {
        self.map.visit(self.pose.cell);
    }

    /// Updates the pose after an action. A move ends at a known wall. A reset sets the pose to the
    /// start, heading north.
    pub fn apply(&mut self, action: Action) {
        match action {
            Action::Move { rotation, cells } => {
                self.pose = moved(self.map.walls(Unknown::Open), self.pose, rotation, cells);
            }
            Action::Reset => self.pose = self.map.start(),
            Action::GiveUp | Action::Fail => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::trial::Trial;

    const MAZE: &str = "\
o---o---o---o---o
|         G |   |
o   o---o   o   o
|   |       |   |
o   o   o---o   o
| S |           |
o---o---o---o---o
";

    proptest! {
        #[test]
        fn a_survey_without_noise_is_correct(moves in prop::collection::vec((-1i64..=1, -3i64..=3), 0..60)) {
            let maze: Maze = MAZE.parse().unwrap();
            let mut trial = Trial::new(&maze);
            let mut survey = Survey::new(KnownMaze::unexplored(&maze));
            for (quarters, cells) in moves {
                survey.observe(trial.readings());
                prop_assert!(!survey.observe(trial.readings()), "the same readings change nothing");
                let action = Action::from_numbers(90 * quarters, cells);
                let pose = trial.pose();
                trial.act(action);
                survey.apply(action);
                // Walls behind the robot may be unknown, so a backward move may end early.
                if cells < 0 && survey.pose() != trial.pose() {
                    survey.pose = trial.pose();
                }
                prop_assert_eq!(survey.pose(), trial.pose(), "from {} by {}", pose, action);
                for cell in maze.size().cells() {
                    for heading in Heading::ALL {
                        let known = survey.map().wall(cell, heading);
                        let present = maze.walls().has(cell, heading);
                        prop_assert!(known == WallState::Unknown || present == (known == WallState::Present));
                    }
                }
            }
        }
    }

    #[test]
    fn the_last_reading_wins() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut survey = Survey::new(KnownMaze::unexplored(&maze));
        survey.observe([1, 9, 1]);
        assert_eq!(survey.map().wall(Cell::new(0, 0), Heading::East), WallState::Absent);
        assert!(survey.observe([0, 2, 0]));
        assert_eq!(survey.map().wall(Cell::new(0, 0), Heading::East), WallState::Present);
        assert_eq!(survey.map().visited().len(), 1);
    }
}
