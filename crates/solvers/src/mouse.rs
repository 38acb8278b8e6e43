//! A mouse that combines a strategy, a map and a pose.

use mmsim_maze::{
    Cell, Contradiction, Heading, KnownMaze, Pose, Step, Unknown, WallState, WallsAround,
};

use crate::strategy::{Move, Phase, SearchError, Strategy};

/// A mouse in a maze, with its strategy, its map of known walls, and its pose.
///
/// A [`SearchDriver`](crate::SearchDriver) calls [`see`](Self::see), [`decide`](Self::decide) and
/// [`go`](Self::go) in a loop. Firmware calls these methods directly.
#[derive(Clone, Debug)]
pub struct Mouse<S> {
    strategy: S,
    map: KnownMaze,
    pose: Pose,
}

/// An attempted step through a side that is not known to be open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot leave {cell} to the {heading}: {}", describe(*state))]
#[non_exhaustive]
pub struct Crash {
    /// The cell the mouse is in.
    pub cell: Cell,
    /// The side through which the mouse tried to leave the cell.
    pub heading: Heading,
    /// The state of the wall on that side, according to the map.
    pub state: WallState,
}

fn describe(state: WallState) -> &'static str {
    match state {
        WallState::Present => "there is a wall",
        WallState::Absent => "the map ends there",
        WallState::Unknown => "the wall there is unknown",
    }
}

impl<S: Strategy> Mouse<S> {
    /// Creates a mouse at `pose` with the given map of known walls.
    #[must_use]
    pub const fn new(strategy: S, map: KnownMaze, pose: Pose) -> Self {
        Self { strategy, map, pose }
    }

    /// Returns the map of known walls.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Returns the pose of the mouse.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns the strategy.
    pub const fn strategy(&self) -> &S {
        &self.strategy
    }

    /// Returns the weight of `cell` (see [`Strategy::weight`]).
    pub fn weight(&self, cell: Cell) -> Option<u16> {
        self.strategy.weight(cell)
    }

    /// Returns the phase of the last decision (see [`Strategy::phase`]).
    pub fn phase(&self) -> Phase {
        self.strategy.phase()
    }

    /// Adds the walls around the mouse to its map.
    ///
    /// # Errors
    /// Returns an error and leaves the map unchanged if the walls contradict an earlier reading.
    pub fn see(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.pose, around)
    }

    /// Adds to the map the walls that the mouse reads after a half turn. `around` describes the
    /// walls as observed at the pose [`turned_round`](Self::turned_round). The mouse's pose does
    /// not change. This method is needed at the start, where the wall behind the mouse may be
    /// unknown.
    ///
    /// # Errors
    /// Returns an error and leaves the map unchanged if the walls contradict an earlier reading.
    pub fn see_behind(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.turned_round(), around)
    }

    /// Returns the pose that the mouse would have after a half turn on the spot.
    pub const fn turned_round(&self) -> Pose {
        Pose::new(self.pose.cell, self.pose.heading.back())
    }

    /// Asks the strategy for the next move.
    ///
    /// # Errors
    /// Returns an error if the strategy cannot continue.
    pub fn decide(&mut self) -> Result<Move, SearchError> {
        self.strategy.next_move(&self.map, self.pose)
    }

    /// Takes a step.
    ///
    /// # Errors
    /// Returns an error, and does not move the mouse, if the step leads through a side that is not
    /// known to be open.
    #[inline]
    pub fn go(&mut self, step: Step) -> Result<(), Crash> {
        let Pose { cell, heading } = self.pose;
        match self.pose.after(step) {
            Some(next) if !self.map.walls(Unknown::Closed).has(cell, next.heading) => {
                self.pose = next;
                Ok(())
            }
            _ => {
                let heading = heading.turned(step);
                Err(Crash { cell, heading, state: self.map.wall(cell, heading) })
            }
        }
    }
}

impl<S> Mouse<S> {
    /// Returns the map and the strategy, to correct them after wrong readings.
    pub(crate) const fn parts_mut(&mut self) -> (&mut KnownMaze, &mut S) {
        (&mut self.map, &mut self.strategy)
    }

    /// Puts the mouse back into the cell that it has tried to leave through a wall.
    pub(crate) const fn bounce(&mut self, cell: Cell) -> Crash {
        let heading = self.pose.heading;
        self.pose.cell = cell;
        Crash { cell, heading, state: WallState::Present }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;

    use super::*;
    use crate::left_wall::LeftWall;

    #[test]
    fn a_mouse_only_takes_steps_known_to_be_open() {
        let pose = Pose::new(Cell::new(1, 1), Heading::North);
        let map = KnownMaze::new(MazeSize::CLASSIC, pose.cell, MazeSize::CLASSIC.central_cells());
        let mut mouse = Mouse::new(LeftWall::new(), map, pose);
        mouse.see(WallsAround { left: true, front: false, right: false }).unwrap();
        insta::assert_snapshot!(mouse.go(Step::Left).unwrap_err(), @"cannot leave (1, 1) to the west: there is a wall");
        insta::assert_snapshot!(mouse.go(Step::Back).unwrap_err(), @"cannot leave (1, 1) to the south: the wall there is unknown");
        assert_eq!(mouse.pose(), pose);
        mouse.go(Step::Right).unwrap();
        assert_eq!(mouse.pose(), Pose::new(Cell::new(2, 1), Heading::East));
    }
}
