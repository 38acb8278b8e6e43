//! What a strategy is.

use mmsim_maze::{Cell, KnownMaze, Pose, Step, Unknown};

/// A way to search a maze: shown what the mouse knows and where it stands, it says what to do
/// next.
///
/// It is pure: no socket, clock or thread. To write one, decide in
/// [`next_move`](Self::next_move); [`weight`](Self::weight) is for those who watch.
///
/// ```
/// use mmsim_maze::{Cell, KnownMaze, Pose};
/// use mmsim_solvers::{Move, SearchError, Strategy, steps_from};
///
/// /// Goes straight on as long as it can, else left, else right, else back.
/// struct Straight;
///
/// impl Strategy for Straight {
///     fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
///         if map.goals().contains(pose.cell) {
///             return Ok(Move::Stop);
///         }
///         let mut steps = steps_from(map, pose);
///         let (step, _) = steps.next().ok_or(SearchError::BoxedIn { cell: pose.cell })?;
///         Ok(Move::Step(step))
///     }
///
///     fn weight(&self, _: Cell) -> u16 {
///         0
///     }
/// }
/// ```
pub trait Strategy {
    /// What to do in this pose, once the walls around it are noted in the map.
    ///
    /// It is called once for each reading, in the order of the search.
    ///
    /// # Errors
    /// The search cannot go on.
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError>;

    /// The number that the strategy has for `cell` after the last [`next_move`](Self::next_move),
    /// for a viewer to show: a distance in steps, a count of visits. `u16::MAX` says that there is
    /// none.
    fn weight(&self, cell: Cell) -> u16;

    /// The phase to which the last [`next_move`](Self::next_move) belongs. A strategy that stops in
    /// the goal stays in its search run.
    fn phase(&self) -> Phase {
        Phase::SearchRun
    }
}

impl<S: Strategy + ?Sized> Strategy for &mut S {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        (**self).next_move(map, pose)
    }

    fn weight(&self, cell: Cell) -> u16 {
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

    fn weight(&self, cell: Cell) -> u16 {
        (**self).weight(cell)
    }

    fn phase(&self) -> Phase {
        (**self).phase()
    }
}

/// A phase of a mouse's time in the maze.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Phase {
    /// The search for the goal, and exploration after it.
    #[default]
    SearchRun,
    /// The way back to the start.
    ReturnRun,
    /// The run from the start to the goal over known cells.
    FastRun,
}

/// What a mouse does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Move {
    /// Nothing more: the search run is over.
    Stop,
    /// A turn and one cell.
    Step(Step),
}

/// Why a search cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SearchError {
    /// Known walls close every way from the mouse to the goal.
    #[error("expected a way from {cell} to the goal, found all of them closed by walls")]
    GoalUnreachable {
        /// Where the mouse stands.
        cell: Cell,
    },
    /// There are walls on all four sides of the mouse.
    #[error("expected a way out of {cell}, found walls all round")]
    BoxedIn {
        /// Where the mouse stands.
        cell: Cell,
    },
}

/// The steps that a mouse in `pose` can take through sides known to be open, with the cell each
/// leads to, in the order front, left, right, back.
pub fn steps_from(map: &KnownMaze, pose: Pose) -> impl Iterator<Item = (Step, Cell)> + '_ {
    let possible = map.walls(Unknown::Closed).sides(pose.cell);
    Step::ALL.into_iter().filter_map(move |step| {
        let next = pose.after(step).filter(|next| !possible.has(next.heading))?;
        Some((step, next.cell))
    })
}

/// The first of the possible steps that leads to the neighbour with the least number, and that
/// number; `None` where there is no step. Numbers are in the order of
/// [`Heading::ALL`](mmsim_maze::Heading::ALL).
// Without a branch for a wall or a number, since nobody can predict them.
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
