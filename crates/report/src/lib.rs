//! Comparisons of mice over many mazes: statistics, tables, charts and HTML reports.
//!
//! ```text
//!                     maze 1  maze 2  maze 3
//!   mine                  40      52      61     Each measure has one value per candidate and maze.
//!   flood-fill            46      52       -     A value is missing if the candidate failed.
//!                      └─────┬─────┘
//!                       common mazes             Means, medians and quartiles use these mazes.
//! ```
//!
//! A [`Comparison`] contains the values of one or more [`Measure`]s, for which lower values are
//! better. [`Comparison::statistics`] computes the [`Statistics`] of each candidate, and
//! [`Comparison::charts`] draws the values. [`Comparison::html`] returns a report with all of these as a
//! single file.
//!
//! ```
//! use mmsim_report::{Comparison, Measure};
//!
//! let steps = [[Some(40.0), Some(52.0), Some(61.0)], [Some(46.0), Some(52.0), None]];
//! let comparison = Comparison::new(
//!     "Two mice",
//!     ["mine", "flood-fill"].map(Into::into).into(),
//!     ["first", "second", "third"].map(Into::into).into(),
//! )
//! .with_measure(Measure::new("steps_to_goal", "steps to the goal", "steps"), |candidate, maze| {
//!     steps[candidate][maze]
//! });
//! let statistics = &comparison.statistics()[0];
//! assert_eq!(
//!     statistics.table()[2],
//!     ["flood-fill", "2", "49.00", "49.00", "+3.00", "-35.12 to +41.12"],
//! );
//! ```
//!
//! The crate runs no mice and performs no I/O.
#![forbid(unsafe_code)]

mod charts;
mod comparison;
mod html;
mod statistics;
mod summary;
mod text;

pub use charts::Chart;
pub use comparison::{Comparison, Measure, list_reasons};
pub use html::MousePath;
pub use statistics::{Difference, Distribution, Interval, Statistics, Values};
pub use summary::{CandidateStatistics, MeasureStatistics};

/// Runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
