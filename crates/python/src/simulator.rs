//! The class `Simulator`: a simulation in this process.

use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use mmsim_maze::{KnownMaze, Misreadings};
use mmsim_recording::{Block, save};
use mmsim_server::Simulation;
use pyo3::prelude::*;

use crate::connection::{Backend, PyConnection, Simulated, lock};
use crate::convert::limit;
use crate::error::io_error;
use crate::history::{HistoryStates, PyHistory, SearchedMaze};
use crate::known::PyKnownMaze;
use crate::maze::PyMaze;

/// A simulation in this process, with the rules and messages of `mmsim`.
#[pyclass(extends = PyConnection, frozen, name = "Simulator", module = "micromouse_sim")]
pub(crate) struct PySimulator {
    /// The true maze.
    #[pyo3(get)]
    pub(crate) maze: Py<PyMaze>,
    pub(crate) searched: Arc<SearchedMaze>,
    pub(crate) simulated: Arc<Mutex<Simulated>>,
}

impl PySimulator {
    /// Creates the simulation of a maze.
    pub(crate) fn initializer(
        maze: Py<PyMaze>,
        max_states: Option<u32>,
        misreadings: Misreadings,
    ) -> PyClassInitializer<Self> {
        let PyMaze { name, maze: truth, .. } = maze.get();
        let unexplored = KnownMaze::unexplored(truth);
        let searched = Arc::new(SearchedMaze { unexplored, truth: Some(truth.clone()) });
        let simulation = Simulation::new(name, truth.clone()).with_misreadings(misreadings);
        let simulated = Arc::new(Mutex::new(Simulated::new(simulation, max_states)));
        let connection = PyConnection::new(Backend::Process(Arc::clone(&simulated)), Some(true));
        PyClassInitializer::from(connection).add_subclass(Self { maze, searched, simulated })
    }
}

#[pymethods]
impl PySimulator {
    #[new]
    #[pyo3(signature = (maze, max_states = None))]
    fn new(
        maze: Py<PyMaze>,
        max_states: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        Ok(Self::initializer(maze, limit(max_states)?, Misreadings::default()))
    }

    /// Returns the map of a mouse that has not read any walls yet.
    fn unexplored(&self) -> PyKnownMaze {
        self.searched.unexplored.clone().into()
    }

    /// The states since the last reset. They change while the mouse runs.
    #[getter]
    fn history(simulator: PyRef<'_, Self>, py: Python<'_>) -> PyResult<PyHistory> {
        simulator.as_super().send_annotations(py)?;
        let states = HistoryStates::Simulator(Arc::clone(&simulator.simulated));
        Ok(PyHistory { states, searched: Arc::clone(&simulator.searched) })
    }

    /// Writes the states to a recording, which `mmsim replay` shows.
    fn save(simulator: PyRef<'_, Self>, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        simulator.as_super().send_annotations(py)?;
        let simulated = Arc::clone(&simulator.simulated);
        let write = || {
            let simulated = simulated.lock().map_err(|_| std::io::ErrorKind::Other)?;
            let Simulated { simulation, times, .. } = &*simulated;
            let history = simulation.history();
            let file = BufWriter::new(File::create(&path)?);
            // A time may be missing if memory ran out.
            let mut times = times.iter().chain(std::iter::repeat(times.last().unwrap_or(0)));
            let blocks = (0..history.len().div_ceil(Block::STATES))
                .filter_map(|block| history.block(block).and_then(Block::unpack));
            let states = blocks.enumerate().flat_map(|(block, states)| {
                let first = block * Block::STATES;
                let state = |index| {
                    let update = states.update(index)?.to_vec();
                    Some((times.next()?, update, states.get(index)?.to_vec()))
                };
                (first..first + states.len()).filter_map(state).collect::<Vec<_>>()
            });
            save(file, &simulation.info(), Some(simulation.maze()), states, &simulation.trailing())
        };
        py.detach(write).map_err(|error: std::io::Error| {
            io_error(error.kind(), format_args!("cannot write {}: {error}", path.display()))
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let states = lock(&self.simulated, py)?.simulation.history().len();
        let PyMaze { name, .. } = self.maze.get();
        Ok(format!("<Simulator of {name:?}, {states} states>"))
    }
}
