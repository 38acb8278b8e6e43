//! Fast runs of a micromouse, timed in seconds: the fastest run through a known maze, with the
//! proof that no other run of the model is faster.
//!
//! A [`Vehicle`] describes how a mouse drives: the limits on straights, and the speed and length of
//! each slalom turn. [`fastest`] finds the [`FastRun`] that takes the least time. A [`Trajectory`]
//! is a run in time: the pose, speed and acceleration of the mouse at each moment.
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
mod naive;
mod planner;
mod presets;
mod route;
mod run;
mod segment;
mod straight;
mod trajectory;
mod turn;
mod vehicle;
#[cfg(feature = "std")]
mod vehicle_file;
mod warning;

pub use mmsim_maze::{Direction, Point};
pub use naive::dijkstra;
pub use planner::{NoRun, Planner, Planners, fastest};
pub use route::Route;
pub use run::{FastRun, ParseRunError, Turn};
pub use segment::{MotionState, Segment, Shape};
pub use straight::{Piece, StraightLimits};
pub use trajectory::{Trajectory, TrajectoryError};
pub use turn::{Side, TurnKind};
pub use vehicle::{Arc, FittedArc, Vehicle, VehicleError, VehicleParameters};
#[cfg(feature = "std")]
pub use vehicle_file::{LoadVehicleError, VehicleFileError, VehicleFileFault};
pub use warning::{STANDARD_GRAVITY, VehicleWarning};

/// Tests the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
