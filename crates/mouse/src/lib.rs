//! Runs a program as a micromouse.
//!
//! ```text
//!   stdin, stdout and stderr ┌─────────┐ commands of mms          ┌───────────────┐
//!   ◄──────────────────────► │ Session │ ───────────────────────► │               │
//!                            └─────────┘                          │ the simulator │
//!   requests over ZeroMQ     ┌─────────┐ requests, kept to a pace │               │
//!   ◄──────────────────────► │ Gateway │ ───────────────────────► │               │
//!                            └─────────┘                          └───────────────┘
//! ```
//!
//! A [`Program`] is the command line of a mouse, and a [`MouseProcess`] the running program. A
//! mouse written for mms runs in a [`Session`], a client of a simulator behind a [`Gateway`], and a
//! robot of the two-run trial is a [`RobotProcess`]. [`search()`] runs a mouse of either kind alone in a
//! maze, and a `Judge` sees what it does. [`MouseControl`] starts, stops and pauses the [`Runs`] of a
//! mouse, and keeps the mouse to a [`Pace`]. The crate parses no arguments, and reports messages for
//! the user through functions of the caller.
#![forbid(unsafe_code)]

mod claim;
mod commands;
mod control;
mod endpoint;
mod gateway;
#[cfg(unix)]
mod guard;
mod kind;
mod log;
mod pipes;
mod process;
mod program;
mod published;
mod report;
mod robot;
mod runs;
mod search;
mod session;
mod simulator;
mod throttle;

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

pub use control::{Hold, MouseControl, MouseStatus, Outcome, StartReason, StopReason};
pub use gateway::{Gateway, GatewayRun, Progress};
#[cfg(unix)]
pub use guard::{ONE_ARENA, guard_mice, use_guard};
pub use kind::MouseKind;
pub use pipes::PipedMouse;
pub use process::{ExitCause, MouseProcess, RunEnd, Shortage, StartError, exit_failure, exit_text};
pub use program::Program;
pub use published::PythonError;
pub use report::{ClientExit, JudgedRun, MouseReport};
pub use robot::{RobotProcess, StopCheck};
pub use runs::Runs;
pub use search::{MAX_INVALID_BYTES, SearchEnd, SearchLimits, SearchReport, search};
pub use session::{MouseExit, Session};
pub use simulator::wall_declarations;
pub use throttle::Pace;

/// The environment variable with the address to which a mouse connects.
pub const ENDPOINT_VARIABLE: &str = "MMSIM_ENDPOINT";

/// The placeholder for this address in the arguments of a mouse.
pub const ENDPOINT_PLACEHOLDER: &str = "{endpoint}";

/// Locks a mutex, also after another thread has panicked.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits while a condition holds, but at most for the given time.
fn wait_while<'s, T>(
    changed: &Condvar,
    state: MutexGuard<'s, T>,
    timeout: Duration,
    condition: impl FnMut(&mut T) -> bool,
) -> MutexGuard<'s, T> {
    let waited = changed.wait_timeout_while(state, timeout, condition);
    waited.unwrap_or_else(PoisonError::into_inner).0
}

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
