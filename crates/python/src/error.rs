//! The exceptions that Rust errors become.

use std::fmt::Display;
use std::io;

use mmsim_client::RunError;
use mmsim_formats::{ParsedMaze, ReadError};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(micromouse_sim._errors, Contradiction);
import_exception!(micromouse_sim._errors, Error);
import_exception!(micromouse_sim._errors, MazeError);
import_exception!(micromouse_sim._errors, NoReply);
import_exception!(micromouse_sim._errors, RecordingError);
import_exception!(micromouse_sim._errors, Refused);
import_exception!(micromouse_sim._errors, SearchError);
import_exception!(micromouse_sim._errors, SimulatorError);

/// Creates a `ValueError`.
pub(crate) fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Creates a `TypeError` that names the type of the argument.
pub(crate) fn type_error(expected: &str, found: &Bound<'_, PyAny>) -> PyErr {
    match found.get_type().name() {
        Ok(name) => PyTypeError::new_err(format!("expected {expected}, found {name}")),
        Err(error) => error,
    }
}

/// Creates a `SimulatorError`, or a `Refused` if the simulator refused the request.
pub(crate) fn run_error(error: RunError) -> PyErr {
    let message = error.to_string();
    match error {
        RunError::Refused { .. } => Refused::new_err(message),
        _ => SimulatorError::new_err(message),
    }
}

/// Creates a `MazeError`.
pub(crate) fn maze_error(error: impl Display) -> PyErr {
    MazeError::new_err(error.to_string())
}

/// Creates the subclass of `OSError` for the kind of the cause, with the message of `error`.
pub(crate) fn io_error(kind: io::ErrorKind, error: impl Display) -> PyErr {
    io::Error::new(kind, error.to_string()).into()
}

/// Creates a `MazeError` for an invalid maze, or a subclass of `OSError` for an unreadable file.
pub(crate) fn read_error(error: &ReadError) -> PyErr {
    match error {
        ReadError::Io { source, .. } => io_error(source.kind(), error),
        _ => parse_error(error, error.readings()),
    }
}

/// Creates a `MazeError` that draws the mazes an ambiguous file could mean below the message.
pub(crate) fn parse_error(error: impl Display, readings: &[ParsedMaze]) -> PyErr {
    let drawn: String = readings.iter().map(ParsedMaze::to_string).collect();
    maze_error(format!("{error}\n{drawn}").trim_end())
}
