//! The bundled strategies, which are selected by name.

use std::fmt;
use std::str::FromStr;

use mmsim_fastrun::Planner;

use crate::fastest_path_search::{FastestPathSearch, Tolerance};
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
    /// [`FastestPathSearch`]
    FastestPathSearch,
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
        Self::FastestPathSearch,
    ];

    /// Returns the name of the strategy as used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FloodFill => "flood-fill",
            Self::WeightIncrement => "weight-increment",
            Self::LeftWall => "left-wall",
            Self::Swing => "swing",
            Self::ShortestPathSearch => "shortest-path-search",
            Self::FastestPathSearch => "fastest-path-search",
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
            Self::FastestPathSearch => {
                "explore until a run is proven to be fastest in seconds, return, and run it"
            }
        }
    }

    /// Returns the default limit on the number of states in a search. Each decision creates one
    /// state. In 281 real mazes of up to 32×32 cells, [`Swing`] needs up to 1,531 states per maze,
    /// because the mouse visits distant corners and returns to the start before its fast run.
    pub const fn max_states(self) -> u32 {
        match self {
            Self::FloodFill | Self::WeightIncrement | Self::LeftWall => 1000,
            Self::Swing | Self::ShortestPathSearch | Self::FastestPathSearch => 10_000,
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
            Self::FastestPathSearch => Box::new(FastestPathSearch::default()),
        }
    }

    /// Creates the strategy in its initial state, for the vehicle of a planner and a tolerance (see
    /// [`FastestPathSearch::with_planner`]). Strategies that count steps ignore both.
    ///
    /// ```
    /// use mmsim_fastrun::{Planner, Vehicle};
    /// use mmsim_solvers::BundledStrategy;
    /// let planner = Planner::new(Vehicle::ares());
    /// let search = BundledStrategy::FastestPathSearch.strategy_for(&planner, "3%".parse()?);
    /// # Ok::<(), mmsim_solvers::InvalidTolerance>(())
    /// ```
    #[must_use]
    pub fn strategy_for(self, planner: &Planner, tolerance: Tolerance) -> Box<dyn Strategy + Send> {
        if self.uses_vehicle() {
            Box::new(FastestPathSearch::with_planner(planner.clone(), tolerance))
        } else {
            self.strategy()
        }
    }

    /// Returns true if the strategy depends on the vehicle and the tolerance.
    pub const fn uses_vehicle(self) -> bool {
        matches!(self, Self::FastestPathSearch)
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
    use std::fmt::Write;

    use mmsim_maze::{Cell, CellSet, KnownMaze, Maze, MazeSize, Walls, WyRand};

    use super::*;
    use crate::{Distances, Mouse, SearchDriver};

    /// Returns pseudorandom mazes with many loops. The goal of each maze is reachable.
    fn mazes() -> impl Iterator<Item = Maze> {
        let sizes = [(5, 5), (8, 8), (12, 9), (16, 16), (20, 7)];
        let mut rng = WyRand::new(1);
        let mut row = move || rng.next_u32() & (rng.next_u32() | rng.next_u32());
        sizes.into_iter().flat_map(|size| [size; 2]).map(move |(width, height)| {
            let size = MazeSize::new(width, height).unwrap();
            let mut maze = || {
                let (north, east) = ([0; 32].map(|_| row()), [0; 32].map(|_| row()));
                Maze::new(Walls::from_rows(size, north, east), Cell::new(0, 0), CellSet::EMPTY)
            };
            let is_reachable = |maze: &Maze| {
                Distances::flood(maze.walls(), maze.goals()).at(maze.start().cell).is_some()
            };
            std::iter::repeat_with(|| maze().unwrap()).find(is_reachable).unwrap()
        })
    }

    #[test]
    fn names_parse_back() {
        for strategy in BundledStrategy::ALL {
            assert_eq!(strategy.to_string().parse(), Ok(*strategy));
        }
        insta::assert_snapshot!("floodfill".parse::<BundledStrategy>().unwrap_err(), @r#"expected one of flood-fill, weight-increment, left-wall, swing, shortest-path-search, fastest-path-search, found "floodfill""#);
    }

    #[test]
    fn each_strategy_has_a_description_and_a_limit() {
        let limits = BundledStrategy::ALL.iter().map(|strategy| strategy.max_states());
        assert!(limits.eq([1000, 1000, 1000, 10_000, 10_000, 10_000]));
        for (index, strategy) in BundledStrategy::ALL.iter().enumerate() {
            assert!((20..80).contains(&strategy.about().len()), "{strategy}");
            let same = |other: &BundledStrategy| other.about() == strategy.about();
            assert_eq!(BundledStrategy::ALL.iter().position(same), Some(index), "{strategy}");
        }
    }

    #[test]
    fn strategies_search_generated_mazes() {
        let mut table = String::new();
        for maze in mazes() {
            let shortest = Distances::flood(maze.walls(), maze.goals()).at(maze.start().cell);
            write!(table, "{} {:2}", maze.size(), shortest.unwrap()).unwrap();
            for strategy in BundledStrategy::ALL {
                let map = KnownMaze::unexplored(&maze);
                let mut mouse = Mouse::new(strategy.strategy(), map, maze.start());
                let mut driver = SearchDriver::new(&mut mouse, 300);
                let mut weights = 0_u64;
                while driver.advance_in(&maze) == Ok(true) {
                    let weights_of_state =
                        maze.size().cells().filter_map(|cell| driver.mouse().weight(cell));
                    weights += weights_of_state.map(u64::from).sum::<u64>();
                }
                let stats = driver.stats();
                let phases = [stats.search_run, stats.return_run, stats.fast_run];
                let [search, back, fast] = phases.map(|phase| phase.steps);
                if *strategy == BundledStrategy::ShortestPathSearch {
                    assert_eq!(Some(fast), shortest.map(u32::from));
                }
                write!(table, " | {search:3} {back:3} {fast:2} {weights:6}").unwrap();
            }
            table.push('\n');
        }
        insta::assert_snapshot!(table);
    }
}
