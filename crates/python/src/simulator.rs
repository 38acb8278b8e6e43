//! The class `Simulator`: a simulation in this process.

use std::sync::Mutex;

use mmsim_server::Simulation;
use pyo3::prelude::*;

use crate::connection::{Connection, Link, Simulated};
use crate::maze::PyMaze;

/// A simulation in this process.
#[pyclass(extends = Connection, frozen, module = "micromouse_sim")]
pub(crate) struct Simulator {
    maze: Py<PyMaze>,
}

#[pymethods]
impl Simulator {
    #[new]
    fn new(maze: Py<PyMaze>) -> PyClassInitializer<Self> {
        let PyMaze { name, maze: true_maze } = maze.get();
        let simulation = Simulation::new(name, true_maze.clone());
        let link = Link::Process(Mutex::new(Simulated::new(simulation)));
        PyClassInitializer::from(Connection { link }).add_subclass(Self { maze })
    }

    #[getter]
    fn maze(&self, py: Python<'_>) -> Py<PyMaze> {
        self.maze.clone_ref(py)
    }

    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::geometry::to_pose(py, self.maze.get().maze.start())
    }
}
