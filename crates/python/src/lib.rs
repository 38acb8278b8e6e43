//! The native part of the Python package `micromouse-sim`.
//!
//! The Python sources and the type stubs are in `python/micromouse_sim`. A test compares the
//! documentation in the stubs with that of the classes here. Functions that Python can call raise exceptions and never panic. They
//! take no lock while they run Python code, so threads cannot block each other.
#![allow(
    missing_docs,
    clippy::doc_markdown,
    clippy::needless_pass_by_value,
    reason = "the signatures follow PyO3, and the documentation is that of `_native.pyi`"
)]

mod animation;
mod annotation;
mod client;
mod compare;
mod connection;
mod convert;
mod error;
mod fast_run;
mod grid;
mod history;
mod known;
mod maze;
mod search;
mod search_env;
mod signals;
mod simulator;
mod socket;
mod strategy;

/// The native module.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::{
        client::PyClient,
        compare::{compare, load_folder, trial},
        connection::PyConnection,
        fast_run::PyFastRun,
        history::{PyHistory, PyRecording, PyState, load_recording},
        known::{PyKnownMaze, flood},
        maze::{PyMaze, bundled_mazes},
        search::{PySearch, search},
        search_env::SearchBatch,
        simulator::PySimulator,
        strategy::PyStrategy,
    };

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::{PyModuleMethods, PyTuple};

        let strategies = mmsim_solvers::BundledStrategy::ALL.iter().map(|strategy| strategy.name());
        let robots = mmsim_trial::BundledRobot::ALL.iter().map(|robot| robot.name());
        module.add("ROBOTS", PyTuple::new(module.py(), robots.collect::<Vec<_>>())?)?;
        module.add("STRATEGIES", PyTuple::new(module.py(), strategies.collect::<Vec<_>>())?)
    }
}
