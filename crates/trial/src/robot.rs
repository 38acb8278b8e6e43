//! The [`Robot`] trait, and functions that run a trial.

use mmsim_maze::Maze;

use crate::action::Action;
use crate::noise::SensorNoise;
use crate::trial::{Trial, TrialOutcome};

/// A robot, which chooses an action for each set of sensor readings.
///
/// Before the trial, a robot knows the size, the start and the goal cells of the maze
/// ([`KnownMaze::unexplored`](mmsim_maze::KnownMaze::unexplored)). During the trial, the robot
/// tracks its own position by dead reckoning.
///
/// The robots in this crate are deterministic: they use no clock, threads or sockets, and all
/// randomness comes from a seed.
///
/// ```
/// use mmsim_trial::{Action, Robot, Rotation, TrialOutcome, run_trial};
///
/// /// Moves straight, resets, and moves straight again.
/// struct Straight(u32);
///
/// impl Robot for Straight {
///     fn next_move(&mut self, _: [u8; 3]) -> Action {
///         self.0 += 1;
///         let ahead = Action::Move { rotation: Rotation::None, cells: 1 };
///         if self.0 == 2 { Action::Reset } else { ahead }
///     }
/// }
///
/// let maze = "o---o\n| G |\no   o\n| S |\no---o\n".parse()?;
/// let TrialOutcome::Scored(score) = run_trial(&maze, &mut Straight(0)) else { panic!("no score") };
/// assert_eq!(score.to_string(), "1.067");
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub trait Robot {
    /// Returns the next action. `sensors` holds the numbers of open cells to the left, in front and
    /// to the right of the robot, up to the next wall.
    fn next_move(&mut self, sensors: [u8; 3]) -> Action;

    /// Returns the reason why the robot has [failed](Action::Fail), or `None` if it has not.
    fn failure(&self) -> Option<String> {
        None
    }
}

impl<R: Robot + ?Sized> Robot for Box<R> {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        (**self).next_move(sensors)
    }

    fn failure(&self) -> Option<String> {
        (**self).failure()
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
