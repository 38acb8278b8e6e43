//! The two-run trial, "plot and navigate a virtual maze": a robot explores a maze it has never
//! seen, goes back to the start, and races to the goal.
//!
//! ```text
//!              a step: sensors, then a turn and up to 3 cells
//!   ┌───────┐  [left, front, right]: open cells    ┌───────┐
//!   │       │ ───────────────────────────────────► │       │
//!   │ Trial │                                      │ Robot │      score = steps of the race
//!   │       │ ◄─────────────────────────────────── │       │            + steps of exploring / 30
//!   └───────┘  rotation and movement, or a reset   └───────┘
//! ```
//!
//! [`Trial`] is the environment, exact to the published tester's rules; [`Robot`] is what stands
//! trial in it. Nothing here knows a clock, a socket or a thread, and what is random comes from a
//! seed, so the same trial runs the same way on every machine.
#![forbid(unsafe_code)]

mod action;
mod bundled;
mod champion;
mod count_expansion;
mod noise;
mod race;
mod random;
mod robot;
mod survey;
mod swing;
mod trial;

pub use action::{Action, Rotation};
pub use bundled::{BundledRobot, Settings, UnknownRobot};
pub use champion::{Champion, Habits, Rule};
pub use count_expansion::CountExpansion;
pub use noise::Noise;
pub use race::{RaceSteps, race_optimum};
pub use random::Random;
pub use robot::{Robot, try_robot, try_watched};
pub use survey::Survey;
pub use swing::{KeyPoints, KeyPointsError, Swing, UnknownVariant, Variant};
pub use trial::{Ending, Run, Score, Trial};

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
