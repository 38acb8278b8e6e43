//! The strategies that come with this crate, by name.

use std::fmt;
use std::str::FromStr;

use crate::flood_fill::FloodFill;
use crate::left_wall::LeftWall;
use crate::shortest_path_search::ShortestPathSearch;
use crate::strategy::Strategy;
use crate::swing::Swing;
use crate::weight_increment::WeightIncrement;

/// A strategy that comes with this crate.
///
/// ```
/// use mmsim_solvers::BundledStrategy;
/// let strategy: BundledStrategy = "flood-fill".parse()?;
/// assert_eq!(strategy, BundledStrategy::FloodFill);
/// let ready_to_search = strategy.strategy();
/// # Ok::<(), mmsim_solvers::UnknownStrategy>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

/// A name that no strategy here has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected one of {names}, found {name:?}", names = BundledStrategy::ALL.map(BundledStrategy::name).join(", "))]
pub struct UnknownStrategy {
    /// The name.
    pub name: String,
}

impl BundledStrategy {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::FloodFill,
        Self::WeightIncrement,
        Self::LeftWall,
        Self::Swing,
        Self::ShortestPathSearch,
    ];

    /// Its name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FloodFill => "flood-fill",
            Self::WeightIncrement => "weight-increment",
            Self::LeftWall => "left-wall",
            Self::Swing => "swing",
            Self::ShortestPathSearch => "shortest-path-search",
        }
    }

    /// What it does, in a few words.
    pub const fn about(self) -> &'static str {
        match self {
            Self::FloodFill => {
                "go to the neighbour nearest to the goal, unknown walls taken as open"
            }
            Self::WeightIncrement => "go to the neighbour visited least",
            Self::LeftWall => "keep the left hand on the wall",
            Self::Swing => "go to centre and corners and back, then run the shortest way known",
            Self::ShortestPathSearch => {
                "explore until a shortest way is proven, return, and run it"
            }
        }
    }

    /// After how many states its search is given up unless somebody says otherwise. A swing visits
    /// far corners and comes back before it runs fast: that took at most 1,531 states in 281
    /// real mazes of up to 32×32 cells.
    pub const fn max_states(self) -> u32 {
        match self {
            Self::FloodFill | Self::WeightIncrement | Self::LeftWall => 1000,
            Self::Swing | Self::ShortestPathSearch => 10_000,
        }
    }

    /// The strategy itself, its search not begun yet.
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

impl fmt::Display for BundledStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for BundledStrategy {
    type Err = UnknownStrategy;

    fn from_str(name: &str) -> Result<Self, UnknownStrategy> {
        let named = Self::ALL.into_iter().find(|strategy| strategy.name() == name);
        named.ok_or_else(|| UnknownStrategy { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for strategy in BundledStrategy::ALL {
            assert_eq!(strategy.to_string().parse(), Ok(strategy));
        }
        insta::assert_snapshot!("floodfill".parse::<BundledStrategy>().unwrap_err(), @r#"expected one of flood-fill, weight-increment, left-wall, swing, shortest-path-search, found "floodfill""#);
    }
}
