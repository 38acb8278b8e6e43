//! The environment of a trial, which executes the actions of a robot, decides when a run ends, and
//! computes the score; and the noise of sensors.

use std::fmt;

use mmsim_maze::{Heading, Maze, Pose, WyRand};

use crate::race::moved;
use crate::robot::{Action, Robot};

/// The two-run trial of a robot in a maze, according to the rules of the published tester.
///
/// In each step the robot gets its [`readings`](Self::readings) and [acts](Self::act). In the first
/// run, the robot explores the maze. This run ends when the robot resets after it has visited the
/// goal. The second run is the race, which is over when a step ends in a goal cell. Crossing a goal
/// cell in the middle of a step does not count as reaching the goal.
///
/// ```
/// use mmsim_trial::{Action, Rotation, Trial, TrialOutcome};
/// let maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// let mut trial = Trial::new(&maze);
/// assert_eq!(trial.readings(), [0, 1, 1]);
/// let north = Action::Move { rotation: Rotation::None, cells: 1 };
/// let east = Action::Move { rotation: Rotation::Right, cells: 1 };
/// for action in [north, east, Action::Reset, north, east] {
///     assert_eq!(trial.outcome(), None);
///     trial.act(action);
/// }
/// let Some(TrialOutcome::Scored(score)) = trial.outcome() else { panic!("no score") };
/// assert_eq!((score.explore_steps, score.race_steps), (3, 2));
/// assert_eq!(score.to_string(), "2.100");
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Trial<'m> {
    maze: &'m Maze,
    pose: Pose,
    phase: TrialPhase,
    score: Score,
    has_visited_goal: bool,
    outcome: Option<TrialOutcome>,
}

/// One of the two runs of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TrialPhase {
    /// The first run, which explores the maze.
    Explore,
    /// The second run, which races to the goal.
    Race,
}

/// The result of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TrialOutcome {
    /// The robot finished both runs.
    Scored(Score),
    /// The robot reached the limit of [`Trial::MAX_STEPS`] steps.
    OutOfTime,
    /// The robot reported that the goal is unreachable.
    GaveUp,
    /// The robot's program failed.
    Failed,
}

/// The number of steps of each run. A lower score is better.
///
/// [`Display`](fmt::Display) prints the score with three decimal places, like the published tester.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Score {
    /// The number of steps of the first run, including the reset.
    pub explore_steps: u32,
    /// The number of steps of the second run.
    pub race_steps: u32,
}

impl Score {
    /// Returns the number of race steps plus a thirtieth of the number of exploration steps.
    pub fn value(self) -> f64 {
        f64::from(self.race_steps) + (1. / 30.) * f64::from(self.explore_steps)
    }

    /// Returns the value rounded to three decimal places.
    pub fn rounded(self) -> f64 {
        (self.value() * 1000.).round() / 1000.
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{:.3}", self.value()))
    }
}

impl<'m> Trial<'m> {
    /// The maximum number of steps in both runs together.
    pub const MAX_STEPS: u32 = 1000;

    /// Creates a trial with the robot at the start, heading north.
    pub const fn new(maze: &'m Maze) -> Self {
        Self {
            maze,
            pose: maze.start(),
            phase: TrialPhase::Explore,
            score: Score { explore_steps: 0, race_steps: 0 },
            has_visited_goal: false,
            outcome: None,
        }
    }

    /// Returns the maze.
    pub const fn maze(&self) -> &'m Maze {
        self.maze
    }

    /// Returns the true pose of the robot.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns the current run or, after the end of the trial, the last run.
    pub const fn phase(&self) -> TrialPhase {
        self.phase
    }

    /// Returns the number of steps taken in the first run.
    pub const fn explore_steps(&self) -> u32 {
        self.score.explore_steps
    }

    /// Returns the number of steps taken in the second run.
    pub const fn race_steps(&self) -> u32 {
        self.score.race_steps
    }

    /// Returns the outcome, or `None` before the end of the trial.
    pub const fn outcome(&self) -> Option<TrialOutcome> {
        self.outcome
    }

    /// Returns the true sensor readings: the numbers of open cells to the left, in front and to the
    /// right of the robot, up to the next wall. The robot has no sensor at the back.
    pub fn readings(&self) -> [u8; 3] {
        sensor_headings(self.pose.heading).map(|heading| {
            let mut next = Some(self.pose.cell);
            let mut open = 0;
            while let Some(cell) = next.filter(|&cell| !self.maze.walls().has(cell, heading)) {
                open += 1;
                next = cell.neighbour(heading);
            }
            open
        })
    }

    /// Executes an action, which takes one step. Returns the outcome if the trial has ended. Does
    /// nothing after the end of the trial.
    pub fn act(&mut self, action: Action) -> Option<TrialOutcome> {
        if self.outcome.is_none() {
            match self.phase {
                TrialPhase::Explore => self.score.explore_steps += 1,
                TrialPhase::Race => self.score.race_steps += 1,
            }
            match action {
                Action::Move { rotation, cells } => {
                    self.pose = moved(self.maze.walls(), self.pose, rotation, cells);
                    self.arrive();
                }
                Action::Reset if self.phase == TrialPhase::Explore && self.has_visited_goal => {
                    self.phase = TrialPhase::Race;
                    self.pose = self.maze.start();
                }
                Action::Reset => {}
                Action::GiveUp => self.outcome = Some(TrialOutcome::GaveUp),
                Action::Fail => self.outcome = Some(TrialOutcome::Failed),
            }
            if self.outcome.is_none() && self.explore_steps() + self.race_steps() >= Self::MAX_STEPS
            {
                self.outcome = Some(TrialOutcome::OutOfTime);
            }
        }
        self.outcome
    }

    fn arrive(&mut self) {
        if self.maze.goals().contains(self.pose.cell) {
            match self.phase {
                TrialPhase::Explore => self.has_visited_goal = true,
                TrialPhase::Race => self.outcome = Some(TrialOutcome::Scored(self.score)),
            }
        }
    }
}

/// Runs a complete trial of a robot with noise-free sensors.
pub fn run_trial(maze: &Maze, robot: &mut (impl Robot + ?Sized)) -> TrialOutcome {
    run_observed_trial(maze, robot, &mut SensorNoise::none(), |_, _, _| {})
}

/// Runs a complete trial of a robot with the given sensor noise. Before each step, `observe`
/// receives the trial, the robot's sensor readings and its next action.
pub fn run_observed_trial(
    maze: &Maze,
    robot: &mut (impl Robot + ?Sized),
    noise: &mut SensorNoise,
    mut observe: impl FnMut(&Trial<'_>, [u8; 3], Action),
) -> TrialOutcome {
    let mut trial = Trial::new(maze);
    loop {
        let sensors = noise.apply(trial.readings());
        let action = robot.next_move(sensors);
        observe(&trial, sensors, action);
        if let Some(outcome) = trial.act(action) {
            return outcome;
        }
    }
}

/// Sensor noise that makes each reading wrong by one cell with a given probability.
///
/// A wrong reading is equally likely to be too high or too low. If the true value is 0, a wrong
/// reading is always 1. The same seed gives the same errors.
///
/// ```
/// use mmsim_trial::SensorNoise;
/// assert_eq!(SensorNoise::none().apply([0, 3, 7]), [0, 3, 7]);
/// let [left, front, _] = SensorNoise::new(1., 7).apply([0, 3, 7]);
/// assert_eq!((left, front.abs_diff(3)), (1, 1));
/// ```
#[derive(Clone, Debug)]
pub struct SensorNoise {
    probability: f64,
    rng: WyRand,
}

impl SensorNoise {
    /// Creates noise-free sensors.
    pub fn none() -> Self {
        Self::new(0., 0)
    }

    /// Creates sensors whose readings are wrong with the given probability, from 0 to 1.
    pub fn new(probability: f64, seed: u64) -> Self {
        Self { probability, rng: WyRand::new(seed) }
    }

    /// Adds random errors to the readings.
    pub fn apply(&mut self, readings: [u8; 3]) -> [u8; 3] {
        readings.map(|cells| {
            if !self.rng.chance(self.probability) {
                cells
            } else if cells == 0 || self.rng.flip() {
                cells.saturating_add(1)
            } else {
                cells - 1
            }
        })
    }
}

/// Returns the directions of the left, front and right sensors of a robot with this heading.
pub(crate) const fn sensor_headings(heading: Heading) -> [Heading; 3] {
    [heading.left(), heading, heading.right()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Rotation;

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
    fn crossing_the_goal_does_not_count_and_early_resets_waste_a_step() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut trial = Trial::new(&maze);
        trial.act(step(0, 1));
        trial.act(step(90, 2));
        trial.act(step(0, 2));
        assert_eq!(trial.pose().to_string(), "(4, 1) heading east", "crossed the goal");
        trial.act(Action::Reset);
        assert_eq!((trial.phase(), trial.explore_steps()), (TrialPhase::Explore, 4));
        trial.act(step(0, -1));
        trial.act(step(0, -1));
        assert_eq!(trial.act(Action::Reset), None);
        assert_eq!((trial.phase(), trial.explore_steps()), (TrialPhase::Race, 7));
        assert_eq!(trial.pose(), maze.start());
        trial.act(Action::Reset);
        trial.act(step(0, 1));
        trial.act(step(90, 3));
        let score = Score { explore_steps: 7, race_steps: 3 };
        assert_eq!(trial.outcome(), Some(TrialOutcome::Scored(score)));
        assert_eq!(score.to_string(), "3.233");
        assert_eq!(
            trial.act(step(0, 1)),
            Some(TrialOutcome::Scored(score)),
            "no effect after the end"
        );
    }

    #[test]
    fn a_trial_ends_after_1000_steps() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut trial = Trial::new(&maze);
        for _ in 0..996 {
            assert_eq!(trial.act(Action::STAY), None);
        }
        let mut in_time = trial.clone();
        for action in [step(0, 1), step(90, 3), Action::Reset] {
            assert_eq!(trial.act(action), None);
        }
        assert_eq!(trial.act(step(0, 1)), Some(TrialOutcome::OutOfTime));
        in_time.act(Action::GiveUp);
        assert_eq!(in_time.outcome(), Some(TrialOutcome::GaveUp));
    }

    #[test]
    fn errors_have_the_given_rate_and_are_one_cell() {
        let mut noise = SensorNoise::new(0.25, 3);
        let mut wrong = 0;
        for _ in 0..10_000 {
            for (reading, cells) in noise.apply([0, 5, 30]).into_iter().zip([0, 5, 30]) {
                assert!(reading.abs_diff(cells) <= 1);
                wrong += u32::from(reading != cells);
            }
        }
        assert!((7_000..8_000).contains(&wrong), "{wrong} of 30,000");
    }
}
