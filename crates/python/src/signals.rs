//! Checks for signals, so that Ctrl-C interrupts long calls.

use std::time::Duration;

use pyo3::prelude::*;

/// The time between two checks.
pub(crate) const INTERVAL: Duration = Duration::from_millis(50);

/// Runs Python's signal handlers, and returns their exception.
// The method itself is not general enough for `attach`.
#[allow(clippy::redundant_closure_for_method_calls)]
pub(crate) fn check() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}
