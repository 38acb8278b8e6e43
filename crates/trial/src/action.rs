//! What a robot answers.

use std::fmt;

/// What a robot does in a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Turns on the spot, then moves straight on.
    Move {
        /// The turn.
        rotation: Rotation,
        /// How many cells to go along the new heading, backwards where negative. The environment
        /// cuts it to 3 cells either way, and at walls.
        cells: i8,
    },
    /// Ends the first run, once the robot has been in the goal; any other reset is a step wasted.
    Reset,
    /// The robot says that the goal cannot be reached. The trial ends without a score. The
    /// published tester has no such answer: there a robot moves on until time is up.
    GiveUp,
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
    /// The most cells that a robot goes in one step.
    pub const MAX_CELLS: i8 = 3;

    /// Neither a turn nor a move.
    pub const STAY: Self = Self::Move { rotation: Rotation::None, cells: 0 };

    /// The move of the published robots' two numbers: a rotation in degrees, where any but -90 and
    /// 90 is none, and a movement in cells.
    ///
    /// ```
    /// use mmsim_trial::{Action, Rotation};
    /// assert_eq!(Action::from_numbers(90, -7), Action::Move { rotation: Rotation::Right, cells: -3 });
    /// assert_eq!(Action::from_numbers(45, 1), Action::Move { rotation: Rotation::None, cells: 1 });
    /// ```
    pub fn from_numbers(rotation: i64, movement: i64) -> Self {
        let rotation = match rotation {
            -90 => Rotation::Left,
            90 => Rotation::Right,
            _ => Rotation::None,
        };
        let most = i64::from(Self::MAX_CELLS);
        let cells = i8::try_from(movement.clamp(-most, most)).unwrap_or(0);
        Self::Move { rotation, cells }
    }
}

impl Rotation {
    /// Its angle, clockwise in degrees.
    pub const fn degrees(self) -> i16 {
        match self {
            Self::Left => -90,
            Self::None => 0,
            Self::Right => 90,
        }
    }

    /// The heading after this turn.
    pub const fn turn(self, heading: mmsim_maze::Heading) -> mmsim_maze::Heading {
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
        }
    }
}
