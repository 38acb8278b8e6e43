//! Judges what a micromouse did in a maze: its movements, its phases, whether it has reached the goal,
//! and the verdict on its run.
//!
//! [`Phases`] follows the poses of a mouse, and decides which movements and which goals count.
//! [`Judge`] adds the walls that the mouse has read, and returns the figures of its search. A
//! [`Verdict`] says how the run ended. This crate performs no I/O.
//!
//! With the feature `recording`, it also judges states of `mmsim-recording`: [`RunIndex`] returns the
//! phases and the trail at any state, [`StateFigures`] the figures of one state, and [`EventFinder`]
//! the events of a run.
#![forbid(unsafe_code)]

mod bounds;
#[cfg(feature = "recording")]
mod events;
mod figures;
mod judge;
#[cfg(feature = "recording")]
mod messages;
mod movement;
mod phase_report;
mod phases;
mod routes;
#[cfg(feature = "recording")]
mod run_index;
#[cfg(feature = "recording")]
mod scene;
mod search;
mod search_speed;
#[cfg(feature = "recording")]
mod state_figures;
mod times;
mod trail;
#[cfg(feature = "recording")]
mod trial_report;
mod verdict;

pub use bounds::{BoundsHistory, bounds};
#[cfg(feature = "recording")]
pub use events::{EventFinder, EventKind, EventList, RunEvents};
pub use figures::{SearchFigures, SearchOutcome};
pub use judge::Judge;
#[cfg(feature = "recording")]
pub use messages::messages;
pub use movement::{MovementRules, Transition};
pub use phase_report::{PhaseReport, RunReport};
pub use phases::{LegProgress, MotionCount, Phases, RunFigures, RunPhase};
pub use routes::{planned_path, shortest_path};
#[cfg(feature = "recording")]
pub use run_index::RunIndex;
pub use search::search;
pub use search_speed::SearchSpeed;
#[cfg(feature = "recording")]
pub use state_figures::{MapFigures, StateEvent, StateFigures};
pub use times::{SearchTimes, Timing, loss, plan, return_time, tenth_of_ms, time_at_start};
pub use trail::Trail;
#[cfg(feature = "recording")]
pub use trial_report::{TrialReport, trial_status};
pub use verdict::{Ending, Goal, Verdict};

/// Compiles and runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
