//! Robots, and the actions that they can take.

use std::fmt;

use mmsim_maze::Heading;

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

/// The action of a robot in one time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// A turn on the spot (or none), followed by a straight move.
    Move {
        /// The turn.
        rotation: Rotation,
        /// The number of cells to move along the new heading; a negative number moves backwards.
        /// The environment limits a move to 3 cells in either direction and ends it early at a
        /// wall.
        cells: i8,
    },
    /// A reset, which ends the first run if the robot has visited the goal. A reset at any other
    /// time only costs a step.
    Reset,
    /// A report that the goal is unreachable, which ends the trial without a score. Robots in the
    /// published tester cannot report this; they keep moving until they run out of steps.
    GiveUp,
    /// The end of a robot whose program has failed, which ends the trial without a score.
    Fail,
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rotation {
    /// -90 degrees.
    Left,
    /// 0 degrees.
    None,
    /// 90 degrees.
    Right,
}

impl Action {
    /// The maximum number of cells in one step.
    pub const MAX_CELLS: i8 = 3;

    /// The action that neither turns nor moves the robot.
    pub const STAY: Self = Self::Move { rotation: Rotation::None, cells: 0 };

    /// Creates a move from the two numbers that a published robot returns: a rotation in degrees
    /// and a movement in cells. All rotations other than -90 and 90 are treated as 0.
    ///
    /// ```
    /// use mmsim_trial::{Action, Rotation};
    /// assert_eq!(Action::from_numbers(90, -7), Action::Move { rotation: Rotation::Right, cells: -3 });
    /// assert_eq!(Action::from_numbers(45, 1), Action::Move { rotation: Rotation::None, cells: 1 });
    /// ```
    pub fn from_numbers(rotation: i64, movement: i64) -> Self {
        let is_turn = |one: &Rotation| i64::from(one.degrees()) == rotation;
        let rotation = Rotation::ALL.into_iter().find(is_turn).unwrap_or(Rotation::None);
        let max = i64::from(Self::MAX_CELLS);
        let cells = i8::try_from(movement.clamp(-max, max)).unwrap_or(0);
        Self::Move { rotation, cells }
    }

    /// Returns the action that moves a robot with heading `from` by `cells` cells towards
    /// `heading`, or `None` for 0 cells. If `heading` is behind the robot, the robot moves
    /// backwards.
    pub(crate) fn towards(from: Heading, heading: Heading, cells: usize) -> Option<Self> {
        let cells = i8::try_from(cells).ok().filter(|&cells| cells > 0)?;
        let is_turn = |rotation: &Rotation| rotation.turn(from) == heading;
        Some(match Rotation::ALL.into_iter().find(is_turn) {
            Some(rotation) => Self::Move { rotation, cells },
            None => Self::Move { rotation: Rotation::None, cells: -cells },
        })
    }
}

impl Rotation {
    /// All turns, in the order of the sensors: left, front and right.
    pub const ALL: [Self; 3] = [Self::Left, Self::None, Self::Right];

    /// Returns the angle of the turn in degrees; clockwise is positive.
    pub const fn degrees(self) -> i16 {
        match self {
            Self::Left => -90,
            Self::None => 0,
            Self::Right => 90,
        }
    }

    /// Returns the heading after this turn.
    pub const fn turn(self, heading: Heading) -> Heading {
        match self {
            Self::Left => heading.left(),
            Self::None => heading,
            Self::Right => heading.right(),
        }
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Move { rotation, cells } => write!(f, "({}, {cells})", rotation.degrees()),
            Self::Reset => f.write_str("(Reset, Reset)"),
            Self::GiveUp => f.write_str("give up"),
            Self::Fail => f.write_str("fail"),
        }
    }
}
