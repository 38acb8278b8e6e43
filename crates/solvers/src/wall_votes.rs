//! What a mouse with unreliable sensors knows about each wall.

use mmsim_maze::{
    Cell, CellMap, Contradiction, Heading, KnownMaze, Pose, Unknown, Wall, WallState, WallsAround,
};

use crate::flood::{Distances, only};

/// How strongly the readings of each wall support it. A [`SearchDriver`](crate::SearchDriver) with
/// votes [recovers](crate::SearchDriver::recovering) from wrong readings.
///
/// Each reading is a vote for or against a wall, and the majority decides. A wall that has blocked
/// the mouse, and an opening that the mouse has driven through, are certain.
#[derive(Clone, Debug)]
pub struct WallVotes {
    /// The votes of the walls to the north and east of each cell: positive for a wall.
    votes: CellMap<[i8; 2]>,
}

/// The votes of a wall that has blocked the mouse.
const TOUCHED: i8 = i8::MAX;

/// The votes of an opening that the mouse has driven through.
const PASSED: i8 = i8::MIN;

/// The votes of a wall that the mouse tries to drive through, whatever it reads.
const DOUBTED: i8 = i8::MIN + 1;

/// The maximum number of votes that readings give.
const MAX_VOTES: i8 = 100;

/// A mouse reads a wall again until one side leads by this number of votes.
const LEAD: i8 = 2;

/// The effect of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reading {
    /// True if no wall needs a further reading.
    pub(crate) is_clear: bool,
    /// True if a wall that was known has changed.
    pub(crate) has_changed: bool,
}

impl WallVotes {
    /// Creates the votes of a mouse that has read nothing.
    pub const fn new() -> Self {
        Self { votes: CellMap::new([0; 2]) }
    }

    fn votes_mut(&mut self, Wall { cell, heading, .. }: Wall) -> &mut i8 {
        &mut self.votes[cell][usize::from(heading == Heading::East)]
    }

    /// Counts the votes of a reading, and records on the map what the majority says.
    ///
    /// # Errors
    /// Returns an error if an outer wall is missing.
    pub(crate) fn read(
        &mut self,
        map: &mut KnownMaze,
        pose: Pose,
        around: WallsAround,
    ) -> Result<Reading, Contradiction> {
        let Pose { cell, heading } = pose;
        let mut reading = Reading { is_clear: true, has_changed: false };
        let mut vote = |side, is_present| {
            let wall = Wall::new(cell, side);
            if map.size().wall_index(wall).is_none() {
                return is_present;
            }
            let before = map.wall(cell, side);
            let votes = self.votes_mut(wall);
            if (-MAX_VOTES..=MAX_VOTES).contains(votes) {
                let more = *votes + if is_present { 1 } else { -1 };
                *votes = more.clamp(-MAX_VOTES, MAX_VOTES);
                reading.is_clear &= votes.abs() >= LEAD;
            }
            let majority = match *votes {
                0 => before,
                votes if votes > 0 => WallState::Present,
                _ => WallState::Absent,
            };
            reading.has_changed |= before != majority && before != WallState::Unknown;
            map.set_wall(cell, side, majority);
            majority == WallState::Present
        };
        let around = WallsAround {
            left: vote(heading.left(), around.left),
            front: vote(heading, around.front),
            right: vote(heading.right(), around.right),
        };
        map.observe(pose, around).map(|()| reading)
    }

    /// Notes that the mouse has driven through an opening.
    pub(crate) fn pass(&mut self, cell: Cell, heading: Heading) {
        *self.votes_mut(Wall::new(cell, heading)) = PASSED;
    }

    /// Notes that a wall has blocked the mouse.
    pub(crate) fn touch(&mut self, cell: Cell, heading: Heading) {
        *self.votes_mut(Wall::new(cell, heading)) = TOUCHED;
    }

    /// Opens the walls with the fewest votes that separate the cells around the mouse from other
    /// cells. Returns false if all these walls are certain.
    pub(crate) fn doubt_barrier(&mut self, map: &mut KnownMaze, cell: Cell) -> bool {
        let reached = Distances::flood(map.walls(Unknown::Open), &only(cell));
        let size = map.size();
        let is_barrier =
            |wall: &Wall| wall.cells().filter(|&cell| reached.at(cell).is_some()).count() == 1;
        let barrier = || size.inner_walls().filter(is_barrier);
        let fewest = barrier().map(|wall| *self.votes_mut(wall)).min();
        let Some(fewest) = fewest.filter(|&votes| votes < TOUCHED) else { return false };
        for wall in barrier() {
            let votes = self.votes_mut(wall);
            if *votes == fewest {
                *votes = DOUBTED;
                map.set_wall(wall.cell, wall.heading, WallState::Absent);
            }
        }
        true
    }
}

impl Default for WallVotes {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use core::convert::Infallible;

    use mmsim_maze::{MazeSize, Misreadings, WallSensor};
    use proptest::prelude::*;

    use super::*;
    use crate::bundled::BundledStrategy;
    use crate::driver::{DriveError, SearchDriver};
    use crate::flood::steps_between;
    use crate::mouse::Mouse;
    use crate::strategy::{Phase, SearchError};
    use crate::tests::random_mazes;

    const OPEN: WallsAround = WallsAround { left: false, front: false, right: false };
    const AHEAD: WallsAround = WallsAround { front: true, ..OPEN };

    fn map() -> (KnownMaze, Pose) {
        let (size, cell) = (MazeSize::new(3, 3).unwrap(), Cell::new(1, 1));
        (KnownMaze::new(size, cell, size.central_cells()), Pose::new(cell, Heading::North))
    }

    #[test]
    fn the_majority_of_the_readings_counts() {
        let ((mut map, pose), mut votes) = (map(), WallVotes::new());
        let mut read = |around| {
            let Reading { is_clear, has_changed } = votes.read(&mut map, pose, around).unwrap();
            (map.wall(pose.cell, Heading::North), is_clear, has_changed)
        };
        let (present, absent) = (WallState::Present, WallState::Absent);
        assert_eq!(read(AHEAD), (present, false, false));
        assert_eq!(read(OPEN), (present, false, false), "a tie");
        assert_eq!(read(OPEN), (absent, false, true));
        assert_eq!(read(OPEN), (absent, true, false));
        assert_eq!(read(AHEAD), (absent, false, false));
    }

    #[test]
    fn touched_walls_and_passed_openings_are_certain() {
        let ((mut map, pose), mut votes) = (map(), WallVotes::new());
        for (around, state) in [(OPEN, WallState::Absent), (AHEAD, WallState::Present)] {
            votes.read(&mut map, pose, around).unwrap();
            map.set_wall(pose.cell, Heading::North, state);
            match state {
                WallState::Absent => votes.pass(pose.cell, Heading::North),
                _ => votes.touch(pose.cell, Heading::North),
            }
            for reading in [OPEN, AHEAD].iter().cycle().take(500) {
                votes.read(&mut map, pose, *reading).unwrap();
                assert_eq!(map.wall(pose.cell, Heading::North), state);
            }
        }
    }

    #[test]
    fn a_missing_outer_wall_is_a_contradiction() {
        let ((mut map, _), mut votes) = (map(), WallVotes::new());
        let corner = Pose::new(Cell::new(0, 0), Heading::North);
        let error = votes.read(&mut map, corner, OPEN).unwrap_err();
        assert_eq!((error.cell, error.heading), (corner.cell, Heading::West));
    }

    #[test]
    fn the_walls_with_the_fewest_votes_are_doubted_first() {
        let ((mut map, pose), mut votes) = (map(), WallVotes::new());
        let closed = WallsAround { left: true, front: true, right: true };
        votes.read(&mut map, pose, closed).unwrap();
        votes.read(&mut map, Pose::new(pose.cell, Heading::South), closed).unwrap();
        votes.touch(pose.cell, Heading::South);
        let state = |map: &KnownMaze| Heading::ALL.map(|side| map.wall(pose.cell, side));
        let (present, absent) = (WallState::Present, WallState::Absent);
        assert!(votes.doubt_barrier(&mut map, pose.cell));
        assert_eq!(
            state(&map),
            [absent, present, present, present],
            "east and west have two votes"
        );
        votes.read(&mut map, pose, closed).unwrap();
        assert_eq!(state(&map)[0], absent, "the mouse drives there whatever it reads");
        map.set_wall(pose.cell, Heading::North, present);
        votes.touch(pose.cell, Heading::North);
        assert!(votes.doubt_barrier(&mut map, pose.cell));
        assert_eq!(state(&map), [present, absent, present, absent]);
        for side in [Heading::East, Heading::West] {
            map.set_wall(pose.cell, side, present);
            votes.touch(pose.cell, side);
        }
        assert!(!votes.doubt_barrier(&mut map, pose.cell));
    }

    proptest! {
        #[test]
        fn a_mouse_that_recovers_reaches_each_reachable_goal(
            maze in random_mazes(10),
            (seed, are_fixed) in (any::<u64>(), any::<bool>()),
            strategy in prop::sample::select(&[
                BundledStrategy::FloodFill,
                BundledStrategy::Swing,
                BundledStrategy::ShortestPathSearch,
                BundledStrategy::FastestPathSearch,
            ][..]),
        ) {
            let misreadings = Misreadings { probability: 0.05, seed, are_fixed };
            let (mut sensor, mut at) = (WallSensor::new(misreadings, &maze), maze.start().cell);
            let (map, mut votes) = (KnownMaze::unexplored(&maze), WallVotes::new());
            let mut mouse = Mouse::new(strategy.strategy(), map, maze.start());
            let mut driver = SearchDriver::new(&mut mouse, 100_000).recovering(Some(&mut votes));
            let error = loop {
                let read =
                    |pose| Ok::<_, Infallible>(sensor.around_from(maze.walls(), &mut at, pose));
                match driver.advance_unless_blocked(read) {
                    Ok(true) => {
                        let cell = driver.mouse().pose().cell;
                        prop_assert!(at == cell, "the mouse knows its cell");
                    }
                    Ok(false) => break None,
                    Err(error) => break Some(error),
                }
            };
            let shortest = steps_between(maze.walls(), maze.start().cell, maze.goals());
            prop_assert_eq!(driver.stats().goal_reached(), shortest.is_some());
            match error {
                None => prop_assert!(shortest.is_some()),
                Some(DriveError::Search(SearchError::GoalUnreachable { .. } | SearchError::BoxedIn { .. })) => {
                    prop_assert!(shortest.is_none());
                }
                // The path may have changed on the way back to the start.
                Some(DriveError::Crash(_)) => {
                    prop_assert_eq!(driver.phase(), Phase::FastRun);
                    prop_assert!(shortest.is_some());
                }
                Some(error) => prop_assert!(false, "{error}"),
            }
        }
    }
}
