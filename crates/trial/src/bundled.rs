//! The robots that come with this crate, by name.

use std::fmt;
use std::str::FromStr;

use mmsim_maze::KnownMaze;

use crate::{Champion, CountExpansion, Habits, KeyPoints, Random, Robot, Rule, Swing, Variant};

/// A robot that comes with this crate.
///
/// ```
/// use mmsim_trial::BundledRobot;
/// let robot: BundledRobot = "random".parse()?;
/// assert_eq!(robot, BundledRobot::Random);
/// # Ok::<(), mmsim_trial::UnknownRobot>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BundledRobot {
    /// [`Random`]
    Random,
    /// [`CountExpansion`]
    CountExpansion,
    /// [`Swing`]
    Swing,
    /// [`Swing::timed`]
    SwingTimed,
    /// [`Champion`] that explores until no faster race is possible.
    Proven,
    /// [`Champion`]
    Champion,
}

/// What a robot is told beside the maze's size, start and goal; each heeds what concerns it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Settings {
    /// Where all that is random in it comes from.
    pub seed: u64,
    /// How many corners are key points.
    pub key_points: KeyPoints,
    /// How far it goes to explore.
    pub variant: Variant,
    /// The chance that a reading of the sensors is wrong by one cell.
    pub noise: f64,
}

/// A name that no robot here has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found {name:?}", names = BundledRobot::ALL.map(BundledRobot::name).join(", "))]
pub struct UnknownRobot {
    /// The name.
    pub name: String,
}

impl BundledRobot {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Random,
        Self::CountExpansion,
        Self::Swing,
        Self::SwingTimed,
        Self::Proven,
        Self::Champion,
    ];

    /// Its name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::CountExpansion => "count-expansion",
            Self::Swing => "swing",
            Self::SwingTimed => "swing-timed",
            Self::Proven => "proven",
            Self::Champion => "champion",
        }
    }

    /// What it does, in a few words.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Random => "any turn, and any move ahead",
            Self::CountExpansion => "flood to the goal, reset, race",
            Self::Swing => "A* to centre and corners, then the shortest way known",
            Self::Proven => "explore until no faster race is possible",
            Self::Champion => "explore as long as that is likely to pay",
            Self::SwingTimed => "the same with plans in time steps, up to 3 cells each",
        }
    }

    /// The robot itself, its trial not begun yet.
    pub fn robot(self, before: KnownMaze, settings: &Settings) -> Box<dyn Robot + Send> {
        let &Settings { seed, key_points, variant, noise } = settings;
        let champion = |rule| Champion::new(before.clone(), rule, Habits::CONTEST, noise, seed);
        match self {
            Self::Random => Box::new(Random::new(before, seed)),
            Self::CountExpansion => Box::new(CountExpansion::new(before)),
            Self::Swing => Box::new(Swing::new(before, variant, key_points)),
            Self::SwingTimed => Box::new(Swing::timed(before, variant, key_points)),
            Self::Proven => Box::new(champion(Rule::Proven)),
            Self::Champion => Box::new(champion(Rule::default())),
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
        let named = Self::ALL.into_iter().find(|robot| robot.name() == name);
        named.ok_or_else(|| UnknownRobot { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for robot in BundledRobot::ALL {
            assert_eq!(robot.to_string().parse(), Ok(robot));
        }
        assert!("Random".parse::<BundledRobot>().is_err());
    }
}
