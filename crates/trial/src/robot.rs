//! What a robot is, and a trial of one.

use mmsim_maze::Maze;

use crate::{Action, Ending, Noise, Trial};

/// A robot: given what its sensors tell, it says what to do.
///
/// It is told once, when it is made, what every robot knows before the trial
/// ([`KnownMaze::unexplored`](mmsim_maze::KnownMaze::unexplored)): size, start and goal cells. Where it is
/// after its moves it has to reckon itself.
///
/// It is pure: no clock, thread or socket; what is random in it comes from a seed.
///
/// ```
/// use mmsim_trial::{Action, Ending, Robot, Rotation, try_robot};
///
/// /// Goes straight on, resets, and goes straight on.
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
/// let Ending::Scored(score) = try_robot(&maze, &mut Straight(0)) else { panic!("no score") };
/// assert_eq!(score.to_string(), "1.067");
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
pub trait Robot {
    /// What to do, once the sensors have told how many open cells lie to the left, in front and to
    /// the right, up to the next wall.
    fn next_move(&mut self, sensors: [u8; 3]) -> Action;
}

impl<R: Robot + ?Sized> Robot for Box<R> {
    fn next_move(&mut self, sensors: [u8; 3]) -> Action {
        (**self).next_move(sensors)
    }
}

/// Puts a robot on trial, from the first step to the end.
pub fn try_robot(maze: &Maze, robot: &mut (impl Robot + ?Sized)) -> Ending {
    try_watched(maze, robot, &mut Noise::none(), |_, _, _| {})
}

/// The same with sensors that err, and with somebody who watches: before each step, `watch` is
/// shown the trial, what the sensors told the robot, and what it answered.
pub fn try_watched(
    maze: &Maze,
    robot: &mut (impl Robot + ?Sized),
    noise: &mut Noise,
    mut watch: impl FnMut(&Trial<'_>, [u8; 3], Action),
) -> Ending {
    let mut trial = Trial::new(maze);
    loop {
        let sensors = noise.blur(trial.readings());
        let action = robot.next_move(sensors);
        watch(&trial, sensors, action);
        if let Some(ending) = trial.act(action) {
            return ending;
        }
    }
}
