//! The class `Maze`: the true maze.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use mmsim_compare::NamedMaze;
use mmsim_drawing::Scene;
use mmsim_formats::{Catalogue, Choice, Entry, Format, ReadError, read_content};
use mmsim_generator::{Style, generate, random_seed};
use mmsim_maze::{Cell, Maze, MazeSize};
use mmsim_protocol::CellWalls;
use mmsim_solvers::Distances;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString, PyTuple};

use crate::convert::{coordinate, heading, inside, named, number, size, to_cells, to_pose};
use crate::error::{io_error, maze_error, parse_error, read_error, type_error, value_error};
use crate::fast_run::PyFastRun;
use crate::grid::{to_array, to_distances};

/// A maze and its name. Mazes with the same cells, walls, start and goal are equal.
#[pyclass(frozen, name = "Maze", module = "micromouse_sim")]
pub(crate) struct PyMaze {
    /// The path of the file, or an empty path.
    pub(crate) path: PathBuf,
    /// The name of the maze.
    #[pyo3(get)]
    pub(crate) name: String,
    pub(crate) maze: Maze,
}

impl PyMaze {
    /// Reads a maze file. The name is the name of the file without the extension.
    fn read(path: PathBuf, choice: Choice) -> Result<Self, ReadError> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into();
        match choice.read(&read_content(&path)?) {
            Ok(parsed) => Ok(Self { path, name, maze: parsed.maze }),
            Err(errors) => Err(ReadError::Parse { path, errors }),
        }
    }

    /// Reads a maze of a collection.
    pub(crate) fn from_entry(entry: &Entry) -> Result<Self, ReadError> {
        Ok(Self { path: entry.path().into(), name: entry.name(), maze: entry.maze()? })
    }

    pub(crate) fn named(&self) -> NamedMaze {
        let Self { path, name, maze } = self;
        NamedMaze { path: path.clone(), name: name.clone(), maze: maze.clone() }
    }

    fn size(&self) -> MazeSize {
        self.maze.size()
    }
}

/// Returns the encodings that the arguments `bits` and `rows` select.
fn choice(bits: Option<&str>, rows: Option<&str>) -> PyResult<Choice> {
    let bits = bits.map(str::parse).transpose().map_err(value_error)?;
    let rows = rows.map(str::parse).transpose().map_err(value_error)?;
    Ok(Choice { bits, rows })
}

#[pymethods]
impl PyMaze {
    /// Reads a maze file. The format is detected from the content.
    ///
    /// If a file of numbers could mean several mazes, `bits` and `rows` select one, as the options of
    /// `mmsim mazes convert` do.
    ///
    /// Raises `MazeError` if the content is not a maze, or a subclass of `OSError`.
    #[staticmethod]
    #[pyo3(signature = (path, *, bits = None, rows = None))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        bits: Option<&str>,
        rows: Option<&str>,
    ) -> PyResult<Self> {
        let choice = choice(bits, rows)?;
        py.detach(|| Self::read(path, choice)).map_err(|error| read_error(&error))
    }

    /// Reads a maze from the content of a maze file, like `load`.
    #[staticmethod]
    #[pyo3(signature = (content, name = "maze", *, bits = None, rows = None))]
    fn parse(
        content: &Bound<'_, PyAny>,
        name: &str,
        bits: Option<&str>,
        rows: Option<&str>,
    ) -> PyResult<Self> {
        let choice = choice(bits, rows)?;
        let parsed = if let Ok(text) = content.cast::<PyString>() {
            choice.read(text.to_cow()?.as_bytes())
        } else if let Ok(bytes) = content.cast::<PyBytes>() {
            choice.read(bytes.as_bytes())
        } else {
            return Err(type_error("str or bytes", content));
        };
        let parsed = parsed.map_err(|errors| parse_error(&errors[0], &errors[0].readings))?;
        Ok(Self { path: PathBuf::new(), name: name.into(), maze: parsed.maze })
    }

    /// Returns the first bundled maze whose name contains every word of `name`.
    #[staticmethod]
    fn bundled(name: &str) -> PyResult<Self> {
        let catalogue = Catalogue::bundled();
        let Some(entry) = catalogue.matching(name).next() else {
            let reason = "no bundled maze matches";
            return Err(maze_error(format_args!("{reason} {name:?} (see bundled_mazes())")));
        };
        Self::from_entry(entry).map_err(|error| read_error(&error))
    }

    /// Generates a maze, by default of 16x16 cells. The same seed gives the same maze.
    ///
    /// The name contains the seed, which is random by default.
    #[staticmethod]
    #[pyo3(signature = (seed = None, size = None, style = "contest"))]
    fn generate(
        py: Python<'_>,
        seed: Option<&Bound<'_, PyAny>>,
        size: Option<&Bound<'_, PyAny>>,
        style: &str,
    ) -> PyResult<Self> {
        let size = size.map_or(Ok(MazeSize::CLASSIC), self::size)?;
        let style = named(Style::ALL, Style::name, style)?;
        let seed = seed.map_or_else(|| Ok(random_seed()), number)?;
        let maze = py.detach(|| generate(size, seed, style));
        Ok(Self { path: PathBuf::new(), name: format!("{style}-{size}-{seed}"), maze })
    }

    /// Writes a maze file. The extension determines the format: text without one.
    #[pyo3(signature = (path, format = None))]
    fn save(&self, py: Python<'_>, path: PathBuf, format: Option<&str>) -> PyResult<()> {
        let format = match format {
            Some(format) => named(&Format::ALL, Format::name, format)?,
            None if path.extension().is_none() => Format::Text,
            None => Format::from_path(&path).ok_or_else(|| {
                value_error(format_args!(
                    "unknown format of {} (use .txt, .trial, .maz or .num, or pass format=...)",
                    path.display()
                ))
            })?,
        };
        let content = format.write(&self.maze).map_err(maze_error)?;
        py.detach(|| fs::write(&path, content)).map_err(|error| {
            io_error(error.kind(), format_args!("cannot write {}: {error}", path.display()))
        })
    }

    /// Returns the content of a maze file.
    #[pyo3(signature = (format = "text"))]
    fn write<'py>(&self, py: Python<'py>, format: &str) -> PyResult<Bound<'py, PyBytes>> {
        let format = named(&Format::ALL, Format::name, format)?;
        Ok(PyBytes::new(py, &format.write(&self.maze).map_err(maze_error)?))
    }

    /// The number of cells from west to east.
    #[getter]
    fn width(&self) -> u8 {
        self.size().width()
    }

    /// The number of cells from south to north.
    #[getter]
    fn height(&self) -> u8 {
        self.size().height()
    }

    /// The pose in which a mouse starts.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_pose(py, self.maze.start())
    }

    /// The goal cells.
    #[getter]
    fn goals(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        to_cells(py, self.maze.goals())
    }

    /// Returns true if there is a wall on this side of the cell.
    fn has_wall(
        &self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        let cell = inside(self.size(), Cell::new(coordinate(x)?, coordinate(y)?))?;
        Ok(self.maze.walls().has(cell, self::heading(heading)?))
    }

    /// The walls of each cell: the sum of 2 (east), 4 (south), 8 (west) and 16 (north).
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let walls = self.maze.walls();
        to_array(py, self.size(), |cell| CellWalls::from_sides(walls.sides(cell)).0)
    }

    /// Returns the number of steps from each cell to the goal, or 65535 if there is no path.
    fn distances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u16>>> {
        to_distances(py, self.maze.walls(), self.maze.goals())
    }

    /// Returns the cells of a shortest path to the goal, or None if there is none.
    fn shortest_path(&self) -> Option<Vec<(u8, u8)>> {
        let walls = self.maze.walls();
        let distances = Distances::flood(walls, self.maze.goals());
        let mut cell = self.maze.start().cell;
        let mut path = vec![(cell.x, cell.y)];
        for steps in (0..distances.at(cell)?).rev() {
            cell = walls.open_neighbours(cell).find(|&next| distances.at(next) == Some(steps))?;
            path.push((cell.x, cell.y));
        }
        Some(path)
    }

    /// Plans the fastest run of a vehicle, in seconds.
    ///
    /// `vehicle` is ukmars, ares, expert, kerise, or the path of a TOML file. The default is expert,
    /// and kerise in mazes larger than 16×16.
    /// Raises `SearchError` if the goal is unreachable.
    #[pyo3(signature = (vehicle = None))]
    fn fastest_run(&self, py: Python<'_>, vehicle: Option<&str>) -> PyResult<PyFastRun> {
        PyFastRun::plan(py, &self.maze, vehicle)
    }

    fn _repr_svg_(&self) -> String {
        Scene::from_maze(&self.maze).svg()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().maze == self.maze)
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.maze.to_string().hash(&mut hasher);
        hasher.finish()
    }

    fn __str__(&self) -> String {
        self.maze.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<Maze {:?}, {} cells>", self.name, self.size())
    }
}

/// Returns the names of the bundled mazes.
#[pyfunction]
pub(crate) fn bundled_mazes(py: Python<'_>) -> PyResult<Bound<'_, PyTuple>> {
    let names: Vec<_> =
        Catalogue::bundled().entries().iter().map(mmsim_formats::Entry::name).collect();
    PyTuple::new(py, names)
}
