//! The native part of the Python package `micromouse-sim`.
//!
//! Python sources, type stubs and the documentation of all classes are in
//! `python/micromouse_sim`. Functions that Python can call raise exceptions and never panic. They
//! take no lock while they run Python code, so threads cannot block each other.
#![allow(
    missing_docs,
    clippy::needless_pass_by_value,
    reason = "the signatures follow PyO3, and Python shows the documentation in `_native.pyi`"
)]

mod connection;
mod error;
mod geometry;
mod grid;
mod maze;
mod simulator;

/// The native module.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::connection::Connection;
    #[pymodule_export]
    use crate::maze::{PyMaze, bundled_mazes};
    #[pymodule_export]
    use crate::simulator::Simulator;
}
