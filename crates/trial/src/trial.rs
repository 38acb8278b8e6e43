//! The environment: what a step does, when a run ends, what it scores.

use std::fmt;

use mmsim_maze::{Heading, Maze, Pose};

use crate::Action;

/// The two-run trial of one robot in one maze, exactly as the published tester has it.
///
/// In a step the robot is given its [`readings`](Self::readings) and [acts](Self::act). Run 1
/// explores and ends with the reset that follows a visit to the goal; run 2 races and ends with
/// the first step that ends in a goal cell. A goal cell that is crossed within a step does not
/// count.
///
/// ```
/// use mmsim_trial::{Action, Ending, Rotation, Trial};
/// let maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// let mut trial = Trial::new(&maze);
/// assert_eq!(trial.readings(), [0, 1, 1]);
/// let north = Action::Move { rotation: Rotation::None, cells: 1 };
/// let east = Action::Move { rotation: Rotation::Right, cells: 1 };
/// for action in [north, east, Action::Reset, north, east] {
///     assert_eq!(trial.ending(), None);
///     trial.act(action);
/// }
/// let Some(Ending::Scored(score)) = trial.ending() else { panic!("{:?}", trial.ending()) };
/// assert_eq!((score.explore_steps, score.race_steps), (3, 2));
/// assert_eq!(score.to_string(), "2.100");
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Trial<'m> {
    maze: &'m Maze,
    pose: Pose,
    run: Run,
    explore_steps: u32,
    race_steps: u32,
    been_in_goal: bool,
    ending: Option<Ending>,
}

/// One of the two runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Run {
    /// The first, to learn the maze.
    Explore,
    /// The second, to get to the goal.
    Race,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ending {
    /// Both runs were finished.
    Scored(Score),
    /// [`Trial::MAX_STEPS`] steps were not enough.
    OutOfTime,
    /// The robot said that the goal cannot be reached.
    GaveUp,
}

/// The steps of both runs; lower is better.
///
/// Its [`Display`](fmt::Display) is the score with three decimals, as the published tester prints
/// it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Score {
    /// Steps of the first run, that of the reset included.
    pub explore_steps: u32,
    /// Steps of the second run.
    pub race_steps: u32,
}

impl Score {
    /// Steps of the race and a thirtieth of the steps of exploring.
    pub fn value(self) -> f64 {
        f64::from(self.race_steps) + (1. / 30.) * f64::from(self.explore_steps)
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{:.3}", self.value()))
    }
}

impl<'m> Trial<'m> {
    /// The steps that both runs together may take.
    pub const MAX_STEPS: u32 = 1000;

    /// A trial that has not begun yet: the robot stands at the start, heading north.
    pub const fn new(maze: &'m Maze) -> Self {
        Self {
            maze,
            pose: maze.start(),
            run: Run::Explore,
            explore_steps: 0,
            race_steps: 0,
            been_in_goal: false,
            ending: None,
        }
    }

    /// The maze.
    pub const fn maze(&self) -> &'m Maze {
        self.maze
    }

    /// Where the robot stands and where its nose points.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Which run it is; after the end, which one it ended in.
    pub const fn run(&self) -> Run {
        self.run
    }

    /// Steps taken in the first run.
    pub const fn explore_steps(&self) -> u32 {
        self.explore_steps
    }

    /// Steps taken in the second run.
    pub const fn race_steps(&self) -> u32 {
        self.race_steps
    }

    /// How it ended, `None` until it has.
    pub const fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// What the sensors tell: how many open cells lie to the robot's left, in front and to its
    /// right, up to the next wall. Nothing looks back.
    pub fn readings(&self) -> [u8; 3] {
        let Pose { cell, heading } = self.pose;
        [heading.left(), heading, heading.right()].map(|heading| {
            let mut next = Some(cell);
            let mut open = 0;
            while let Some(cell) = next.filter(|&cell| !self.maze.walls().has(cell, heading)) {
                open += 1;
                next = cell.neighbour(heading);
            }
            open
        })
    }

    /// Takes a step. After the end nothing happens any more.
    pub fn act(&mut self, action: Action) -> Option<Ending> {
        if self.ending.is_none() {
            match self.run {
                Run::Explore => self.explore_steps += 1,
                Run::Race => self.race_steps += 1,
            }
            match action {
                Action::Move { rotation, cells } => {
                    self.pose.heading = rotation.turn(self.pose.heading);
                    self.go(cells);
                    self.arrive();
                }
                Action::Reset if self.run == Run::Explore && self.been_in_goal => {
                    self.run = Run::Race;
                    self.pose = self.maze.start();
                }
                Action::Reset => {}
                Action::GiveUp => self.ending = Some(Ending::GaveUp),
            }
            if self.ending.is_none() && self.explore_steps + self.race_steps >= Self::MAX_STEPS {
                self.ending = Some(Ending::OutOfTime);
            }
        }
        self.ending
    }

    /// Goes straight on, backwards where `cells` is negative, until a wall stops it.
    fn go(&mut self, cells: i8) {
        let Pose { cell, heading } = self.pose;
        let towards: Heading = if cells < 0 { heading.back() } else { heading };
        let mut here = cell;
        for _ in 0..cells.clamp(-Action::MAX_CELLS, Action::MAX_CELLS).unsigned_abs() {
            match here.neighbour(towards) {
                Some(next) if !self.maze.walls().has(here, towards) => here = next,
                _ => break,
            }
        }
        self.pose.cell = here;
    }

    fn arrive(&mut self) {
        if self.maze.goals().contains(self.pose.cell) {
            match self.run {
                Run::Explore => self.been_in_goal = true,
                Run::Race => {
                    let Self { explore_steps, race_steps, .. } = *self;
                    self.ending = Some(Ending::Scored(Score { explore_steps, race_steps }));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rotation;

    const MAZE: &str = "\
o---o---o---o---o---o
|             G     |
o   o---o---o---o---o
| S                 |
o---o---o---o---o---o
";

    fn step(degrees: i64, cells: i64) -> Action {
        Action::from_numbers(degrees, cells)
    }

    #[test]
    fn a_step_ends_at_a_wall_and_after_three_cells() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut trial = Trial::new(&maze);
        let mut pose_after = |action| {
            trial.act(action);
            trial.pose().to_string()
        };
        assert_eq!(pose_after(step(0, 3)), "(0, 1) heading north");
        assert_eq!(pose_after(step(0, -9)), "(0, 0) heading north");
        assert_eq!(pose_after(step(90, 120)), "(3, 0) heading east");
        assert_eq!(pose_after(step(180, 2)), "(4, 0) heading east");
        assert_eq!(pose_after(Action::STAY), "(4, 0) heading east");
        assert_eq!(pose_after(step(-90, 1)), "(4, 0) heading north");
        assert_eq!(pose_after(step(90, -3)), "(1, 0) heading east");
        let too_far = Action::Move { rotation: Rotation::None, cells: i8::MAX };
        assert_eq!(pose_after(too_far), "(4, 0) heading east");
        assert_eq!(
            pose_after(Action::Move { rotation: Rotation::None, cells: i8::MIN }),
            "(1, 0) heading east"
        );
        assert_eq!((trial.explore_steps(), trial.readings()), (9, [0, 3, 0]));
    }

    #[test]
    fn crossing_the_goal_does_not_count_and_early_resets_are_wasted() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut trial = Trial::new(&maze);
        trial.act(step(0, 1));
        trial.act(step(90, 2));
        trial.act(step(0, 2));
        assert_eq!(trial.pose().to_string(), "(4, 1) heading east", "across the goal");
        trial.act(Action::Reset);
        assert_eq!((trial.run(), trial.explore_steps()), (Run::Explore, 4));
        trial.act(step(0, -1));
        trial.act(step(0, -1));
        assert_eq!(trial.act(Action::Reset), None);
        assert_eq!((trial.run(), trial.explore_steps()), (Run::Race, 7));
        assert_eq!(trial.pose(), maze.start());
        trial.act(Action::Reset);
        trial.act(step(0, 1));
        trial.act(step(90, 3));
        let score = Score { explore_steps: 7, race_steps: 3 };
        assert_eq!(trial.ending(), Some(Ending::Scored(score)));
        assert_eq!(score.to_string(), "3.233");
        assert_eq!(trial.act(step(0, 1)), Some(Ending::Scored(score)), "nothing happens any more");
    }

    #[test]
    fn a_thousand_steps_are_all() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut trial = Trial::new(&maze);
        for _ in 0..996 {
            assert_eq!(trial.act(Action::STAY), None);
        }
        let mut in_time = trial.clone();
        for action in [step(0, 1), step(90, 3), Action::Reset] {
            assert_eq!(trial.act(action), None);
        }
        assert_eq!(trial.act(step(0, 1)), Some(Ending::OutOfTime));
        in_time.act(Action::GiveUp);
        assert_eq!(in_time.ending(), Some(Ending::GaveUp));
    }
}
