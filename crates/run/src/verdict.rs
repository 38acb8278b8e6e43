//! The verdict on a mouse: whether it has reached the goal, and how its run ended.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::cause::Cause;
use crate::phases::Phases;

/// The verdict on a mouse. The field names are JSON keys.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze, Pose};
/// use mmsim_run::{Ending, MovementRules, Phases, Verdict};
/// let maze: Maze = "o---o---o\n| S | G |\no---o---o\n".parse()?;
/// let (rules, mut phases) = (MovementRules::from_maze(&maze), Phases::default());
/// for pose in [maze.start(), Pose::new(Cell::new(1, 0), Heading::East)] {
///     phases.add(&rules, pose, false);
/// }
/// let verdict = Verdict::new(&phases, Ending::Finished, None, None);
/// assert_eq!((verdict.goal_reached, verdict.ending), (false, Ending::Failed));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// True if the mouse has reached the goal. See [`Phases`].
    pub goal_reached: bool,
    /// How the run ended.
    pub ending: Ending,
    /// The reason why the mouse did not stop by itself after it had reached the goal.
    pub error: Option<String>,
    /// The cause that the mouse has not reached the goal, if it is known. `error` states it.
    pub cause: Option<Cause>,
}

/// How the run of a mouse ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// The mouse stopped by itself after it had reached the goal.
    #[default]
    Finished,
    /// The mouse stopped by itself without having reached the goal.
    GaveUp,
    /// The mouse jumped, its process ended with an error, could not be started or wrote no commands.
    Failed,
    /// The user or another client stopped the mouse.
    Stopped,
    /// The mouse reached the time limit.
    TimeLimit,
    /// The mouse reached the limit of states.
    StepLimit,
    /// The mouse did not run, because it had reached the time limit too often.
    Skipped,
}

impl Ending {
    /// All endings.
    pub const ALL: [Self; 7] = [
        Self::Finished,
        Self::GaveUp,
        Self::Failed,
        Self::Stopped,
        Self::TimeLimit,
        Self::StepLimit,
        Self::Skipped,
    ];
}

impl Verdict {
    /// Returns the verdict on a mouse that did this. A mouse that jumped has failed, however its run
    /// ended. See [`from_goal`](Self::from_goal).
    pub fn new(
        phases: &Phases,
        ending: Ending,
        error: Option<String>,
        cause: Option<Cause>,
    ) -> Self {
        let goal_reached = phases.is_goal_reached();
        match phases.jump_error() {
            Some(jump) => {
                Self { goal_reached, ending: Ending::Failed, error: Some(jump), cause: None }
            }
            None => Self::from_goal(goal_reached, ending, error, cause),
        }
    }

    /// Returns the verdict on a mouse that has not jumped. `ending` is [`Finished`](Ending::Finished) if
    /// the mouse stopped by itself. If it then has not reached the goal, it gave up, whatever `error`
    /// says. The cause of a failure follows the error.
    pub fn from_goal(
        goal_reached: bool,
        ending: Ending,
        error: Option<String>,
        cause: Option<Cause>,
    ) -> Self {
        let (ending, error) = match ending {
            Ending::Finished if goal_reached => (ending, None),
            Ending::Finished => (Ending::GaveUp, Some("exited without reaching the goal".into())),
            ending => (ending, error),
        };
        let cause = cause.filter(|_| !goal_reached);
        let error = match cause {
            Some(cause) => Some(cause.explain(error)),
            None => error,
        };
        Self { goal_reached, ending, error, cause }
    }

    /// Returns the goal in words, with the reason if the mouse has not finished.
    pub fn goal(&self) -> Goal<'_> {
        Goal { is_reached: self.goal_reached, error: self.error.as_deref() }
    }
}

/// Whether a mouse has reached the goal, in words, such as `goal reached` or `goal not reached: jumped
/// from (0, 1) to (0, 2), which no movement can reach`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Goal<'a> {
    /// True if the mouse has reached the goal.
    pub is_reached: bool,
    /// The reason why the mouse has not finished.
    pub error: Option<&'a str>,
}

impl fmt::Display for Goal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.is_reached { "goal reached" } else { "goal not reached" })?;
        self.error.map_or(Ok(()), |error| write!(f, ": {error}"))
    }
}
