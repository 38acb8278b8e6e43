//! The [`Strategy`] trait, which maps the known walls and a pose to the next move.

use mmsim_maze::{Cell, KnownMaze, Pose, Step, Unknown};

/// A search strategy, which decides the next move based on the known walls and the mouse's pose.
///
/// A strategy uses no socket, clock or thread. The only required method is
/// [`next_move`](Self::next_move).
///
/// ```
/// use mmsim_maze::{KnownMaze, Pose};
/// use mmsim_solvers::{Move, SearchError, Strategy, open_steps};
///
/// /// Goes straight on if it can, else left, right or back.
/// struct Straight;
///
/// impl Strategy for Straight {
///     fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
///         if map.goals().contains(pose.cell) {
///             return Ok(Move::Stop);
///         }
///         let mut steps = open_steps(map, pose);
///         let (step, _) = steps.next().ok_or(SearchError::BoxedIn { cell: pose.cell })?;
///         Ok(Move::Step(step))
///     }
/// }
/// ```
pub trait Strategy {
    /// Decides the next move of a mouse at `pose`. The map already contains the walls around the
    /// mouse.
    ///
    /// This method is called exactly once each time the mouse has read the walls.
    ///
    /// # Errors
    /// Returns an error if the search cannot continue.
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError>;

    /// Forgets what the strategy has concluded from walls that have turned out to be wrong. Such walls
    /// exist only if the mouse [recovers from wrong readings](crate::SearchDriver::recovering). A
    /// strategy that concludes nothing needs no implementation.
    fn reconsider(&mut self) {}

    /// Returns the number that a viewer shows in `cell` after the last
    /// [`next_move`](Self::next_move), for example a distance in steps or a number of visits.
    /// Returns `None` if the viewer should show nothing.
    fn weight(&self, _cell: Cell) -> Option<u16> {
        None
    }

    /// Returns the phase of the last [`next_move`](Self::next_move). By default, the phase is
    /// always the search run, which suits a strategy that stops at the goal.
    fn phase(&self) -> Phase {
        Phase::SearchRun
    }
}

/// Defines the methods of a [`Strategy`] that does the same as another one.
macro_rules! forward_strategy {
    ($self:ident => $other:expr) => {
        fn next_move(&mut $self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
            $other.next_move(map, pose)
        }

        fn reconsider(&mut $self) {
            $other.reconsider();
        }

        fn weight(&$self, cell: Cell) -> Option<u16> {
            $other.weight(cell)
        }

        fn phase(&$self) -> Phase {
            $other.phase()
        }
    };
}
pub(crate) use forward_strategy;

impl<S: Strategy + ?Sized> Strategy for &mut S {
    forward_strategy!(self => **self);
}

#[cfg(feature = "std")]
impl<S: Strategy + ?Sized> Strategy for Box<S> {
    forward_strategy!(self => **self);
}

/// A phase of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Phase {
    /// The mouse finds the goal and explores the maze.
    #[default]
    SearchRun,
    /// The mouse returns to the start.
    ReturnRun,
    /// The mouse runs from the start to the goal through known cells.
    FastRun,
}

/// The next move of a mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Move {
    /// Stop, because the search is over.
    Stop,
    /// Turn, then move one cell.
    Step(Step),
}

/// The reason a strategy cannot continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SearchError {
    /// Known walls block every path from the mouse to the goal.
    #[error("goal unreachable from {cell}")]
    GoalUnreachable {
        /// The cell the mouse is in.
        cell: Cell,
    },
    /// The mouse has walls on all four sides.
    #[error("the mouse is boxed in at {cell}")]
    BoxedIn {
        /// The cell the mouse is in.
        cell: Cell,
    },
    /// An error that is specific to the strategy.
    #[error("search failed at {cell}: {reason}")]
    Failed {
        /// The cell the mouse is in.
        cell: Cell,
        /// The reason for the failure.
        reason: &'static str,
    },
}

/// Returns the steps that a mouse at `pose` can take through sides known to be open, in the order
/// front, left, right, back. Each step is paired with the cell to which it leads.
pub fn open_steps(map: &KnownMaze, pose: Pose) -> impl Iterator<Item = (Step, Cell)> + '_ {
    let possible = map.walls(Unknown::Closed).sides(pose.cell);
    Step::ALL.into_iter().filter_map(move |step| {
        let next = pose.after(step).filter(|next| !possible.has(next.heading))?;
        Some((step, next.cell))
    })
}

/// Returns the step to the neighbour with the smallest number, together with that number. Ignores
/// neighbours behind sides that are not known to be open. Returns `None` if no side is known to be
/// open. `numbers` holds one number for each neighbour, in the order of
/// [`Heading::ALL`](mmsim_maze::Heading::ALL). Ties are broken in the order of [`Step::ALL`].
// The code does not branch on walls or numbers, because such branches would be unpredictable.
pub(crate) fn step_to_least(map: &KnownMaze, pose: Pose, numbers: [u32; 4]) -> Option<(Step, u32)> {
    const CLOSED: u64 = 1 << 63;
    let possible = map.walls(Unknown::Closed).sides(pose.cell);
    let mut least = CLOSED;
    for (index, &step) in (0..).zip(&Step::ALL) {
        let heading = pose.heading.turned(step);
        let closed = u64::from(possible.has(heading)) * CLOSED;
        least = least.min(closed | u64::from(numbers[heading as usize]) << 2 | index);
    }
    let step = Step::ALL[(least & 3) as usize];
    u32::try_from(least >> 2).ok().map(|number| (step, number))
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Heading, MazeSize};

    use super::*;

    /// A strategy that always stops.
    struct Stopping;

    impl Strategy for Stopping {
        fn next_move(&mut self, _: &KnownMaze, _: Pose) -> Result<Move, SearchError> {
            Ok(Move::Stop)
        }
    }

    /// A strategy that implements all methods.
    struct Returning;

    impl Strategy for Returning {
        fn next_move(&mut self, _: &KnownMaze, _: Pose) -> Result<Move, SearchError> {
            Ok(Move::Step(Step::Back))
        }

        fn weight(&self, cell: Cell) -> Option<u16> {
            Some(cell.x.into())
        }

        fn phase(&self) -> Phase {
            Phase::ReturnRun
        }
    }

    #[test]
    fn references_and_boxes_behave_like_their_strategy() {
        let size = MazeSize::CLASSIC;
        let pose = Pose::new(Cell::new(7, 0), Heading::North);
        let map = KnownMaze::new(size, pose.cell, size.central_cells());
        let results = |mut strategy: Box<dyn Strategy>| {
            let mut strategy = &mut strategy;
            let decision = Strategy::next_move(&mut strategy, &map, pose);
            (decision, Strategy::weight(&strategy, pose.cell), Strategy::phase(&strategy))
        };
        assert_eq!(results(Box::new(Stopping)), (Ok(Move::Stop), None, Phase::SearchRun));
        let back = Ok(Move::Step(Step::Back));
        assert_eq!(results(Box::new(Returning)), (back, Some(7), Phase::ReturnRun));
    }
}
