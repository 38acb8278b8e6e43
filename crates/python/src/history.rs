//! The classes `History`, `State` and `Recording`: what a mouse has reported.

use std::iter;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, KnownMaze, Maze, Pose};
use mmsim_protocol::{Colour, State};
use mmsim_recording::{
    History, Integrity, Notes, OpenError, ReadError, Recording, TrailingAnnotations,
};
use numpy::PyArray2;
use pyo3::exceptions::{PyIndexError, PyMemoryError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PySlice, PySliceMethods};

use crate::connection::{Simulated, lock};
use crate::convert::{to_pose, to_python};
use crate::error::{RecordingError, io_error, type_error, value_error};
use crate::grid::to_array;
use crate::known::PyKnownMaze;
use crate::maze::PyMaze;

/// The maze that a mouse searched when it reported its states.
pub(crate) struct SearchedMaze {
    /// The map before the first state, which has the size, the start and the goal.
    pub(crate) unexplored: KnownMaze,
    /// The true maze, if it is known.
    pub(crate) truth: Option<Maze>,
}

/// The states that a mouse has reported, from the oldest to the newest.
#[pyclass(frozen, sequence, name = "History", module = "micromouse_sim")]
pub(crate) struct PyHistory {
    pub(crate) states: HistoryStates,
    pub(crate) searched: Arc<SearchedMaze>,
}

/// Where the states of a history are.
pub(crate) enum HistoryStates {
    /// The current states of a simulator.
    Simulator(Arc<Mutex<Simulated>>),
    /// The states in a file.
    Recording(Arc<Recording>),
    /// The states of a search that has ended.
    Search(Arc<History>),
}

impl PyHistory {
    /// Calls a function with the states.
    fn read<R>(&self, py: Python<'_>, read: impl FnOnce(&History) -> R) -> PyResult<R> {
        self.read_whole(py, |history, _| read(history))
    }

    /// Calls a function with the states and the annotations after the last state.
    fn read_whole<R>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&History, &TrailingAnnotations) -> R,
    ) -> PyResult<R> {
        Ok(match &self.states {
            HistoryStates::Simulator(simulated) => {
                let simulation = &lock(simulated, py)?.simulation;
                read(simulation.history(), &simulation.trailing())
            }
            HistoryStates::Recording(recording) => read(recording.history(), recording.trailing()),
            HistoryStates::Search(history) => read(history, &TrailingAnnotations::default()),
        })
    }

    /// Returns a value for each cell that has one at the end of the run.
    fn displayed<'py, T: IntoPyObject<'py>>(
        &self,
        py: Python<'py>,
        value: impl Fn(&Notes, Cell) -> Option<T>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let context = self.read_whole(py, |history, trailing| {
            let mut context = history.newest_context();
            context.annotate(trailing);
            context
        })?;
        let values = PyDict::new(py);
        for cell in self.searched.unexplored.size().cells() {
            if let Some(value) = value(context.notes(), cell) {
                values.set_item((cell.x, cell.y), value)?;
            }
        }
        Ok(values)
    }

    fn state(&self, index: usize, bytes: Vec<u8>) -> PyState {
        PyState { index, bytes, searched: Arc::clone(&self.searched) }
    }

    /// Creates a list of the states with these indices.
    fn states<'py>(
        &self,
        py: Python<'py>,
        indices: impl Iterator<Item = usize>,
    ) -> PyResult<Bound<'py, PyList>> {
        let states = self.read(py, |history| {
            let mut reader = history.reader();
            let state = |index| Some((index, reader.get(index)?.to_vec()));
            indices.map(state).collect::<Option<Vec<_>>>()
        })?;
        let states = states.ok_or_else(|| PyMemoryError::new_err("cannot read the states"))?;
        PyList::new(py, states.into_iter().map(|(index, bytes)| self.state(index, bytes)))
    }
}

#[pymethods]
impl PyHistory {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, History::len)
    }

    fn __getitem__<'py>(
        &self,
        py: Python<'py>,
        index: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let length = self.__len__(py)?;
        if let Ok(slice) = index.cast::<PySlice>() {
            let range = slice.indices(isize::try_from(length)?)?;
            let positions = iter::successors(Some(range.start), |at| at.checked_add(range.step));
            let indices = positions.take(range.slicelength).filter_map(|at| at.try_into().ok());
            return Ok(self.states(py, indices)?.into_any());
        }
        let Ok(number) = index.extract::<isize>() else {
            return Err(type_error("an index or a slice", index));
        };
        let out_of_range = || {
            PyIndexError::new_err(format!("state {number} out of range, the history has {length}"))
        };
        let index =
            if number < 0 { length.checked_add_signed(number) } else { number.try_into().ok() };
        let index = index.ok_or_else(out_of_range)?;
        let bytes = self.read(py, |history| history.get(index))?.ok_or_else(out_of_range)?;
        Ok(Bound::new(py, self.state(index, bytes))?.into_any())
    }

    fn __iter__<'py>(history: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        // Unpacks one state at a time: a packed history may hold millions.
        let builtins = history.py().import("builtins")?;
        let indices = builtins.call_method1("range", (history.len()?,))?;
        builtins.call_method1("map", (history.getattr("__getitem__")?, indices))
    }

    /// The log lines of the mouse, each with the index of the state that follows it.
    ///
    /// The index of a line that no state follows is the number of states.
    #[getter]
    fn log(&self, py: Python<'_>) -> PyResult<Vec<(usize, String)>> {
        let lines = self.read_whole(py, |history, trailing| {
            let mut lines = history.log(usize::MAX, usize::MAX, |_| true);
            lines.extend(trailing.log_lines(history.len()));
            lines
        })?;
        Ok(lines.into_iter().map(|line| (line.state, line.text)).collect())
    }

    /// The texts that the mouse displays at the end, by cell.
    #[getter]
    fn texts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.displayed(py, |notes, cell| {
            Some(notes.text(cell).to_string()).filter(|text| !text.is_empty())
        })
    }

    /// The letters of the colours that the mouse displays at the end, by cell.
    #[getter]
    fn colours<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.displayed(py, |notes, cell| notes.colour(cell).map(Colour::letter))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<History of {} states>", self.__len__(py)?))
    }
}

/// A state: the pose of a mouse, its weights and its map. States with the same bytes are equal.
#[pyclass(frozen, name = "State", module = "micromouse_sim")]
pub(crate) struct PyState {
    /// The number of states before this one.
    #[pyo3(get)]
    pub(crate) index: usize,
    pub(crate) bytes: Vec<u8>,
    pub(crate) searched: Arc<SearchedMaze>,
}

impl PyState {
    fn decode(&self) -> PyResult<State<'_>> {
        State::decode(&self.bytes, self.searched.unexplored.size()).map_err(value_error)
    }

    fn map(&self) -> PyResult<KnownMaze> {
        let unexplored = &self.searched.unexplored;
        Ok(self.decode()?.map(unexplored.start().cell, *unexplored.goals()))
    }
}

#[pymethods]
impl PyState {
    /// The bytes of the message S.
    #[getter]
    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    /// The pose of the mouse.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_pose(py, self.decode()?.pose())
    }

    /// The weight of each cell. 255 means 255 or more.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let state = self.decode()?;
        to_array(py, state.size(), |cell| state.weights().at(cell).unwrap_or(0))
    }

    /// The flags of each cell (see `KnownMaze.walls`).
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let state = self.decode()?;
        to_array(py, state.size(), |cell| state.walls().at(cell).unwrap_or(0))
    }

    /// The map of the mouse.
    #[getter]
    fn known(&self) -> PyResult<PyKnownMaze> {
        self.map().map(PyKnownMaze::from)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().bytes == self.bytes)
    }

    fn __repr__(&self) -> PyResult<String> {
        let Pose { cell, heading } = self.decode()?.pose();
        Ok(format!("<State {} at {cell} heading {heading}>", self.index))
    }

    #[pyo3(name = "_repr_svg_")]
    pub(crate) fn svg(&self) -> PyResult<String> {
        let (state, map) = (self.decode()?, self.map()?);
        let scene = Scene::from_map(&map).with_truth(self.searched.truth.as_ref());
        let weight = |cell: Cell| state.weights().at(cell).unwrap_or(0);
        Ok(scene.with_mouse(state.pose()).with_weights(weight).svg())
    }
}

/// The states in a file.
#[pyclass(frozen, name = "Recording", module = "micromouse_sim")]
pub(crate) struct PyRecording {
    recording: Arc<Recording>,
    searched: Arc<SearchedMaze>,
}

/// Reads a recording of `mmsim` or of `Simulator.save`.
#[pyfunction]
pub(crate) fn load_recording(py: Python<'_>, path: PathBuf) -> PyResult<PyRecording> {
    let recording = py.detach(|| Recording::open(&path));
    let recording = recording.map_err(|error: OpenError| match &error.source {
        ReadError::Io(source) => io_error(source.kind(), &error),
        _ => RecordingError::new_err(error.to_string()),
    })?;
    let (info, truth) = (recording.info(), recording.maze().cloned());
    let start = info.start_pose().map_or(Cell::new(0, 0), |start| start.cell);
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
        Some(PyMaze { path: PathBuf::new(), name: self.recording.info().maze.clone(), maze })
    }

    /// The states.
    #[getter]
    fn states(&self) -> PyHistory {
        let states = HistoryStates::Recording(Arc::clone(&self.recording));
        PyHistory { states, searched: Arc::clone(&self.searched) }
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
            self.recording.info().maze,
            self.recording.history().len()
        )
    }
}
