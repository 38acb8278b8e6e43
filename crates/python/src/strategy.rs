//! The class `Strategy`: a bundled strategy.

use std::sync::Mutex;

use mmsim_maze::{CellSet, MazeSize};
use mmsim_solvers::{BundledStrategy, Move, Strategy};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::convert::{inside, pose, to_pose};
use crate::error::{Error, SearchError, value_error};
use crate::grid::{UNREACHABLE, columns, from_columns};
use crate::known::PyKnownMaze;

/// A bundled strategy during one search.
#[pyclass(frozen, name = "Strategy", module = "micromouse_sim")]
pub(crate) struct PyStrategy {
    /// The name of the strategy.
    #[pyo3(get)]
    name: &'static str,
    search: Mutex<CurrentSearch>,
}

struct CurrentSearch {
    strategy: Box<dyn Strategy + Send>,
    /// The size and the goal of the first map. A strategy searches only one maze.
    maze: Option<(MazeSize, CellSet)>,
}

#[pymethods]
impl PyStrategy {
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        let kind: BundledStrategy = name.parse().map_err(value_error)?;
        let search = CurrentSearch { strategy: kind.strategy(), maze: None };
        Ok(Self { name: kind.name(), search: Mutex::new(search) })
    }

    /// Returns the pose after the next step, or None if the search is over.
    ///
    /// Call this method once for each reading, after the map contains the walls around the mouse.
    /// Raises `SearchError` if the strategy cannot continue.
    fn next_move<'py>(
        &self,
        py: Python<'py>,
        known: &PyKnownMaze,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (pose, map) = (pose(x, y, heading)?, known.lock(py)?.clone());
        inside(map.size(), pose.cell)?;
        let decision = py.detach(|| {
            let mut search = self.search.lock().map_err(|_| failed())?;
            let CurrentSearch { strategy, maze } = &mut *search;
            if *maze.get_or_insert((map.size(), *map.goals())) != (map.size(), *map.goals()) {
                let message = "a strategy searches one maze (create a Strategy for each search)";
                return Err(value_error(message));
            }
            let decision = strategy.next_move(&map, pose);
            decision.map_err(|error| SearchError::new_err(error.to_string()))
        })?;
        let Move::Step(step) = decision else { return Ok(None) };
        pose.after(step).map(|next| to_pose(py, next)).transpose()
    }

    /// Returns the weight of each cell after the last move, or 65535 for none.
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u16>>> {
        let search = self.search.lock_py_attached(py).map_err(|_| failed())?;
        let size = search.maze.map_or(MazeSize::CLASSIC, |(size, _)| size);
        let weights =
            columns(size).map(|cell| search.strategy.weight(cell).unwrap_or(UNREACHABLE)).collect();
        drop(search);
        from_columns(py, size, weights)
    }

    fn __repr__(&self) -> String {
        format!("<Strategy {:?}>", self.name)
    }
}

fn failed() -> PyErr {
    Error::new_err("an earlier move of the strategy has failed unexpectedly")
}
