//! The figures of a mouse in one state, also those of its two-run trial.

use std::borrow::Borrow;

use mmsim_fastrun::{FastRun, Planner};
use mmsim_maze::{Cell, KnownMaze, counted};
use mmsim_recording::{Notes, States, Times};
use mmsim_solvers::PathBounds;
use mmsim_trial::{Score, TrialProgress, TrialStatus};
use serde::Serialize;

use crate::fastest_run::FastestRun;
use crate::movement::Transition;
use crate::paths::bounds;
use crate::phase_report::{PhaseReport, RunReport};
use crate::phases::{Phases, RunFigures, RunPhase};
use crate::run_index::RunIndex;
use crate::times::MouseClock;
use crate::verdict::Goal;

/// The figures of a mouse in one state. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StateFigures {
    /// The steps, turns and times of the phases up to the state.
    pub phases: PhaseReport,
    /// The phase in which the mouse is.
    #[serde(skip)]
    pub phase: RunPhase,
    /// What the known walls prove about the fastest run. `None` in a two-run trial.
    pub fastest_run: Option<FastestRun>,
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
    /// know and that of the walls that it knows. The vehicle of `planner` times the runs. `driven` is
    /// the latest fast run that the mouse has driven with slalom turns, and `cells` returns the cells of
    /// a run. `trial` is given if the state belongs to a two-run trial.
    pub fn new(
        phases: &Phases,
        planner: &mut Planner,
        (driven, cells): (Option<FastRun>, impl Fn(RunFigures) -> Vec<Cell>),
        times: &Times,
        [claimed, known]: [&KnownMaze; 2],
        trial: Option<TrialReport>,
    ) -> Self {
        let fastest_run = trial.is_none().then(|| FastestRun::new(known, planner));
        let clock = MouseClock::new(planner, known.size()).with_driven(driven);
        let clock = Some(clock).filter(|_| trial.is_none());
        let wall_time_s = |first, last| times.seconds(first, last);
        Self {
            phases: PhaseReport::new(phases, clock, cells, wall_time_s),
            fastest_run,
            phase: phases.phase,
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

    /// Returns what the mouse is doing and what its map proves, in words, such as `Goal found after 98
    /// steps. Unknown walls may hide a path of 31 instead of 50 steps.`
    pub fn sentence(&self) -> String {
        if let Some(trial) = &self.trial {
            return format!("Two-run trial: {}.", trial.status);
        }
        let PhaseReport { search_run, fast_run, .. } = &self.phases;
        let MapFigures { optimistic_distance, pessimistic_distance, proven, .. } = self.map;
        let doing = match (self.phase, fast_run) {
            _ if self.error.is_some() => "The mouse has jumped, so no goal counts.".into(),
            (RunPhase::Search, _) => "Searching for the goal.".into(),
            (RunPhase::AtGoal, None) => {
                format!("Goal found after {}.", counted(search_run.steps, "step"))
            }
            (RunPhase::AtGoal, Some(run)) => {
                format!("Fast run completed in {}.", counted(run.steps, "step"))
            }
            (RunPhase::Return, _) if proven => "Returning to the start.".into(),
            (RunPhase::Return, _) => "Exploring on the return run.".into(),
            (RunPhase::AtStart, _) => "At the start, ready for a fast run.".into(),
            (RunPhase::Fast, _) => "On the fast run.".into(),
        };
        let map = match (optimistic_distance, pessimistic_distance) {
            (None, _) => "The known walls leave no path to the goal.".into(),
            (Some(path), Some(_)) if proven => {
                format!("The path of {} is proven to be shortest.", counted(path, "step"))
            }
            (Some(path), Some(known)) => {
                let known = counted(known, "step");
                format!("Unknown walls may hide a path of {path} instead of {known}.")
            }
            (Some(path), None) => {
                format!("The shortest path has at least {}.", counted(path, "step"))
            }
        };
        format!("{doing} {map}")
    }

    /// Returns what the mouse has achieved up to the state, in words, such as `goal after 60 steps, path
    /// proven, fast run 44 steps`.
    pub fn result(&self) -> String {
        if let Some(TrialReport { status, score, .. }) = &self.trial {
            let status = status.replace('_', " ");
            return score.map_or(status, |score| format!("score {score:.3}"));
        }
        if !self.goal_reached || self.error.is_some() {
            return self.goal().to_string();
        }
        let goal = format!("goal after {}", counted(self.phases.search_run.steps, "step"));
        let proven = if self.map.proven { ", path proven" } else { "" };
        let fast_run = |run: RunReport| format!(", fast run {}", counted(run.steps, "step"));
        goal + proven + &self.phases.best_run.map(fast_run).unwrap_or_default()
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

/// The figures of a two-run trial up to a state. The field names are JSON keys. Steps are time
/// steps: the robot reports one state before the first step and one after each step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialReport {
    /// The name of the robot.
    pub mouse: Option<String>,
    /// `run_1`, `run_2`, `scored`, `out_of_time`, `gave_up` or `failed`.
    pub status: &'static str,
    /// The first run.
    pub run_1: RunReport,
    /// The second run, or `None` if it has not begun.
    pub run_2: Option<RunReport>,
    /// The score with three decimals, if the trial has ended with a score.
    pub score: Option<f64>,
}

impl TrialReport {
    /// Returns the figures up to the state `index`, or `None` if its `notes` do not belong to a
    /// trial. `block` returns the block that contains a state.
    pub fn new<B: Borrow<States>>(
        notes: &Notes,
        run: &RunIndex,
        index: usize,
        times: &Times,
        block: impl Fn(usize) -> Option<B>,
    ) -> Option<Self> {
        let status = trial_status(notes)?;
        let status_at = |index: u32| {
            let index = index as usize;
            trial_status(block(index)?.borrow().context(index)?.notes())
        };
        let progress = TrialProgress::at(u32::try_from(index).ok()?, status_at)?;
        let reset = progress.steps.explore_steps as usize;
        let phases = |index| run.phases(index, |index| block(index).ok_or(())).ok();
        let (at_reset, here) = (phases(reset)?, phases(index)?);
        let report = |steps: u32, turns, from, to| RunReport {
            steps: steps.into(),
            turns,
            time_s: None,
            wall_time_s: times.seconds(from, to),
        };
        let has_raced = status == TrialStatus::Race || progress.steps.race_steps > 0;
        let turns = at_reset.total.turns - if has_raced { reset_turns(&at_reset) } else { 0 };
        let run_2 = has_raced.then(|| {
            let turns = here.total.turns - at_reset.total.turns;
            report(progress.steps.race_steps, turns, reset, index)
        });
        Some(Self {
            mouse: notes.mouse().map(String::from),
            status: status.key(),
            run_1: report(progress.steps.explore_steps, turns, 0, reset),
            run_2,
            score: progress.score().map(Score::rounded),
        })
    }
}

/// Returns the status of a trial, or `None` if the notes do not belong to a trial.
pub fn trial_status(notes: &Notes) -> Option<TrialStatus> {
    TrialStatus::from_strategy(notes.strategy()?)
}

/// Returns the quarter turns of a reset in the start cell, which are not turns of the robot. `phases`
/// are those of the first state of the second run.
pub(crate) fn reset_turns(phases: &Phases) -> u64 {
    match phases.transition {
        Some(Transition::Move { turns, .. }) => turns.into(),
        _ => 0,
    }
}
