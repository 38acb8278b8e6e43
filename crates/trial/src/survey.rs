//! What a robot knows: the walls it has seen and where it reckons to be.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Pose, WallState};

use crate::Action;

/// What a robot knows of the maze and of itself: the walls that its sensors told it of, and the
/// pose that follows from its moves.
///
/// ```
/// use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, WallState};
/// use mmsim_trial::{Action, Survey};
/// let before = KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), CellSet::EMPTY);
/// let mut survey = Survey::new(before);
/// survey.observe([0, 2, 0]);
/// assert_eq!(survey.map().wall(Cell::new(0, 2), Heading::North), WallState::Present);
/// survey.go(Action::from_numbers(0, 2));
/// assert_eq!(survey.pose().cell, Cell::new(0, 2));
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Survey {
    map: KnownMaze,
    pose: Pose,
}

impl Survey {
    /// At the start heading north, with nothing seen yet but what `before` tells.
    pub const fn new(before: KnownMaze) -> Self {
        let pose = Pose::new(before.start(), Heading::North);
        Self { map: before, pose }
    }

    /// Stands there from now on, for one who is told the pose and need not reckon it.
    pub const fn stand(&mut self, pose: Pose) {
        self.pose = pose;
    }

    /// The walls it knows, and the cells in which it has read its sensors.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Where it reckons to be.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// The goal cells.
    pub const fn goals(&self) -> &CellSet {
        self.map.goals()
    }

    /// Whether it stands in a goal cell.
    pub fn is_in_goal(&self) -> bool {
        self.goals().contains(self.pose.cell)
    }

    /// Notes what the sensors tell here. Says whether that was anything new. A reading that
    /// contradicts an earlier one is believed instead of it; the outer walls stand whatever the
    /// sensors say.
    pub fn observe(&mut self, sensors: [u8; 3]) -> bool {
        let Pose { cell, heading } = self.pose;
        self.map.visit(cell);
        let mut news = false;
        for (heading, open) in [heading.left(), heading, heading.right()].into_iter().zip(sensors) {
            let mut here = cell;
            for _ in 0..open {
                let Some(next) = self.map.size().neighbour(here, heading) else { break };
                news |= self.learn(here, heading, WallState::Absent);
                here = next;
            }
            news |= self.learn(here, heading, WallState::Present);
        }
        news
    }

    /// Takes a wall as this, whatever was known before.
    pub(crate) fn believe(&mut self, cell: Cell, heading: Heading, wall: WallState) {
        self.map.set_wall(cell, heading, wall);
    }

    /// Notes that its sensors were read where it stands.
    pub(crate) fn visit(&mut self) {
        self.map.visit(self.pose.cell);
    }

    fn learn(&mut self, cell: Cell, heading: Heading, wall: WallState) -> bool {
        let is_new = self.map.wall(cell, heading) != wall;
        if is_new {
            self.map.set_wall(cell, heading, wall);
        }
        is_new
    }

    /// Moves as `action` says, until a wall that it knows; a reset takes it back to the start,
    /// heading north.
    pub fn go(&mut self, action: Action) {
        match action {
            Action::Move { rotation, cells } => {
                self.pose.heading = rotation.turn(self.pose.heading);
                let Pose { heading, .. } = self.pose;
                let towards = if cells < 0 { heading.back() } else { heading };
                for _ in 0..cells.clamp(-Action::MAX_CELLS, Action::MAX_CELLS).unsigned_abs() {
                    let ahead = self.map.size().neighbour(self.pose.cell, towards);
                    match ahead
                        .filter(|_| self.map.wall(self.pose.cell, towards) != WallState::Present)
                    {
                        Some(next) => self.pose.cell = next,
                        None => break,
                    }
                }
            }
            Action::Reset => self.pose = Pose::new(self.map.start(), Heading::North),
            Action::GiveUp => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;
    use proptest::prelude::*;

    use super::*;
    use crate::Trial;

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
        fn a_survey_is_never_wrong(moves in prop::collection::vec((-1i64..=1, -3i64..=3), 0..60)) {
            let maze: Maze = MAZE.parse().unwrap();
            let mut trial = Trial::new(&maze);
            let mut survey = Survey::new(KnownMaze::unexplored(&maze));
            for (quarters, cells) in moves {
                survey.observe(trial.readings());
                prop_assert!(!survey.observe(trial.readings()), "nothing new the second time");
                let action = Action::from_numbers(90 * quarters, cells);
                let pose = trial.pose();
                trial.act(action);
                survey.go(action);
                // Nothing is known of walls behind, so only those moves are reckoned for sure.
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
    fn the_last_reading_is_believed() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut survey = Survey::new(KnownMaze::unexplored(&maze));
        survey.observe([1, 9, 1]);
        assert_eq!(survey.map().wall(Cell::new(0, 0), Heading::East), WallState::Absent);
        assert!(survey.observe([0, 2, 0]));
        assert_eq!(survey.map().wall(Cell::new(0, 0), Heading::East), WallState::Present);
        assert_eq!(survey.map().visited().len(), 1);
    }
}
