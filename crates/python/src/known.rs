//! The class `KnownMaze`: the map of a mouse.

use std::sync::{Mutex, MutexGuard};

use mmsim_drawing::Scene;
use mmsim_maze::{Cell, KnownMaze, MazeSize, Unknown, WallState};
use mmsim_protocol::CellWalls;
use mmsim_solvers::{PathBounds, open_steps};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyList, PyTuple};

use crate::convert::{self, cell, cells, coordinate, heading, inside, pose, to_cells, to_pose};
use crate::error::{Contradiction, Error, type_error, value_error};
use crate::grid::{columns, from_columns, to_distances};
use crate::maze::PyMaze;

/// The map of a mouse: visited cells, and walls that are present, absent or unknown.
#[pyclass(frozen, name = "KnownMaze", module = "micromouse_sim")]
pub(crate) struct PyKnownMaze(Mutex<KnownMaze>);

impl From<KnownMaze> for PyKnownMaze {
    fn from(map: KnownMaze) -> Self {
        Self(Mutex::new(map))
    }
}

impl PyKnownMaze {
    pub(crate) fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, KnownMaze>> {
        self.0
            .lock_py_attached(py)
            .map_err(|_| Error::new_err("an earlier operation on the map has failed unexpectedly"))
    }

    fn bounds(&self, py: Python<'_>) -> PyResult<PathBounds> {
        Ok(PathBounds::new(&*self.lock(py)?))
    }

    fn cell(&self, x: &Bound<'_, PyAny>, y: &Bound<'_, PyAny>) -> PyResult<Cell> {
        let cell = Cell::new(coordinate(x)?, coordinate(y)?);
        inside(self.lock(x.py())?.size(), cell)
    }
}

/// Returns the flags of the cells of a map, column by column from the west.
pub(crate) fn flags(map: &KnownMaze) -> Vec<u8> {
    columns(map.size()).map(|cell| CellWalls::known(map, cell).0).collect()
}

/// Reads how unknown walls count.
fn unknown(text: &str) -> PyResult<Unknown> {
    match text {
        "open" => Ok(Unknown::Open),
        "closed" => Ok(Unknown::Closed),
        _ => Err(value_error(format_args!("expected open or closed, found {text:?}"))),
    }
}

#[pymethods]
impl PyKnownMaze {
    #[new]
    #[pyo3(signature = (size = None, goals = None, start = None))]
    pub(crate) fn new(
        size: Option<&Bound<'_, PyAny>>,
        goals: Option<&Bound<'_, PyAny>>,
        start: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok(MazeSize::CLASSIC), convert::size)?;
        let start = start.map_or(Ok(Cell::new(0, 0)), cell)?;
        let goals = goals.map_or_else(|| Ok(size.central_cells()), |goals| cells(goals, size))?;
        if goals.is_empty() {
            return Err(value_error("expected at least one goal cell"));
        }
        Ok(KnownMaze::new(size, inside(size, start)?, goals).into())
    }

    /// Creates the map of an unexplored maze with the size, the start and the goal of `maze`.
    #[staticmethod]
    fn unexplored(maze: &PyMaze) -> Self {
        KnownMaze::unexplored(&maze.maze).into()
    }

    /// The number of cells from west to east.
    #[getter]
    fn width(&self, py: Python<'_>) -> PyResult<u8> {
        Ok(self.lock(py)?.size().width())
    }

    /// The number of cells from south to north.
    #[getter]
    fn height(&self, py: Python<'_>) -> PyResult<u8> {
        Ok(self.lock(py)?.size().height())
    }

    /// The pose in which the mouse starts.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let start = self.lock(py)?.start();
        to_pose(py, start)
    }

    /// The goal cells.
    #[getter]
    fn goals(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let goals = *self.lock(py)?.goals();
        to_cells(py, &goals)
    }

    /// The visited cells, from south to north.
    #[getter]
    fn visited(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let visited = *self.lock(py)?.visited();
        to_cells(py, &visited)
    }

    /// The flags of each cell, as in a state.
    ///
    /// A flag is the sum of 1 (visited) and of 2, 4, 8 and 16 for known walls to the east, south,
    /// west and north.
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let (size, flags) = {
            let map = self.lock(py)?;
            (map.size(), flags(&map))
        };
        from_columns(py, size, flags)
    }

    /// Records the walls to the left, ahead and to the right, and marks the cell as visited.
    ///
    /// Raises `Contradiction` if the map contains different walls.
    fn observe(
        &self,
        py: Python<'_>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
        walls: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (pose, walls) = (pose(x, y, heading)?, convert::walls(walls)?);
        let mut map = self.lock(py)?;
        inside(map.size(), pose.cell)?;
        map.observe(pose, walls).map_err(|error| Contradiction::new_err(error.to_string()))
    }

    /// Returns whether there is a wall on this side of the cell, or None if it is unknown.
    fn wall(
        &self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
    ) -> PyResult<Option<bool>> {
        let (cell, heading) = (self.cell(x, y)?, self::heading(heading)?);
        Ok(match self.lock(x.py())?.wall(cell, heading) {
            WallState::Present => Some(true),
            WallState::Absent => Some(false),
            WallState::Unknown => None,
        })
    }

    /// Returns true if the mouse has visited the cell.
    fn is_visited(&self, x: &Bound<'_, PyAny>, y: &Bound<'_, PyAny>) -> PyResult<bool> {
        let cell = self.cell(x, y)?;
        Ok(self.lock(x.py())?.visited().contains(cell))
    }

    /// Returns true if the cell belongs to the goal.
    fn is_goal(&self, x: &Bound<'_, PyAny>, y: &Bound<'_, PyAny>) -> PyResult<bool> {
        let cell = self.cell(x, y)?;
        Ok(self.lock(x.py())?.goals().contains(cell))
    }

    /// Returns the number of steps from each cell to the goal, or 65535 if there is no path.
    ///
    /// Unknown walls count as open (optimistic) or as closed (pessimistic).
    #[pyo3(signature = (unknown = "open"))]
    fn distances<'py>(
        &self,
        py: Python<'py>,
        unknown: &str,
    ) -> PyResult<Bound<'py, PyArray2<u16>>> {
        let (unknown, map) = (self::unknown(unknown)?, self.lock(py)?.clone());
        to_distances(py, map.walls(unknown), map.goals())
    }

    /// Returns the poses after a step through a side that is known to be open.
    ///
    /// The order is front, left, right, back, in which strategies prefer equally good steps.
    fn open_poses<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        heading: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyList>> {
        let pose = pose(x, y, heading)?;
        let next: Vec<_> = {
            let map = self.lock(py)?;
            inside(map.size(), pose.cell)?;
            open_steps(&map, pose).filter_map(|(step, _)| pose.after(step)).collect()
        };
        let poses = next.into_iter().map(|pose| to_pose(py, pose));
        PyList::new(py, poses.collect::<PyResult<Vec<_>>>()?)
    }

    /// The distance from the start to the goal if all unknown walls are open.
    #[getter]
    fn optimistic_distance(&self, py: Python<'_>) -> PyResult<Option<u16>> {
        Ok(self.bounds(py)?.optimistic)
    }

    /// The distance from the start to the goal if all unknown walls are closed.
    #[getter]
    fn pessimistic_distance(&self, py: Python<'_>) -> PyResult<Option<u16>> {
        Ok(self.bounds(py)?.pessimistic)
    }

    /// True if a path is known, and no unknown wall can hide a shorter one.
    #[getter]
    fn proven(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.bounds(py)?.is_proven())
    }

    /// Returns a copy of the map.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(self.lock(py)?.clone().into())
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __eq__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<bool> {
        let Ok(other) = other.cast::<Self>() else { return Ok(false) };
        // Two locks at the same time could wait for each other.
        let map = self.lock(py)?.clone();
        Ok(map == *other.get().lock(py)?)
    }

    fn __str__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.lock(py)?.picture().to_string())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let map = self.lock(py)?;
        Ok(format!("<KnownMaze, {} of {} cells visited>", map.visited().len(), map.size()))
    }

    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<String> {
        let map = self.lock(py)?.clone();
        Ok(Scene::from_map(&map).svg())
    }
}

/// Returns the number of steps from each cell to the nearest target, or 65535 if there is no path.
///
/// `unknown` says how unknown walls of a `KnownMaze` count.
#[pyfunction]
#[pyo3(signature = (maze, targets, unknown = "open"))]
pub(crate) fn flood<'py>(
    py: Python<'py>,
    maze: &Bound<'py, PyAny>,
    targets: &Bound<'py, PyAny>,
    unknown: &str,
) -> PyResult<Bound<'py, PyArray2<u16>>> {
    let unknown = self::unknown(unknown)?;
    let walls = if let Ok(known) = maze.cast::<PyKnownMaze>() {
        known.get().lock(py)?.walls(unknown).clone()
    } else if let Ok(maze) = maze.cast::<PyMaze>() {
        maze.get().maze.walls().clone()
    } else {
        return Err(type_error("a maze", maze));
    };
    to_distances(py, &walls, &cells(targets, walls.size())?)
}
