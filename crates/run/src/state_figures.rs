//! The figures of a mouse in one state.

use mmsim_maze::KnownMaze;
use mmsim_recording::Times;
use mmsim_solvers::PathBounds;
use serde::Serialize;

use crate::bounds::bounds;
use crate::movement::Transition;
use crate::phase_report::PhaseReport;
use crate::phases::Phases;
use crate::trial_report::TrialReport;
use crate::verdict::Goal;

/// The figures of a mouse in one state. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StateFigures {
    /// The steps, turns and times of the phases up to the state.
    pub phases: PhaseReport,
    /// True if the mouse has reached the goal. See [`Phases`].
    pub goal_reached: bool,
    /// The first jump, in words, or `None` if the mouse has not jumped.
    pub error: Option<String>,
    /// The figures of a two-run trial, whose distances are in time steps.
    pub trial: Option<TrialReport>,
    /// How the mouse was placed in this state, or `None` if it has moved.
    pub event: Option<StateEvent>,
    /// The figures that depend only on the map.
    #[serde(flatten)]
    pub map: MapFigures,
}

/// The figures of a state that depend on the map of the mouse. The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MapFigures {
    /// The number of cells that the mouse claims to have visited.
    pub visited_cells: usize,
    /// The distance from the start to the goal if all unknown walls are open, or `None` if there is no
    /// path. In steps or, in a trial, in time steps.
    pub optimistic_distance: Option<u16>,
    /// The same distance if all unknown walls are closed.
    pub pessimistic_distance: Option<u16>,
    /// True if the shortest known path is proven to be shortest.
    pub proven: bool,
}

/// A change of the pose that is not a movement. See [`Transition`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StateEvent {
    /// The mouse was put back at the start.
    Restart,
    /// The mouse appeared in another cell.
    Jump,
}

impl StateFigures {
    /// Computes the figures from the phases up to a state, and from the map that the mouse claims to
    /// know and that of the walls that it knows. `trial` is given if the state belongs to a two-run
    /// trial.
    pub fn new(
        phases: &Phases,
        times: &Times,
        [claimed, known]: [&KnownMaze; 2],
        trial: Option<TrialReport>,
    ) -> Self {
        Self {
            phases: PhaseReport::new(phases, |first, last| times.milliseconds(first, last)),
            goal_reached: phases.is_goal_reached(),
            error: phases.jump_error(),
            event: match phases.transition {
                Some(Transition::Restart) => Some(StateEvent::Restart),
                Some(Transition::Jump) => Some(StateEvent::Jump),
                Some(Transition::Move { .. }) | None => None,
            },
            map: MapFigures::new(claimed.visited().len(), known, trial.is_some()),
            trial,
        }
    }

    /// Returns the goal in words. See [`Goal`].
    pub fn goal(&self) -> Goal<'_> {
        Goal { is_reached: self.goal_reached, error: self.error.as_deref() }
    }
}

impl MapFigures {
    pub(crate) fn new(visited_cells: usize, known: &KnownMaze, is_trial: bool) -> Self {
        let bounds = bounds(known, is_trial);
        let PathBounds { optimistic, pessimistic } = bounds;
        Self {
            visited_cells,
            optimistic_distance: optimistic,
            pessimistic_distance: pessimistic,
            proven: bounds.is_proven(),
        }
    }
}
