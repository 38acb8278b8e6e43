//! Fast runs of a micromouse, timed in seconds: the fastest run through a known maze, with the
//! proof that no other run of the model is faster.
//!
//! A [`Vehicle`] describes how a mouse drives: the limits on straights, and the speed and length of
//! each slalom turn. [`fastest`] finds the [`FastRun`] that takes the least time. A [`Trajectory`]
//! tells where the mouse is at each moment of a run.
//!
//! ```
//! use mmsim_fastrun::{Vehicle, fastest};
//! use mmsim_maze::Maze;
//!
//! let maze: Maze = "\
//! o---o---o---o
//! |         G |
//! o   o---o---o
//! | S |       |
//! o---o---o---o
//! ".parse()?;
//! let vehicle = Vehicle::expert();
//! let run = fastest(maze.walls(), maze.start().cell, maze.goals(), &vehicle)?;
//! assert_eq!(run.to_string(), "N 0 l90R@1400 2");
//! assert!((run.time(&vehicle)? - 0.455).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![cfg_attr(not(any(test, feature = "std")), no_std)]
#![forbid(unsafe_code)]

extern crate alloc;

mod arc;
mod lattice;
mod line;
mod naive;
mod no_run;
mod planner;
mod presets;
mod route;
mod run;
#[cfg(feature = "std")]
mod setting;
mod trajectory;
mod turn;
mod vehicle;
#[cfg(feature = "std")]
mod vehicle_file;
mod warning;

pub use lattice::{Direction, Point};
pub use line::{Line, Piece};
pub use naive::dijkstra;
pub use no_run::NoRun;
pub use planner::{Planner, fastest};
pub use route::Route;
pub use run::{FastRun, ParseRunError, Turn};
pub use trajectory::{DriveError, Moment, Segment, Shape, Trajectory};
pub use turn::{Side, TurnKind};
pub use vehicle::{Arc, FittedArc, Vehicle, VehicleError, VehicleParameters};
#[cfg(feature = "std")]
pub use vehicle_file::{VehicleFileError, VehicleFileFault};
pub use warning::{STANDARD_GRAVITY, VehicleWarning};

/// Tests the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
