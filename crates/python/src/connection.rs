//! The class `Connection`: the requests of a mouse to a simulator.

use std::sync::Mutex;

use mmsim_maze::{MazeSize, WallsAround};
use mmsim_protocol::{Reply, Request};
use mmsim_server::Simulation;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;

use crate::error::{Refused, SimulatorError, value_error};
use crate::geometry::{pose, to_walls};
use crate::grid;

/// The base class of `Simulator` and `Client`.
#[pyclass(subclass, frozen, module = "micromouse_sim")]
pub(crate) struct Connection {
    pub(crate) link: Link,
}

/// What answers the requests.
pub(crate) enum Link {
    /// A simulation in this process. The lock is never held while Python code runs.
    Process(Mutex<Simulated>),
}

/// A simulation and the buffer of its last reply.
pub(crate) struct Simulated {
    pub(crate) simulation: Simulation,
    reply: Vec<u8>,
}

impl Simulated {
    pub(crate) const fn new(simulation: Simulation) -> Self {
        Self { simulation, reply: Vec::new() }
    }
}

impl Link {
    /// Sends a request and passes the reply to `read`.
    fn exchange<R>(
        &self,
        py: Python<'_>,
        request: &[u8],
        read: impl FnOnce(&[u8]) -> R,
    ) -> PyResult<R> {
        match self {
            Self::Process(simulated) => {
                let mut simulated = simulated.lock_py_attached(py).map_err(poisoned)?;
                let Simulated { simulation, reply } = &mut *simulated;
                simulation.handle(request, reply);
                Ok(read(reply))
            }
        }
    }

    /// Sends a request and decodes the reply.
    fn ask<R>(
        &self,
        py: Python<'_>,
        name: &str,
        request: &[u8],
        expected: impl FnOnce(Reply<'_>) -> Option<R>,
    ) -> PyResult<R> {
        self.exchange(py, request, |bytes| match Reply::decode(bytes) {
            Ok(Reply::Error(reason)) => {
                Err(Refused::new_err(format!("the simulator refused {name}: {reason}")))
            }
            Ok(reply) => expected(reply).ok_or_else(|| {
                let found = String::from_utf8_lossy(bytes);
                SimulatorError::new_err(format!("expected the reply to {name}, found {found:?}"))
            }),
            Err(error) => Err(SimulatorError::new_err(error.to_string())),
        })?
    }

    fn size(&self, py: Python<'_>) -> PyResult<Option<MazeSize>> {
        match self {
            Self::Process(simulated) => {
                let simulated = simulated.lock_py_attached(py).map_err(poisoned)?;
                Ok(Some(simulated.simulation.maze().size()))
            }
        }
    }
}

/// Converts the error for a lock whose holder panicked.
pub(crate) fn poisoned<T>(_: T) -> PyErr {
    SimulatorError::new_err("an earlier request failed unexpectedly")
}

fn is_ok(reply: Reply<'_>) -> Option<()> {
    (reply == Reply::Ok).then_some(())
}

#[pymethods]
impl Connection {
    fn request<'py>(&self, py: Python<'py>, request: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        self.link.exchange(py, request, |reply| PyBytes::new(py, reply))
    }

    fn ping(&self, py: Python<'_>) -> PyResult<()> {
        self.link.ask(py, "ping", b"ping", |reply| (reply == Reply::Pong).then_some(()))
    }

    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.link.ask(py, "reset", b"reset", is_ok)
    }

    fn walls(
        &self,
        py: Python<'_>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
    ) -> PyResult<Py<PyAny>> {
        let mut request = [0; 4];
        Request::Walls(pose(x, y, heading)?).encode(&mut request).map_err(value_error)?;
        let around: WallsAround = self.link.ask(py, "W", &request, |reply| match reply {
            Reply::Walls(around) => Some(around),
            _ => None,
        })?;
        to_walls(py, around)
    }

    fn state(
        &self,
        py: Python<'_>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
        weights: &Bound<'_, PyAny>,
        walls: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let pose = pose(x, y, heading)?;
        let (weights, walls) = (grid::Bytes::read(weights)?, grid::Bytes::read(walls)?);
        if let Some(size) = self.link.size(py)? {
            weights.check_size(size)?;
        }
        if (weights.width, weights.height) != (walls.width, walls.height) {
            return Err(value_error("weights and walls must have the same shape"));
        }
        let mut request = Vec::with_capacity(6 + 2 * weights.cells.len());
        // The letter F stands for columns from the west, each from the south.
        request.extend([b'S', pose.cell.x, pose.cell.y, pose.heading.letter() as u8, b'F']);
        request.extend(weights.cells);
        request.push(b'F');
        request.extend(walls.cells);
        self.link.ask(py, "S", &request, is_ok)
    }
}
