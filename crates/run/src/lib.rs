//! Judges what a micromouse did in a maze: its movements, its phases, whether it has reached the goal,
//! and the verdict on its run.
//!
//! [`Phases`] follows the poses of a mouse, and decides which movements and which goals count.
//! [`Judge`] adds the walls that the mouse has read, and returns the figures of its search. A
//! [`Verdict`] says how the run ended, and a [`Cause`] why the mouse has not reached the goal. This crate performs no I/O.
//!
//! With the feature `recording`, it also judges states of `mmsim-recording`: [`RunIndex`] returns the
//! phases and the trail at any state, [`StateFigures`] the figures of one state, and [`EventFinder`]
//! the events of a run.
#![forbid(unsafe_code)]

mod cause;
#[cfg(feature = "recording")]
mod events;
mod fastest_run;
mod figures;
mod judge;
#[cfg(feature = "recording")]
mod messages;
mod movement;
mod paths;
mod phase_report;
mod phases;
#[cfg(feature = "recording")]
mod run_index;
#[cfg(feature = "recording")]
mod scene;
mod search;
#[cfg(feature = "recording")]
mod state_figures;
mod times;
mod trail;
mod verdict;

pub use cause::{Cause, END_FACTS, EndFacts, Exit, Messages};
#[cfg(feature = "recording")]
pub use events::{EventFinder, EventKind, EventList, RunEvents};
pub use fastest_run::FastestRun;
pub use figures::{Divergence, SearchFigures, SearchOutcome};
pub use judge::Judge;
#[cfg(feature = "recording")]
pub use messages::messages;
pub use movement::{MovementRules, Transition};
pub use paths::{BoundsHistory, bounds, planned_path, shortest_path};
pub use phase_report::{PhaseLog, PhaseReport, RunReport};
pub use phases::{LegProgress, MotionCount, Phases, RunFigures, RunPhase};
#[cfg(feature = "recording")]
pub use run_index::RunIndex;
pub use search::{Senses, search};
#[cfg(feature = "recording")]
pub use state_figures::{MapFigures, StateEvent, StateFigures, TrialReport, trial_status};
pub use times::{
    DRIVEN_RUN, MouseClock, SearchTimes, fast_run_time, loss, parse_driven_run, plan, return_time,
    tenth_of_ms, time_at_start,
};
pub use trail::Trail;
pub use verdict::{Ending, Goal, Verdict};

/// Compiles and runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
