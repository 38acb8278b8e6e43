//! The class `Client`: a connection to a running simulator.

use std::env;
use std::sync::Arc;
use std::time::Duration;

use mmsim_mouse::ENDPOINT_VARIABLE;
use mmsim_protocol::DEFAULT_PORT;
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict, PyTuple};

use crate::connection::{Backend, PyConnection, Requests};
use crate::error::{Error, SimulatorError, type_error, value_error};
use crate::known::PyKnownMaze;
use crate::socket::Socket;

/// The default timeout in seconds.
const DEFAULT_TIMEOUT: Duration = Duration::from_secs(5);

/// A connection to a simulator. The simulator may be started later.
///
/// Ctrl-C interrupts the wait for a reply.
#[pyclass(extends = PyConnection, frozen, name = "Client", module = "micromouse_sim")]
pub(crate) struct PyClient {
    socket: Arc<Socket>,
    requests: Arc<Requests>,
    /// The function that sends the last annotations of a client that exists when the program ends.
    at_exit: Py<PyCFunction>,
}

/// Sends the last annotations.
impl Drop for PyClient {
    fn drop(&mut self) {
        Python::try_attach(|py| {
            let raised = PyErr::take(py);
            self.requests.end(py);
            let atexit = py.import("atexit");
            let _ = atexit.and_then(|it| it.call_method1("unregister", (&self.at_exit,)));
            if let Some(error) = raised {
                error.restore(py);
            }
        });
    }
}

/// The argument `timeout`, which may be missing.
enum TimeoutArgument {
    Default,
    /// `None` for no limit.
    Given(Option<Duration>),
}

impl<'py> FromPyObject<'_, 'py> for TimeoutArgument {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if value.is_none() {
            return Ok(Self::Given(None));
        }
        let Ok(seconds) = value.extract::<f64>() else {
            return Err(type_error("a timeout in seconds, or None", &value));
        };
        Duration::try_from_secs_f64(seconds)
            .map(|timeout| Self::Given(Some(timeout)))
            .map_err(|_| value_error(format_args!("invalid timeout: {seconds} s")))
    }
}

#[pymethods]
impl PyClient {
    #[new]
    #[pyo3(signature = (endpoint = None, timeout = TimeoutArgument::Default, annotations = None))]
    fn new(
        py: Python<'_>,
        endpoint: Option<String>,
        timeout: TimeoutArgument,
        annotations: Option<bool>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let variable = env::var(ENDPOINT_VARIABLE).ok().filter(|variable| !variable.is_empty());
        let endpoint = endpoint
            .or_else(|| variable.clone())
            .unwrap_or_else(|| format!("tcp://127.0.0.1:{DEFAULT_PORT}"));
        // A mouse of `mmsim run` may also connect to another simulator.
        let is_run = variable.as_ref() == Some(&endpoint);
        let timeout = match timeout {
            TimeoutArgument::Given(timeout) => timeout,
            // `mmsim run` holds replies while the mouse is paused.
            TimeoutArgument::Default if is_run => None,
            TimeoutArgument::Default => Some(DEFAULT_TIMEOUT),
        };
        let annotations = match annotations {
            Some(true) => None,
            None if is_run => Some(true),
            Some(false) | None => Some(false),
        };
        let socket = Arc::new(Socket::connect(endpoint, timeout)?);
        let connection = PyConnection::new(Backend::Socket(Arc::clone(&socket)), annotations);
        let requests = connection.requests();
        let weak = Arc::downgrade(&requests);
        let end = move |arguments: &Bound<'_, PyTuple>, _: Option<&Bound<'_, PyDict>>| {
            weak.upgrade().into_iter().for_each(|requests| requests.end(arguments.py()));
        };
        let at_exit = PyCFunction::new_closure(py, None, None, end)?;
        py.import("atexit")?.call_method1("register", (&at_exit,))?;
        let client = Self { socket, requests, at_exit: at_exit.unbind() };
        Ok(PyClassInitializer::from(connection).add_subclass(client))
    }

    /// The endpoint of the simulator.
    #[getter]
    fn endpoint(&self) -> &str {
        &self.socket.endpoint
    }

    /// Returns the map of a mouse that has not read any walls yet.
    ///
    /// Without arguments, the client asks `mmsim` for the maze with `info`. The reference simulator
    /// does not know `info`, so pass `size=(16, 16)` for its mazes.
    #[pyo3(signature = (size = None, goals = None, start = None))]
    fn unexplored(
        client: PyRef<'_, Self>,
        py: Python<'_>,
        size: Option<&Bound<'_, PyAny>>,
        goals: Option<&Bound<'_, PyAny>>,
        start: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyKnownMaze> {
        if size.is_none() && goals.is_none() && start.is_none() {
            let info = client.as_super().info(py)?;
            let map = info.known_maze().filter(|map| map.size().contains(map.start().cell));
            let map = map.ok_or_else(|| SimulatorError::new_err("invalid reply to info"))?;
            return Ok(PyKnownMaze::from(map));
        }
        PyKnownMaze::new(size, goals, start)
    }

    /// Raises an error, because the states are in the other process.
    #[getter]
    #[allow(clippy::unused_self, reason = "it is a property in Python")]
    fn history(&self) -> PyResult<()> {
        Err(Error::new_err(
            "a client has no history (use a Simulator in this process, or `mmsim --record FOLDER`)",
        ))
    }

    /// Sends the last annotations and closes the connection. A further request uses a new one.
    fn close(client: PyRef<'_, Self>, py: Python<'_>) -> PyResult<()> {
        let sent = client.as_super().send_annotations(py);
        client.requests.drop_annotations();
        client.socket.close();
        sent
    }

    fn __enter__(client: PyRef<'_, Self>) -> PyRef<'_, Self> {
        client
    }

    #[pyo3(signature = (*error))]
    fn __exit__(
        client: PyRef<'_, Self>,
        py: Python<'_>,
        error: &Bound<'_, PyTuple>,
    ) -> PyResult<()> {
        if error.iter().any(|part| part.is_instance_of::<SimulatorError>()) {
            client.requests.drop_annotations();
        }
        let closed = Self::close(client, py);
        // The error that ends the block is the cause.
        if error.iter().all(|part| part.is_none()) { closed } else { Ok(()) }
    }

    fn __repr__(&self) -> String {
        format!("<Client of {}>", self.endpoint())
    }
}
