//! Conversions of arguments from Python, and of results to Python.

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Pose, WallsAround};
use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyString, PyTuple};
use serde::Serialize;

use crate::error::{type_error, value_error};

/// The classes of `_types.py` and their frequent values.
struct Types {
    /// The letters in the order of [`Heading::ALL`]. Python usually has one object for each letter.
    letters: [Py<PyString>; 4],
    /// The members of the enum, in the same order.
    headings: [Py<PyAny>; 4],
    pose: Py<PyAny>,
    /// All values of `Walls`, by [`walls_index`].
    walls: Vec<Py<PyAny>>,
}

static TYPES: PyOnceLock<Types> = PyOnceLock::new();

impl Types {
    fn get(py: Python<'_>) -> PyResult<&Self> {
        TYPES.get_or_try_init(py, || Self::load(py))
    }

    fn load(py: Python<'_>) -> PyResult<Self> {
        let module = py.import("micromouse_sim._types")?;
        let (heading, walls) = (module.getattr("Heading")?, module.getattr("Walls")?);
        let letters =
            Heading::ALL.map(|heading| PyString::intern(py, &heading.letter().to_string()));
        let [north, east, south, west] = &letters;
        let member = |letter| PyResult::Ok(heading.call1((letter,))?.unbind());
        let headings = [member(north)?, member(east)?, member(south)?, member(west)?];
        let values = (0..8).map(|index| {
            let [left, front, right] = [0, 1, 2].map(|bit| index >> bit & 1 == 1);
            Ok(walls.call1((left, front, right))?.unbind())
        });
        let walls = values.collect::<PyResult<_>>()?;
        let letters = letters.map(Bound::unbind);
        Ok(Self { letters, headings, pose: module.getattr("Pose")?.unbind(), walls })
    }
}

const fn walls_index(WallsAround { left, front, right }: WallsAround) -> usize {
    left as usize | (front as usize) << 1 | (right as usize) << 2
}

/// Reads a heading: a `Heading` or its letter.
pub(crate) fn heading(value: &Bound<'_, PyAny>) -> PyResult<Heading> {
    let types = Types::get(value.py())?;
    for (heading, (letter, member)) in
        Heading::ALL.into_iter().zip(types.letters.iter().zip(&types.headings))
    {
        if value.is(letter) || value.is(member) {
            return Ok(heading);
        }
    }
    let Ok(text) = value.cast::<PyString>() else { return Err(type_error("a heading", value)) };
    let text = text.to_cow()?;
    letter(&text)
        .and_then(Heading::from_letter)
        .ok_or_else(|| value_error(format_args!("expected N, E, S or W, found {text:?}")))
}

/// Returns the only character of a text, or `None` if it has none or several.
pub(crate) fn letter(text: &str) -> Option<char> {
    let mut letters = text.chars();
    letters.next().filter(|_| letters.next().is_none())
}

/// Finds the value with this name.
pub(crate) fn named<T: Copy>(
    values: &[T],
    name_of: fn(T) -> &'static str,
    name: &str,
) -> PyResult<T> {
    values.iter().copied().find(|&value| name_of(value) == name).ok_or_else(|| {
        let names: Vec<_> = values.iter().copied().map(name_of).collect();
        value_error(format_args!("expected one of {}, found {name:?}", names.join(", ")))
    })
}

/// Reads a coordinate of a cell.
pub(crate) fn coordinate(value: &Bound<'_, PyAny>) -> PyResult<u8> {
    integer(value, "a coordinate from 0 to 255")
}

/// Reads a number without a sign.
pub(crate) fn number(value: &Bound<'_, PyAny>) -> PyResult<u64> {
    integer(value, "an integer from 0 to 2**64 - 1")
}

/// Checks a probability.
pub(crate) fn probability(value: f64) -> PyResult<f64> {
    if (0.0..=1.0).contains(&value) {
        return Ok(value);
    }
    Err(value_error(format_args!("expected a probability from 0 to 1, found {value}")))
}

/// Reads a limit on states or steps, or `None` for the default.
pub(crate) fn limit(value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<u32>> {
    value.map(|value| integer(value, "a limit from 0 to 4294967295")).transpose()
}

/// Reads an integer. If it does not fit the type, the `ValueError` says what was expected.
fn integer<'py, T>(value: &Bound<'py, PyAny>, expected: &str) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    value.extract().map_err(|error: PyErr| {
        if !error.is_instance_of::<PyOverflowError>(value.py()) {
            return error;
        }
        match value.str() {
            Ok(found) => value_error(format_args!("expected {expected}, found {found}")),
            Err(error) => error,
        }
    })
}

/// Reads a pose that was passed as three arguments.
pub(crate) fn pose(
    x: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    heading: &Bound<'_, PyAny>,
) -> PyResult<Pose> {
    let cell = Cell::new(coordinate(x)?, coordinate(y)?);
    Ok(Pose::new(cell, self::heading(heading)?))
}

/// Checks that a cell is inside a maze.
pub(crate) fn inside(size: MazeSize, cell: Cell) -> PyResult<Cell> {
    if size.contains(cell) {
        return Ok(cell);
    }
    Err(value_error(format_args!("the cell {cell} is outside the maze of {size} cells")))
}

/// Reads a cell as a tuple of two coordinates.
pub(crate) fn cell(value: &Bound<'_, PyAny>) -> PyResult<Cell> {
    let [x, y] = items(value, "a cell (x, y)")?;
    Ok(Cell::new(coordinate(&x)?, coordinate(&y)?))
}

/// Reads the items of an iterable with `N` items.
fn items<'py, const N: usize>(
    value: &Bound<'py, PyAny>,
    expected: &str,
) -> PyResult<[Bound<'py, PyAny>; N]> {
    let wrong = || type_error(expected, value);
    if value.hasattr("__iter__")? {
        let items = value.try_iter()?.take(N + 1).collect::<PyResult<Vec<_>>>()?;
        return items.try_into().map_err(|_| wrong());
    }
    Err(wrong())
}

/// Reads the cells of an iterable, which must be inside the maze.
pub(crate) fn cells(value: &Bound<'_, PyAny>, size: MazeSize) -> PyResult<CellSet> {
    let mut cells = CellSet::EMPTY;
    for item in value.try_iter()? {
        cells.insert(inside(size, cell(&item?)?)?);
    }
    Ok(cells)
}

/// Reads a size as a tuple of width and height.
pub(crate) fn size(value: &Bound<'_, PyAny>) -> PyResult<MazeSize> {
    let [width, height] = items(value, "a size (width, height)")?;
    let (width, height): (i64, i64) = (integer(&width, "a side")?, integer(&height, "a side")?);
    // A negative side is as invalid as an empty one.
    let side = |side: i64| usize::try_from(side).unwrap_or(0);
    MazeSize::new(side(width), side(height)).map_err(|error| {
        if width < 0 || height < 0 {
            return value_error(format_args!(
                "a side of a maze is positive, found {width}x{height}"
            ));
        }
        value_error(error)
    })
}

/// Creates a `Pose`.
pub(crate) fn to_pose(py: Python<'_>, pose: Pose) -> PyResult<Bound<'_, PyAny>> {
    let types = Types::get(py)?;
    let heading = &types.headings[pose.heading as usize];
    types.pose.bind(py).call1((pose.cell.x, pose.cell.y, heading))
}

/// Returns the `Walls`, which are created only once.
pub(crate) fn to_walls(py: Python<'_>, around: WallsAround) -> PyResult<Py<PyAny>> {
    Ok(Types::get(py)?.walls[walls_index(around)].clone_ref(py))
}

/// Reads `Walls` or another sequence of three truth values.
pub(crate) fn walls(value: &Bound<'_, PyAny>) -> PyResult<WallsAround> {
    let [left, front, right] = items(value, "walls (left, front, right)")?;
    Ok(WallsAround {
        left: left.is_truthy()?,
        front: front.is_truthy()?,
        right: right.is_truthy()?,
    })
}

/// Creates a tuple of cells.
pub(crate) fn to_cells(py: Python<'_>, cells: &CellSet) -> PyResult<Py<PyTuple>> {
    let cells: Vec<(u8, u8)> = cells.iter().map(|cell| (cell.x, cell.y)).collect();
    Ok(PyTuple::new(py, cells)?.unbind())
}

/// Converts a value with the keys of its JSON form.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let json = serde_json::to_string(value).map_err(value_error)?;
    py.import("json")?.call_method1("loads", (json,))
}
