//! The class `Recording`: the states in a file.

use std::path::PathBuf;
use std::sync::Arc;

use mmsim_maze::KnownMaze;
use mmsim_recording::{Integrity, OpenError, ReadError};
use pyo3::prelude::*;

use crate::compare::to_python;
use crate::error::{RecordingError, io_error};
use crate::history::{History, SearchedMaze, StateSource};
use crate::maze::PyMaze;

/// The states in a file.
#[pyclass(frozen, name = "Recording", module = "micromouse_sim")]
pub(crate) struct PyRecording {
    recording: Arc<mmsim_recording::Recording>,
    searched: Arc<SearchedMaze>,
}

/// Reads a recording of `mmsim` or of `Simulator.save`.
#[pyfunction]
pub(crate) fn load_recording(py: Python<'_>, path: PathBuf) -> PyResult<PyRecording> {
    let recording = py.detach(|| mmsim_recording::Recording::open(&path));
    let recording = recording.map_err(|error: OpenError| match &error.source {
        ReadError::Io(source) => io_error(source.kind(), &error),
        _ => RecordingError::new_err(error.to_string()),
    })?;
    let (info, truth) = (recording.info(), recording.maze().cloned());
    let start = info.start_pose().map_or(mmsim_maze::Cell::new(0, 0), |start| start.cell);
    let unexplored = KnownMaze::new(recording.size(), start, info.goal_cells());
    let searched = Arc::new(SearchedMaze { unexplored, truth });
    Ok(PyRecording { recording: Arc::new(recording), searched })
}

#[pymethods]
impl PyRecording {
    /// The true maze, or None if a client has made the recording.
    #[getter]
    fn maze(&self) -> Option<PyMaze> {
        let maze = self.searched.truth.clone()?;
        Some(PyMaze { path: PathBuf::new(), name: self.recording.info().name.clone(), maze })
    }

    /// The states.
    #[getter]
    fn states(&self) -> History {
        let states = StateSource::Recording(Arc::clone(&self.recording));
        History { states, maze: Arc::clone(&self.searched) }
    }

    /// The reply of the simulator to `info`.
    #[getter]
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.recording.info())
    }

    /// False if the recording has not been closed, or the file is damaged.
    #[getter]
    fn is_complete(&self) -> bool {
        *self.recording.integrity() == Integrity::Closed
    }

    fn __repr__(&self) -> String {
        format!(
            "<Recording of {:?}, {} states>",
            self.recording.info().name,
            self.recording.history().len()
        )
    }
}
