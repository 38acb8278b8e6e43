//! Grids with a number for each cell, indexed as `grid[x, y]`, and the arrays that hold them.

use mmsim_maze::{Cell, CellSet, MazeSize, Walls};
use mmsim_solvers::Distances;
use numpy::ndarray::Array2;
use numpy::{
    Element, IntoPyArray, PyArray2, PyArrayMethods as _, PyReadonlyArray2,
    PyUntypedArrayMethods as _,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyAnyMethods;

use crate::error::{type_error, value_error};

/// The number for a cell from which no target can be reached.
pub(crate) const UNREACHABLE: u16 = u16::MAX;

/// Creates an array that owns the numbers of the cells, which are not copied.
pub(crate) fn from_columns<T: Element>(
    py: Python<'_>,
    size: MazeSize,
    numbers: Vec<T>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    // The crate `numpy` panics if the package is missing.
    py.import("numpy")?;
    let shape = (size.width().into(), size.height().into());
    Ok(Array2::from_shape_vec(shape, numbers).map_err(value_error)?.into_pyarray(py))
}

/// Creates an array with the number of each cell.
pub(crate) fn to_array<T: Element>(
    py: Python<'_>,
    size: MazeSize,
    number: impl Fn(Cell) -> T,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    from_columns(py, size, columns(size).map(number).collect())
}

/// Creates the array of distances to the targets. Unreachable cells have the distance 65535.
pub(crate) fn to_distances<'py>(
    py: Python<'py>,
    walls: &Walls,
    targets: &CellSet,
) -> PyResult<Bound<'py, PyArray2<u16>>> {
    let distances = Distances::flood(walls, targets);
    to_array(py, walls.size(), |cell| distances.at(cell).unwrap_or(UNREACHABLE))
}

/// Iterates over all cells column by column from the west, each from the south.
pub(crate) fn columns(size: MazeSize) -> impl Iterator<Item = Cell> {
    (0..size.width()).flat_map(move |x| (0..size.height()).map(move |y| Cell::new(x, y)))
}

/// The bytes of a grid, column by column from the west, as in a state.
#[derive(PartialEq, Eq)]
pub(crate) struct GridBytes {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cells: Vec<u8>,
}

impl GridBytes {
    /// Reads a two-dimensional array or nested sequences of integers. Integers above 255 become
    /// 255. Errors begin with the name of the argument.
    pub(crate) fn read(name: &str, grid: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(bytes) = Self::from_array::<u16>(grid)
            .or_else(|| Self::from_array::<u8>(grid))
            .or_else(|| Self::from_array::<i64>(grid))
            .or_else(|| Self::from_array::<i32>(grid))
        {
            return bytes;
        }
        let (mut width, mut height, mut cells) = (0, None, Vec::new());
        let expected = |what: &str, found: &Bound<'_, PyAny>, error: PyErr| {
            if error.is_instance_of::<PyTypeError>(found.py()) {
                type_error(&format!("{name} to be {what}"), found)
            } else {
                error
            }
        };
        for column in grid.try_iter().map_err(|error| expected("an array", grid, error))? {
            let (column, start) = (column?, cells.len());
            let column_cells =
                column.try_iter().map_err(|error| expected("a list of columns", &column, error));
            for cell in column_cells? {
                let cell = cell?;
                cells.push(clipped(&cell).map_err(|error| expected("integers", &cell, error))?);
            }
            width += 1;
            let found = cells.len() - start;
            if *height.get_or_insert(found) != found {
                return Err(value_error("the columns of a grid must have the same length"));
            }
        }
        Ok(Self { width, height: height.unwrap_or(0), cells })
    }

    fn from_array<T: Element + Copy + TryInto<u64> + PartialOrd + Default>(
        grid: &Bound<'_, PyAny>,
    ) -> Option<PyResult<Self>> {
        // The crate `numpy` imports NumPy, which a list does not need.
        if grid.is_exact_instance_of::<pyo3::types::PyList>()
            || grid.is_exact_instance_of::<pyo3::types::PyTuple>()
            || grid.py().import("numpy").is_err()
        {
            return None;
        }
        let array = grid.extract::<PyReadonlyArray2<'_, T>>().ok()?;
        // `as_array` cannot express the strides of packed structures.
        if !array.is_contiguous() || !array.data().is_aligned() {
            return None;
        }
        let array = array.as_array();
        let (width, height) = array.dim();
        let cells = array.iter().map(|&cell| {
            let cell = cell.try_into().map_err(|_| negative())?;
            Ok(u8::try_from(cell).unwrap_or(u8::MAX))
        });
        Some(cells.collect::<PyResult<_>>().map(|cells| Self { width, height, cells }))
    }

    /// Checks that the grid fits a maze of this size.
    pub(crate) fn check_size(&self, size: MazeSize) -> PyResult<()> {
        let Self { width, height, .. } = *self;
        if (width, height) == (size.width().into(), size.height().into()) {
            return Ok(());
        }
        Err(value_error(format_args!("expected a grid of {size} cells, found {width}x{height}")))
    }
}

fn negative() -> PyErr {
    value_error("expected integers of at least 0 in a grid")
}

fn clipped(cell: &Bound<'_, PyAny>) -> PyResult<u8> {
    match cell.extract::<u8>() {
        Ok(cell) => Ok(cell),
        Err(error) if error.is_instance_of::<pyo3::exceptions::PyOverflowError>(cell.py()) => {
            if cell.lt(0)? {
                Err(negative())
            } else {
                Ok(u8::MAX)
            }
        }
        Err(error) => Err(error),
    }
}
