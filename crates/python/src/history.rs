//! The classes `History` and `State`: what a mouse has reported.

use std::iter;
use std::sync::Arc;

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, KnownMaze, Maze, Pose};
use mmsim_protocol::State;
use numpy::PyArray2;
use pyo3::exceptions::{PyIndexError, PyMemoryError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList, PySlice, PySliceMethods};

use crate::connection::{Connection, Link, lock};
use crate::error::{type_error, value_error};
use crate::geometry::to_pose;
use crate::grid::to_array;
use crate::known::PyKnownMaze;
use crate::simulator::Simulator;

/// The maze to which states belong.
#[derive(Debug)]
pub(crate) struct Place {
    /// The map before the first state, which has the size, the start and the goal.
    pub(crate) unexplored: KnownMaze,
    /// The true maze, if it is known.
    pub(crate) truth: Option<Maze>,
}

/// The states that a mouse has reported, from the oldest to the newest.
#[pyclass(frozen, sequence, module = "micromouse_sim")]
pub(crate) struct History {
    source: Source,
    place: Arc<Place>,
}

enum Source {
    /// The current states of a simulator.
    Live(Py<Simulator>),
    /// The states in a file.
    Recorded(Arc<mmsim_recording::Recording>),
    /// The states of a search that has ended.
    Ended(Arc<mmsim_recording::History>),
}

impl History {
    pub(crate) fn live(simulator: Py<Simulator>, place: Arc<Place>) -> Self {
        Self { source: Source::Live(simulator), place }
    }

    pub(crate) fn recorded(recording: Arc<mmsim_recording::Recording>, place: Arc<Place>) -> Self {
        Self { source: Source::Recorded(recording), place }
    }

    pub(crate) fn ended(history: Arc<mmsim_recording::History>, place: Arc<Place>) -> Self {
        Self { source: Source::Ended(history), place }
    }

    /// Calls a function with the states.
    pub(crate) fn read<R>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&mmsim_recording::History) -> R,
    ) -> PyResult<R> {
        match &self.source {
            Source::Recorded(recording) => Ok(read(recording.history())),
            Source::Ended(history) => Ok(read(history)),
            Source::Live(simulator) => {
                let simulator = simulator.bind(py).as_super().get();
                read_simulation(simulator, py, read)
            }
        }
    }

    fn state(&self, index: usize, bytes: Vec<u8>) -> HistoryState {
        HistoryState { index, bytes, place: Arc::clone(&self.place) }
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
        let list = PyList::empty(py);
        for (index, bytes) in states {
            list.append(Bound::new(py, self.state(index, bytes))?)?;
        }
        Ok(list)
    }
}

/// Calls a function with the states of a simulation in this process.
pub(crate) fn read_simulation<R>(
    connection: &Connection,
    py: Python<'_>,
    read: impl FnOnce(&mmsim_recording::History) -> R,
) -> PyResult<R> {
    match &connection.link {
        Link::Process(simulated) => Ok(read(lock(simulated, py)?.simulation.history())),
        Link::Socket(_) => Err(value_error("a client has no history")),
    }
}

#[pymethods]
impl History {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.read(py, mmsim_recording::History::len)
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

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<History of {} states>", self.__len__(py)?))
    }
}

/// A state: the pose of a mouse, its weights and its map. States with the same bytes are equal.
#[pyclass(frozen, name = "State", module = "micromouse_sim")]
pub(crate) struct HistoryState {
    index: usize,
    bytes: Vec<u8>,
    place: Arc<Place>,
}

impl HistoryState {
    fn decode(&self) -> PyResult<State<'_>> {
        State::decode(&self.bytes, self.place.unexplored.size()).map_err(value_error)
    }

    fn map(&self) -> PyResult<KnownMaze> {
        let unexplored = &self.place.unexplored;
        Ok(self.decode()?.map(unexplored.start().cell, *unexplored.goals()))
    }
}

/// Draws the pose, the weights and the map of a mouse.
pub(crate) fn draw(state: &State<'_>, map: &KnownMaze, truth: Option<&Maze>) -> String {
    let weight = |cell: Cell| state.weights().at(cell).unwrap_or(0);
    Scene::from_map(map).with_truth(truth).with_mouse(state.pose()).with_weights(weight).svg()
}

#[pymethods]
impl HistoryState {
    /// The number of states before this one.
    #[getter]
    fn index(&self) -> usize {
        self.index
    }

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

    fn _repr_svg_(&self) -> PyResult<String> {
        Ok(draw(&self.decode()?, &self.map()?, self.place.truth.as_ref()))
    }
}
