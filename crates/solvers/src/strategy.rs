//! The [`Strategy`] trait: what is known and a pose go in, a move comes out.

use mmsim_maze::{Cell, KnownMaze, Pose, Step, Unknown};

/// A search strategy. Given what the mouse knows and where it is, it decides what to do next.
///
/// A strategy is pure: it uses no socket, clock or thread. The only method to implement is
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
    /// Decides what to do in this pose. The map already holds the walls around it.
    ///
    /// It is called exactly once for each reading, in the order of the search.
    ///
    /// # Errors
    /// The search cannot go on.
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError>;

    /// Returns a number for a viewer to show in `cell`, as of the last
    /// [`next_move`](Self::next_move): a distance in steps, a count of visits. `None` shows
    /// nothing.
    fn weight(&self, _cell: Cell) -> Option<u16> {
        None
    }

    /// Returns the phase to which the last [`next_move`](Self::next_move) belongs. A strategy that
    /// stops in the goal stays in its search run.
    fn phase(&self) -> Phase {
        Phase::SearchRun
    }
}

impl<S: Strategy + ?Sized> Strategy for &mut S {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        (**self).next_move(map, pose)
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        (**self).weight(cell)
    }

    fn phase(&self) -> Phase {
        (**self).phase()
    }
}

#[cfg(feature = "std")]
impl<S: Strategy + ?Sized> Strategy for Box<S> {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        (**self).next_move(map, pose)
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        (**self).weight(cell)
    }

    fn phase(&self) -> Phase {
        (**self).phase()
    }
}

/// A phase of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Finding the goal, and exploring after that.
    #[default]
    SearchRun,
    /// Going back to the start.
    ReturnRun,
    /// Running from the start to the goal over known cells.
    FastRun,
}

/// What a mouse does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Move {
    /// Stop: the search is over.
    Stop,
    /// Turn, then move one cell.
    Step(Step),
}

/// Why a strategy cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SearchError {
    /// Known walls close every path from the mouse to the goal.
    #[error("goal unreachable from {cell}")]
    GoalUnreachable {
        /// Where the mouse is.
        cell: Cell,
    },
    /// The mouse has walls on all four sides.
    #[error("the mouse is boxed in at {cell}")]
    BoxedIn {
        /// Where the mouse is.
        cell: Cell,
    },
    /// An error of the strategy's own.
    #[error("search failed at {cell}: {reason}")]
    Failed {
        /// Where the mouse is.
        cell: Cell,
        /// What went wrong.
        reason: &'static str,
    },
}

/// Returns the steps that a mouse in `pose` can take through sides known to be open, each with the
/// cell it leads to, in the order front, left, right, back.
pub fn open_steps(map: &KnownMaze, pose: Pose) -> impl Iterator<Item = (Step, Cell)> + '_ {
    let possible = map.walls(Unknown::Closed).sides(pose.cell);
    Step::ALL.into_iter().filter_map(move |step| {
        let next = pose.after(step).filter(|next| !possible.has(next.heading))?;
        Some((step, next.cell))
    })
}

/// Returns the first open step to the neighbour with the least number, and that number; `None` if
/// no step is open. `numbers` are in the order of [`Heading::ALL`](mmsim_maze::Heading::ALL).
// No branches on walls or numbers: they are unpredictable.
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
