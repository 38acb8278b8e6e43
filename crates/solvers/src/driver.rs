//! The search loop: read the walls, decide, take the step, and count.

use core::convert::Infallible;

use mmsim_maze::{Contradiction, Maze, Pose, Step, WallState, WallsAround};

use crate::mouse::{Crash, Mouse};
use crate::stats::SearchStats;
use crate::strategy::{Move, Phase, SearchError, Strategy};

/// Drives a [`Mouse`] through a maze, one decision at a time, and counts what it does.
///
/// A driver does no input or output. It asks its caller for the walls around a pose, so the same
/// loop serves a maze in memory, a simulator and real sensors:
///
/// ```
/// use mmsim_maze::{KnownMaze, Maze, Pose, WallsAround};
/// use mmsim_solvers::{FloodFill, Mouse, SearchDriver};
///
/// let maze: Maze = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n".parse()?;
/// let read_sensors = |pose: Pose| -> Result<WallsAround, std::io::Error> {
///     Ok(maze.walls().around(pose))
/// };
/// let mut mouse = Mouse::new(FloodFill::new(), KnownMaze::unexplored(&maze), maze.start());
/// let mut driver = SearchDriver::new(&mut mouse, 1000);
/// while driver.advance(read_sensors)? {
///     println!("at {}", driver.mouse().pose());
/// }
/// assert_eq!((driver.stats().steps(), driver.stats().turns()), (4, 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[must_use = "a driver does nothing until it advances"]
pub struct SearchDriver<'m, S> {
    mouse: &'m mut Mouse<S>,
    max_states: u32,
    states: u32,
    /// The last decision, until the mouse has acted on it.
    decision: Option<Move>,
    /// The last decision if it failed. Apart from `decision`, so that each step copies one byte.
    error: Option<SearchError>,
    phase: Phase,
    stats: SearchStats,
}

/// Why a search ended early. `E` is the error of the wall sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError<E> {
    /// The walls could not be read.
    #[error(transparent)]
    Sensor(E),
    /// A reading contradicts an earlier one.
    #[error(transparent)]
    Contradiction(Contradiction),
    /// The strategy cannot go on.
    #[error(transparent)]
    Search(SearchError),
    /// The strategy chose a step through a side that is not known to be open.
    #[error(transparent)]
    Crash(Crash),
}

impl<'m, S: Strategy> SearchDriver<'m, S> {
    /// Creates a driver that ends the search after `max_states` decisions.
    pub fn new(mouse: &'m mut Mouse<S>, max_states: u32) -> Self {
        let (phase, stats) = (Phase::SearchRun, SearchStats::default());
        Self { mouse, max_states, states: 0, decision: None, error: None, phase, stats }
    }

    /// Takes the step decided on last, reads the walls around the mouse, and lets the strategy
    /// decide again. Returns `false` once the search is over.
    ///
    /// Before the first decision the mouse also turns round to read the walls behind it if nothing
    /// is known of the side at its back.
    ///
    /// # Errors
    /// The walls cannot be read or contradict earlier readings, or the mouse would crash. An error
    /// of the strategy is returned by the call after its decision, so that the caller can still
    /// report the state in which it was made.
    #[inline]
    pub fn advance<E>(
        &mut self,
        mut read_walls: impl FnMut(Pose) -> Result<WallsAround, E>,
    ) -> Result<bool, DriveError<E>> {
        if let Some(error) = self.error {
            return Err(DriveError::Search(error));
        }
        let step = match self.decision {
            Some(Move::Stop) => return Ok(false),
            Some(Move::Step(step)) => Some(step),
            None => None,
        };
        if self.states >= self.max_states {
            return Ok(false);
        }
        if let Some(step) = step {
            self.take(step).map_err(DriveError::Crash)?;
        } else if self.states == 0 && self.is_unknown_behind() {
            let around = read_walls(self.mouse.turned_round()).map_err(DriveError::Sensor)?;
            self.mouse.see_behind(around).map_err(DriveError::Contradiction)?;
        }
        let around = read_walls(self.mouse.pose()).map_err(DriveError::Sensor)?;
        self.mouse.see(around).map_err(DriveError::Contradiction)?;
        self.decide();
        Ok(true)
    }

    /// Does the same as [`advance`](Self::advance) in a maze in memory.
    ///
    /// # Errors
    /// The strategy cannot go on or would crash, or the mouse was in another maze before.
    pub fn advance_in(&mut self, maze: &Maze) -> Result<bool, DriveError<Infallible>> {
        self.advance(|pose| Ok(maze.walls().around(pose)))
    }

    /// The mouse.
    pub const fn mouse(&self) -> &Mouse<S> {
        self.mouse
    }

    /// The last decision; `None` before the first one and after a failed reading.
    pub fn decision(&self) -> Option<Result<Move, SearchError>> {
        self.error.map(Err).or(self.decision.map(Ok))
    }

    /// Steps and turns so far.
    pub const fn stats(&self) -> &SearchStats {
        &self.stats
    }

    /// The phase to which the last decision belongs. Once the fast run has begun it never ends.
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    fn is_unknown_behind(&self) -> bool {
        let behind = self.mouse.turned_round();
        self.mouse.map().wall(behind.cell, behind.heading) == WallState::Unknown
    }

    fn take(&mut self, step: Step) -> Result<(), Crash> {
        self.mouse.go(step)?;
        self.decision = None;
        self.stats.count(self.phase, step);
        Ok(())
    }

    fn decide(&mut self) {
        match self.mouse.decide() {
            Ok(decision) => self.decision = Some(decision),
            Err(error) => self.error = Some(error),
        }
        self.states += 1;
        if self.phase != Phase::FastRun {
            self.phase = self.mouse.phase();
        }
        if self.mouse.map().goals().contains(self.mouse.pose().cell) {
            let steps = self.stats.steps();
            self.stats.steps_to_goal.get_or_insert(steps);
        }
    }
}
