//! Compares micromice over many mazes: their searches, their times with a vehicle, contests, and the
//! two-run trial.
//!
//! ```text
//! NamedMaze ────┐                        ┌─► SearchComparison   tables, statistics, charts
//!               ├─► Searches::run ─► SearchFigures
//! ComparedMouse ┘                        └─► Contest            attempts, scores, standings
//! ```
//!
//! [`TrialTables`] runs robots in the two-run trial, and compares them in the same way. The field names
//! of rows are JSON keys, which the command and the Python package of mmsim share. All work runs in
//! parallel. This crate prints nothing: progress and interrupts are functions of the caller.
#![forbid(unsafe_code)]

mod baseline;
mod compared_mouse;
mod comparison;
mod contest;
mod exploration;
mod measures;
mod named_maze;
mod parallel;
mod ranking;
mod searches;
mod trial;

pub use baseline::{Baseline, Change, Changes};
pub use compared_mouse::{ComparedMouse, NamedMouse};
pub use comparison::{MazeColumns, MouseSummary, SearchComparison, SearchRow};
pub use contest::{
    Attempt, Contest, ContestEntry, ContestRun, ContestVehicle, MazeResult, RuleSet, Rules,
    RunKind, Standing,
};
pub use exploration::Exploration;
pub use named_maze::NamedMaze;
pub use parallel::{Slot, map_each, map_waiting};
pub use ranking::{Loss, MazeLoss, Ranking, Reason, UnsolvedMaze};
pub use searches::{Searches, measure_times, own_figures};
pub use trial::{
    Means, OwnRobot, RobotKind, RunContext, TableRow, TrialJob, TrialResult, TrialRobot, TrialRow,
    TrialStop, TrialTable, TrialTables, run_trials,
};

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
