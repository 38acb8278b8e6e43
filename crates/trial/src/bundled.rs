//! The names and descriptions of the robots in this crate.

use std::fmt;
use std::str::FromStr;

use mmsim_maze::KnownMaze;

use crate::champion::{Champion, StoppingRule, WallPrior};
use crate::count_expansion::CountExpansion;
use crate::random_walk::RandomWalk;
use crate::robot::Robot;
use crate::swing::{KeyPoints, SwingRobot, Variant};
use crate::swing_as_published::SwingAsPublished;

/// One of the robots in this crate.
///
/// ```
/// use mmsim_trial::BundledRobot;
/// let robot: BundledRobot = "random".parse()?;
/// assert_eq!(robot, BundledRobot::Random);
/// # Ok::<(), mmsim_trial::UnknownRobot>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BundledRobot {
    /// [`RandomWalk`]
    Random,
    /// [`CountExpansion`]
    CountExpansion,
    /// [`SwingRobot`]
    Swing,
    /// [`SwingAsPublished`]
    SwingAsPublished,
    /// [`SwingRobot::timed`]
    SwingTimed,
    /// [`Champion`] with [`StoppingRule::Proven`].
    Proven,
    /// [`Champion`] with the default [`StoppingRule`].
    Champion,
}

/// The settings of bundled robots. Each robot ignores the settings that do not apply to it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Settings {
    /// The random seed.
    pub seed: u64,
    /// The number of maze corners that [`SwingRobot`] visits.
    pub key_points: KeyPoints,
    /// The cells that [`SwingRobot`] visits before its race.
    pub variant: Variant,
    /// The probability, from 0 to 1, that a sensor reading is wrong by one cell.
    pub noise: f64,
}

/// The error for a name that is not a [`BundledRobot`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found {name:?}", names = BundledRobot::names().join(", "))]
#[non_exhaustive]
pub struct UnknownRobot {
    /// The unknown name.
    pub name: String,
}

impl BundledRobot {
    /// All bundled robots.
    pub const ALL: &'static [Self] = &[
        Self::Random,
        Self::CountExpansion,
        Self::Swing,
        Self::SwingAsPublished,
        Self::SwingTimed,
        Self::Proven,
        Self::Champion,
    ];

    /// Returns the robot's name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::CountExpansion => "count-expansion",
            Self::Swing => "swing",
            Self::SwingAsPublished => "swing-as-published",
            Self::SwingTimed => "swing-timed",
            Self::Proven => "proven",
            Self::Champion => "champion",
        }
    }

    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|robot| robot.name()).collect()
    }

    /// Returns a short description of the robot.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Random => "random moves in open directions",
            Self::CountExpansion => "flood to find the goal, reset, then race",
            Self::SwingAsPublished => "the published swing program, reproduced step by step",
            Self::Swing => "A* to the centre and the corners, then the shortest known path",
            Self::SwingTimed => "like swing, but plan in time steps of up to 3 cells",
            Self::Proven => "explore until no faster race is possible",
            Self::Champion => "explore as long as it is likely to pay off",
        }
    }

    /// Returns true if the settings `key_points` and `variant` apply to the robot.
    pub const fn has_key_points(self) -> bool {
        matches!(self, Self::Swing | Self::SwingAsPublished | Self::SwingTimed)
    }

    /// Creates the robot at the start of its first run.
    pub fn robot(self, unexplored: KnownMaze, settings: &Settings) -> Box<dyn Robot + Send> {
        let &Settings { seed, key_points, variant, noise } = settings;
        let champion =
            |rule| Champion::new(unexplored.clone(), rule, WallPrior::CONTEST, noise, seed);
        match self {
            Self::Random => Box::new(RandomWalk::new(unexplored, seed)),
            Self::CountExpansion => Box::new(CountExpansion::new(unexplored)),
            Self::Swing => Box::new(SwingRobot::new(unexplored, variant, key_points)),
            Self::SwingAsPublished => {
                Box::new(SwingAsPublished::new(&unexplored, variant, key_points))
            }
            Self::SwingTimed => Box::new(SwingRobot::timed(unexplored, variant, key_points)),
            Self::Proven => Box::new(champion(StoppingRule::Proven)),
            Self::Champion => Box::new(champion(StoppingRule::default())),
        }
    }
}

impl fmt::Display for BundledRobot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for BundledRobot {
    type Err = UnknownRobot;

    fn from_str(name: &str) -> Result<Self, UnknownRobot> {
        let named = Self::ALL.iter().copied().find(|robot| robot.name() == name);
        named.ok_or_else(|| UnknownRobot { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for &robot in BundledRobot::ALL {
            assert_eq!(robot.to_string().parse(), Ok(robot));
        }
        assert!("Random".parse::<BundledRobot>().is_err());
    }
}
