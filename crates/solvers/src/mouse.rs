//! A mouse: a strategy, a map and a pose.

use mmsim_maze::{
    Cell, Contradiction, Heading, KnownMaze, Pose, Step, Unknown, WallState, WallsAround,
};

use crate::strategy::{Move, Phase, SearchError, Strategy};

/// A mouse in a maze: a strategy, what the mouse knows, and where it is.
///
/// A [`SearchDriver`](crate::SearchDriver) repeats [`see`](Self::see), [`decide`](Self::decide) and
/// [`go`](Self::go). Firmware calls them itself.
#[derive(Clone, Debug)]
pub struct Mouse<S> {
    strategy: S,
    map: KnownMaze,
    pose: Pose,
}

/// A step through a side that is not known to be open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot leave {cell} to the {heading}: {}", describe(*state))]
#[non_exhaustive]
pub struct Crash {
    /// Where the mouse is.
    pub cell: Cell,
    /// The side that it would have gone through.
    pub heading: Heading,
    /// What is known of that side.
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
    /// Creates a mouse that knows `map` and is at `pose`.
    #[must_use]
    pub const fn new(strategy: S, map: KnownMaze, pose: Pose) -> Self {
        Self { strategy, map, pose }
    }

    /// Returns what the mouse knows.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Returns where the mouse is.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns the strategy.
    pub const fn strategy(&self) -> &S {
        &self.strategy
    }

    /// Returns the strategy's number for `cell`, see [`Strategy::weight`].
    pub fn weight(&self, cell: Cell) -> Option<u16> {
        self.strategy.weight(cell)
    }

    /// Returns the phase to which the last decision belongs, see [`Strategy::phase`].
    pub fn phase(&self) -> Phase {
        self.strategy.phase()
    }

    /// Adds the walls around the mouse to its map.
    ///
    /// # Errors
    /// A reading that contradicts an earlier one. The map stays as it was.
    pub fn see(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.pose, around)
    }

    /// Adds the walls that the mouse reads while it faces backwards. This is for the start, where
    /// the side behind the mouse may be unknown. The pose of the mouse stays as it was.
    ///
    /// # Errors
    /// A reading that contradicts an earlier one. The map stays as it was.
    pub fn see_behind(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.turned_round(), around)
    }

    /// Returns the pose of the mouse after a half turn on the spot.
    pub const fn turned_round(&self) -> Pose {
        Pose::new(self.pose.cell, self.pose.heading.back())
    }

    /// Lets the strategy decide what to do here.
    ///
    /// # Errors
    /// The strategy cannot go on.
    pub fn decide(&mut self) -> Result<Move, SearchError> {
        self.strategy.next_move(&self.map, self.pose)
    }

    /// Takes a step.
    ///
    /// # Errors
    /// The side is not known to be open. The mouse stays where it is.
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
