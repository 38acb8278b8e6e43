//! The bundled strategies, which are selected by name.

use std::fmt;
use std::str::FromStr;

use crate::flood_fill::FloodFill;
use crate::left_wall::LeftWall;
use crate::shortest_path_search::ShortestPathSearch;
use crate::strategy::Strategy;
use crate::swing::Swing;
use crate::weight_increment::WeightIncrement;

/// A bundled strategy, selected by name.
///
/// ```
/// use mmsim_solvers::BundledStrategy;
/// let strategy: BundledStrategy = "flood-fill".parse()?;
/// assert_eq!(strategy, BundledStrategy::FloodFill);
/// let new_search = strategy.strategy();
/// # Ok::<(), mmsim_solvers::UnknownStrategy>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BundledStrategy {
    /// [`FloodFill`]
    FloodFill,
    /// [`WeightIncrement`]
    WeightIncrement,
    /// [`LeftWall`]
    LeftWall,
    /// [`Swing`]
    Swing,
    /// [`ShortestPathSearch`]
    ShortestPathSearch,
}

/// The error for an unknown strategy name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {}, found {name:?}", names())]
#[non_exhaustive]
pub struct UnknownStrategy {
    /// The unknown name.
    pub name: String,
}

impl BundledStrategy {
    /// All bundled strategies.
    pub const ALL: &'static [Self] = &[
        Self::FloodFill,
        Self::WeightIncrement,
        Self::LeftWall,
        Self::Swing,
        Self::ShortestPathSearch,
    ];

    /// Returns the name of the strategy as used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FloodFill => "flood-fill",
            Self::WeightIncrement => "weight-increment",
            Self::LeftWall => "left-wall",
            Self::Swing => "swing",
            Self::ShortestPathSearch => "shortest-path-search",
        }
    }

    /// Returns a one-line description of the strategy.
    pub const fn about(self) -> &'static str {
        match self {
            Self::FloodFill => {
                "go to the neighbour nearest to the goal, treating unknown walls as open"
            }
            Self::WeightIncrement => "go to the least visited neighbour",
            Self::LeftWall => "follow the wall on the left",
            Self::Swing => "visit centre and corners, return, and run the shortest known path",
            Self::ShortestPathSearch => {
                "explore until a path is proven to be shortest, return, and run it"
            }
        }
    }

    /// Returns the default limit on the number of states in a search. Each decision creates one
    /// state. In 281 real mazes of up to 32×32 cells, [`Swing`] needs up to 1,531 states per maze,
    /// because the mouse visits distant corners and returns to the start before its fast run.
    pub const fn max_states(self) -> u32 {
        match self {
            Self::FloodFill | Self::WeightIncrement | Self::LeftWall => 1000,
            Self::Swing | Self::ShortestPathSearch => 10_000,
        }
    }

    /// Creates the strategy in its initial state.
    #[must_use]
    pub fn strategy(self) -> Box<dyn Strategy + Send> {
        match self {
            Self::FloodFill => Box::new(FloodFill::new()),
            Self::WeightIncrement => Box::new(WeightIncrement::new()),
            Self::LeftWall => Box::new(LeftWall::new()),
            Self::Swing => Box::new(Swing::new()),
            Self::ShortestPathSearch => Box::new(ShortestPathSearch::new()),
        }
    }
}

fn names() -> String {
    let names: Vec<_> = BundledStrategy::ALL.iter().map(|strategy| strategy.name()).collect();
    names.join(", ")
}

impl fmt::Display for BundledStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for BundledStrategy {
    type Err = UnknownStrategy;

    fn from_str(name: &str) -> Result<Self, UnknownStrategy> {
        let named = Self::ALL.iter().copied().find(|strategy| strategy.name() == name);
        named.ok_or_else(|| UnknownStrategy { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_parse_back() {
        for strategy in BundledStrategy::ALL {
            assert_eq!(strategy.to_string().parse(), Ok(*strategy));
        }
        insta::assert_snapshot!("floodfill".parse::<BundledStrategy>().unwrap_err(), @r#"expected one of flood-fill, weight-increment, left-wall, swing, shortest-path-search, found "floodfill""#);
    }

    #[test]
    fn each_strategy_has_a_description_and_a_limit() {
        let limits = BundledStrategy::ALL.iter().map(|strategy| strategy.max_states());
        assert!(limits.eq([1000, 1000, 1000, 10_000, 10_000]));
        for (index, strategy) in BundledStrategy::ALL.iter().enumerate() {
            assert!((20..80).contains(&strategy.about().len()), "{strategy}");
            let same = |other: &BundledStrategy| other.about() == strategy.about();
            assert_eq!(BundledStrategy::ALL.iter().position(same), Some(index), "{strategy}");
        }
    }
}
