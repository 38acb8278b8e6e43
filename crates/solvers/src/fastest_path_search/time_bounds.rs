//! Bounds on the time of the fastest run in a maze with unknown walls, and how close they must be.

use core::fmt;
use core::str::FromStr;

use mmsim_fastrun::{FastRun, Planner, Point};
use mmsim_maze::{Cell, CellSet, KnownMaze, Unknown, WallState, Walls};

/// Bounds on the time of the fastest run from the start to the goal, in seconds from rest to rest.
///
/// ```
/// use mmsim_fastrun::{Planner, Vehicle};
/// use mmsim_maze::{KnownMaze, Maze};
/// use mmsim_solvers::{TimeBounds, Tolerance};
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let mut map = KnownMaze::unexplored(&maze);
/// let mut planner = Planner::new(Vehicle::expert());
/// let bounds = TimeBounds::new(&map, &mut planner);
/// assert!(bounds.optimistic.is_some() && bounds.pessimistic.is_none());
/// map.observe(maze.start(), maze.walls().around(maze.start()))?;
/// assert!(!TimeBounds::new(&map, &mut planner).are_within(Tolerance::ZERO));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeBounds {
    /// The time of the fastest run with all unknown walls open, or `None` if known walls block every
    /// run.
    pub optimistic: Option<f64>,
    /// The time of the fastest run that crosses no unknown wall, or `None` if no run is known.
    pub pessimistic: Option<f64>,
}

/// The planner rounds the time of each part of a run, so it may find either of two runs whose times
/// differ by this much, in seconds.
const ROUNDING: f64 = 1e-5;

impl TimeBounds {
    /// Computes the bounds for the vehicle of a planner.
    #[must_use]
    pub fn new(map: &KnownMaze, planner: &mut Planner) -> Self {
        let [optimistic, pessimistic] = [Unknown::Open, Unknown::Closed]
            .map(|unknown| PlannedRun::plan(planner, map, map.walls(unknown)).map(|run| run.time));
        Self { optimistic, pessimistic }
    }

    /// Returns true if a run is known, and no run can be so much faster that the known run exceeds
    /// the tolerance.
    pub fn are_within(&self, tolerance: Tolerance) -> bool {
        self.loss().is_some_and(|loss| loss <= tolerance.ratio())
    }

    /// Returns the share of the fastest run's time by which the known run may at most be slower: 0
    /// if it is proven to be fastest. Returns `None` if no run is known.
    pub fn loss(&self) -> Option<f64> {
        let (lower, upper) = (self.optimistic?, self.pessimistic?);
        let difference = upper - lower;
        Some(if difference <= ROUNDING { 0.0 } else { difference / lower })
    }
}

/// The bounds during a search. Plans an optimistic run only if a wall blocks the previous one.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunBounds {
    /// The fastest run with all unknown walls open, or `None` if known walls block every run.
    pub(crate) optimistic: Option<PlannedRun>,
    pessimistic: Option<f64>,
}

impl RunBounds {
    /// Updates the bounds after the mouse has read further walls.
    pub(crate) fn update(&mut self, planner: &mut Planner, map: &KnownMaze) {
        let open = map.walls(Unknown::Open);
        if !self.optimistic.as_ref().is_some_and(|run| run.is_possible(open)) {
            self.optimistic = PlannedRun::plan(planner, map, open);
        }
        let known = PlannedRun::plan(planner, map, map.walls(Unknown::Closed));
        self.pessimistic = known.map(|run| run.time);
    }

    /// Returns the times.
    pub(crate) fn times(&self) -> TimeBounds {
        let optimistic = self.optimistic.as_ref().map(|run| run.time);
        TimeBounds { optimistic, pessimistic: self.pessimistic }
    }
}

/// A run with its time.
#[derive(Clone, Debug)]
pub(crate) struct PlannedRun {
    /// The time from rest to rest, in seconds.
    pub(crate) time: f64,
    points: Vec<Point>,
}

impl PlannedRun {
    /// Plans the fastest run, or returns `None` if there is none.
    pub(crate) fn plan(planner: &mut Planner, map: &KnownMaze, walls: &Walls) -> Option<Self> {
        let run = planner.plan(walls, map.start().cell, map.goals()).ok()?.clone();
        let time = run.time(planner.vehicle()).ok()?;
        Some(Self { time, points: run.points() })
    }

    /// Returns true if none of these walls blocks the run.
    pub(crate) fn is_possible(&self, walls: &Walls) -> bool {
        self.points.iter().all(|point| point.is_free(walls))
    }

    /// Returns the cells on both sides of each unknown wall that the run crosses. A mouse that
    /// enters one of these cells reads the wall.
    pub(crate) fn cells_beside_unknown_walls(&self, map: &KnownMaze) -> CellSet {
        let walls = self.points.iter().filter_map(|point| point.wall());
        let unknown = walls.filter(|&(cell, side)| map.wall(cell, side) == WallState::Unknown);
        unknown.flat_map(|(cell, side)| [Some(cell), cell.neighbour(side)]).flatten().collect()
    }
}

/// Returns the cells of the fastest run through known walls, or `None` if no run is known.
pub(crate) fn fastest_known_route(planner: &mut Planner, map: &KnownMaze) -> Option<Vec<Cell>> {
    let walls = map.walls(Unknown::Closed);
    planner.plan(walls, map.start().cell, map.goals()).ok().map(FastRun::cells)
}

/// The share of the fastest run's time by which the best known run may be slower, from 0 to 1.
///
/// ```
/// use mmsim_solvers::Tolerance;
/// let tolerance: Tolerance = "3%".parse()?;
/// assert_eq!(tolerance, "0.03".parse()?);
/// assert_eq!((tolerance.ratio(), tolerance.to_string()), (0.03, "3%".into()));
/// # Ok::<(), mmsim_solvers::InvalidTolerance>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Tolerance(f64);

/// The error for a tolerance that is not a number from 0 to 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a tolerance from 0 to 100%, such as 3% or 0.03, found {found:?}")]
#[non_exhaustive]
pub struct InvalidTolerance {
    /// The invalid tolerance.
    pub found: String,
}

impl Tolerance {
    /// The tolerance that accepts only the fastest run.
    pub const ZERO: Self = Self(0.0);

    /// Creates a tolerance from a number from 0 to 1.
    ///
    /// # Errors
    /// Returns an error if the number is less than 0, greater than 1 or not a number.
    pub fn new(ratio: f64) -> Result<Self, InvalidTolerance> {
        let is_valid = (0.0..=1.0).contains(&ratio);
        // Minus zero would be displayed with its sign.
        let valid = is_valid.then_some(Self(ratio.abs()));
        valid.ok_or_else(|| InvalidTolerance { found: ratio.to_string() })
    }

    /// Returns the tolerance as a number from 0 to 1.
    pub const fn ratio(self) -> f64 {
        self.0
    }
}

impl FromStr for Tolerance {
    type Err = InvalidTolerance;

    fn from_str(text: &str) -> Result<Self, InvalidTolerance> {
        let ratio = match text.strip_suffix('%') {
            Some(percent) => percent.trim_end().parse().map(|percent: f64| percent / 100.0),
            None => text.parse(),
        };
        let tolerance = ratio.ok().and_then(|ratio| Self::new(ratio).ok());
        tolerance.ok_or_else(|| InvalidTolerance { found: text.into() })
    }
}

/// Writes the tolerance in percent, such as `3%`.
impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Rounded, because 0.07 times 100 is a little more than 7.
        write!(f, "{}%", (self.0 * 1e10).round() / 1e8)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_fastrun::{Vehicle, dijkstra};
    use mmsim_maze::{Heading, MazeSize, Pose};
    use proptest::prelude::*;

    use super::*;
    use crate::tests::random_walls;

    proptest! {
        #[test]
        fn the_bounds_equal_the_naive_ones(
            walls in random_walls(MazeSize::new(8, 8).unwrap(), 0.5),
            seen in prop::collection::vec((0u8..8, 0u8..8), 0..60),
        ) {
            let size = walls.size();
            let start = Cell::new(0, 0);
            let mut map = KnownMaze::new(size, start, size.central_cells());
            let vehicle = Vehicle::ares();
            let (mut planner, mut bounds) =
                (Planner::new(vehicle.clone()), RunBounds::default());
            for (x, y) in seen {
                let pose = Pose::new(Cell::new(x, y), Heading::North);
                map.observe(pose, walls.around(pose)).unwrap();
                bounds.update(&mut planner, &map);
            }
            bounds.update(&mut planner, &map);
            let [open, closed] = [Unknown::Open, Unknown::Closed].map(|unknown| {
                dijkstra(map.walls(unknown), start, map.goals(), &vehicle).map(|(_, time)| time)
            });
            let are_near = |found: Option<f64>, expected: Option<f64>| match (found, expected) {
                (Some(found), Some(expected)) => (found - expected).abs() < ROUNDING,
                _ => found == expected,
            };
            let is_proven = open.is_some() && are_near(closed, open);
            for times in [bounds.times(), TimeBounds::new(&map, &mut planner)] {
                prop_assert!(are_near(times.optimistic, open));
                prop_assert!(are_near(times.pessimistic, closed));
                prop_assert_eq!(times.are_within(Tolerance::ZERO), is_proven);
                prop_assert_eq!(times.loss().is_some(), closed.is_some());
            }
            if let Some(run) = &bounds.optimistic {
                let cells = run.cells_beside_unknown_walls(&map);
                prop_assert!(is_proven || !cells.is_empty());
            }
        }
    }

    #[test]
    fn tolerances_are_percentages_or_ratios() {
        for (text, ratio, shown) in [
            ("0", 0.0, "0%"),
            ("-0", 0.0, "0%"),
            ("7%", 0.07, "7%"),
            ("0.5 %", 0.005, "0.5%"),
            ("0.07", 0.07, "7%"),
            ("1", 1.0, "100%"),
            ("100%", 1.0, "100%"),
        ] {
            let tolerance: Tolerance = text.parse().unwrap();
            assert!((tolerance.ratio() - ratio).abs() < 1e-12, "{text}");
            assert_eq!(tolerance.to_string(), shown);
        }
    }

    #[test]
    fn other_tolerances_are_errors() {
        for text in ["", "%", "3", "-1%", "101%", "NaN", "inf%", "3%%", "three"] {
            let error = text.parse::<Tolerance>().unwrap_err();
            assert_eq!(error, InvalidTolerance { found: text.into() });
        }
        for ratio in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            assert!(Tolerance::new(ratio).is_err(), "{ratio}");
        }
        let error = "3".parse::<Tolerance>().unwrap_err();
        insta::assert_snapshot!(error, @r#"expected a tolerance from 0 to 100%, such as 3% or 0.03, found "3""#);
    }
}
