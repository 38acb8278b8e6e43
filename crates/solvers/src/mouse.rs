//! A mouse: a strategy, what it knows, and where it stands.

use mmsim_maze::{
    Cell, Contradiction, Heading, KnownMaze, Pose, Step, Unknown, WallState, WallsAround,
};

use crate::strategy::{Move, Phase, SearchError, Strategy};

/// A mouse on its search run: a strategy, what the mouse knows, and where it stands.
///
/// Whoever drives it repeats [`see`](Self::see), [`decide`](Self::decide) and [`go`](Self::go).
#[derive(Clone, Debug)]
pub struct Mouse<S> {
    strategy: S,
    map: KnownMaze,
    pose: Pose,
}

/// A step through a side that is not known to be open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a step through an open side, found the {heading} side of {cell} {}", describe(*state))]
pub struct Crash {
    /// Where the mouse stands.
    pub cell: Cell,
    /// The side it would have gone through.
    pub heading: Heading,
    /// What is known of that side.
    pub state: WallState,
}

fn describe(state: WallState) -> &'static str {
    match state {
        WallState::Present => "closed by a wall",
        WallState::Absent => "at the edge of the map",
        WallState::Unknown => "unknown",
    }
}

impl<S: Strategy> Mouse<S> {
    /// A mouse that knows `map` and stands at `pose`.
    pub const fn new(strategy: S, map: KnownMaze, pose: Pose) -> Self {
        Self { strategy, map, pose }
    }

    /// What it knows.
    pub const fn map(&self) -> &KnownMaze {
        &self.map
    }

    /// Where it stands.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// The strategy's number for `cell`, see [`Strategy::weight`].
    pub fn weight(&self, cell: Cell) -> u16 {
        self.strategy.weight(cell)
    }

    /// The phase to which the last decision belongs, see [`Strategy::phase`].
    pub fn phase(&self) -> Phase {
        self.strategy.phase()
    }

    /// Notes the walls around the mouse.
    ///
    /// # Errors
    /// A reading that contradicts an earlier one; the map is left as it was.
    pub fn see(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.pose, around)
    }

    /// Notes the walls that the mouse senses with its nose turned round: at the start nothing may
    /// be known of the side behind it. The mouse itself heads on as before.
    ///
    /// # Errors
    /// A reading that contradicts an earlier one; the map is left as it was.
    pub fn see_behind(&mut self, around: WallsAround) -> Result<(), Contradiction> {
        self.map.observe(self.turned_round(), around)
    }

    /// Its pose after half a turn on the spot.
    pub const fn turned_round(&self) -> Pose {
        Pose::new(self.pose.cell, self.pose.heading.back())
    }

    /// Lets the strategy decide what to do here.
    ///
    /// # Errors
    /// The strategy says that the search cannot go on.
    pub fn decide(&mut self) -> Result<Move, SearchError> {
        self.strategy.next_move(&self.map, self.pose)
    }

    /// Takes a step.
    ///
    /// # Errors
    /// The side is not known to be open. The mouse stays where it is.
    pub fn go(&mut self, step: Step) -> Result<(), Crash> {
        let Pose { cell, heading } = self.pose;
        let heading = heading.turned(step);
        match self.pose.after(step) {
            Some(pose) if !self.map.walls(Unknown::Closed).has(cell, heading) => {
                self.pose = pose;
                Ok(())
            }
            _ => Err(Crash { cell, heading, state: self.map.wall(cell, heading) }),
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;

    use super::*;
    use crate::LeftWall;

    #[test]
    fn a_mouse_goes_only_where_it_knows_the_way_is_open() {
        let pose = Pose::new(Cell::new(1, 1), Heading::North);
        let map = KnownMaze::new(MazeSize::CLASSIC, pose.cell, MazeSize::CLASSIC.central_cells());
        let mut mouse = Mouse::new(LeftWall::new(), map, pose);
        mouse.see(WallsAround { left: true, front: false, right: false }).unwrap();
        insta::assert_snapshot!(mouse.go(Step::Left).unwrap_err(), @"expected a step through an open side, found the west side of (1, 1) closed by a wall");
        insta::assert_snapshot!(mouse.go(Step::Back).unwrap_err(), @"expected a step through an open side, found the south side of (1, 1) unknown");
        assert_eq!(mouse.pose(), pose);
        mouse.go(Step::Right).unwrap();
        assert_eq!(mouse.pose(), Pose::new(Cell::new(2, 1), Heading::East));
    }
}
