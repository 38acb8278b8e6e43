//! The search loop, which reads walls, asks the strategy for moves, and counts steps and turns.

use core::convert::Infallible;

use mmsim_maze::{Contradiction, Maze, Pose, Step, WallState, WallsAround};

use crate::mouse::{Crash, Mouse};
use crate::stats::SearchStats;
use crate::strategy::{Move, Phase, SearchError, Strategy};

/// Drives a [`Mouse`] through a maze, one decision at a time, and counts what it does.
///
/// A driver performs no input or output. The caller provides the walls around a pose, so the same
/// loop works with a maze in memory, a simulator or real sensors:
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
    /// The last decision, or `None` once the mouse has acted on it.
    decision: Option<Result<Move, SearchError>>,
    phase: Phase,
    stats: SearchStats,
}

/// An error that ended a search. `E` is the error type of the wall sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError<E> {
    /// The walls could not be read.
    #[error(transparent)]
    Sensor(E),
    /// A sensor reading contradicts an earlier reading.
    #[error(transparent)]
    Contradiction(Contradiction),
    /// The strategy cannot continue.
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
        Self { mouse, max_states, states: 0, decision: None, phase, stats }
    }

    /// Takes the step that the strategy chose, reads the walls around the mouse, and asks the
    /// strategy for the next move. Returns `false` once the search is over.
    ///
    /// Before the first decision, the driver also reads the walls behind the mouse if the wall at
    /// its back is unknown.
    ///
    /// # Errors
    /// Returns an error if the walls cannot be read, if they contradict earlier readings, or if the
    /// mouse would crash. An error of the strategy is returned by the next call of this method, so
    /// that the caller can still report the state in which the error occurred.
    pub fn advance<E>(
        &mut self,
        mut read_walls: impl FnMut(Pose) -> Result<WallsAround, E>,
    ) -> Result<bool, DriveError<E>> {
        let step = match self.decision.transpose().map_err(DriveError::Search)? {
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

    /// Does the same as [`advance`](Self::advance), but reads the walls from a maze in memory.
    ///
    /// # Errors
    /// Returns an error if the strategy cannot continue, if the mouse would crash, or if its map
    /// contradicts the maze.
    pub fn advance_in(&mut self, maze: &Maze) -> Result<bool, DriveError<Infallible>> {
        self.advance(|pose| Ok(maze.walls().around(pose)))
    }

    /// Returns the mouse.
    pub const fn mouse(&self) -> &Mouse<S> {
        self.mouse
    }

    /// Returns the last decision, or `None` before the first decision and after a failed reading.
    pub const fn decision(&self) -> Option<Result<Move, SearchError>> {
        self.decision
    }

    /// Returns the number of steps and turns in each phase.
    pub const fn stats(&self) -> &SearchStats {
        &self.stats
    }

    /// Returns the phase to which the last decision belongs. Once the fast run has begun, the phase
    /// no longer changes.
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
        self.decision = Some(self.mouse.decide());
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
