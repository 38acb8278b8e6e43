//! The class `Connection`: the requests of a mouse to a simulator.

use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};

use mmsim_client::{RunError, decode_reply};
use mmsim_maze::Cell;
use mmsim_protocol::{Annotation, ERROR_PREFIX, Info, Reply, Request};
use mmsim_recording::{Clock, Times};
use mmsim_server::{Change, Simulation};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;

use crate::annotation::{Pending, printable};
use crate::convert::{coordinate, heading, pose, to_pose, to_walls};
use crate::error::{Refused, SimulatorError, run_error, value_error};
use crate::grid::GridBytes;
use crate::known::{PyKnownMaze, flags};
use crate::socket::Socket;

/// The requests of a mouse to a simulator: the methods of both `Simulator` and `Client`.
///
/// `text`, `colour`, `wall`, `log`, `name`, `restart`, `clear_texts`, `clear_colours` and
/// `clear_walls` annotate the next state. The next call of `state` sends them. If it raises
/// `Refused`, the annotations that the simulator has not accepted are dropped. Those after the last
/// state are sent by `Client.close`, when a `Client` is deleted or the program ends, and by
/// `Simulator.history` and `Simulator.save`.
#[pyclass(subclass, frozen, name = "Connection", module = "micromouse_sim")]
pub(crate) struct PyConnection(Arc<Requests>);

/// The simulator, and the annotations that wait for the next state.
pub(crate) struct Requests {
    backend: Backend,
    pending: Pending,
    /// Whether annotations are sent. Not set if the simulator must be asked whether it knows them.
    annotations: OnceLock<bool>,
}

/// The simulator that answers the requests.
pub(crate) enum Backend {
    /// A simulation in this process. The lock is never held while Python code runs.
    Process(Arc<Mutex<Simulated>>),
    Socket(Arc<Socket>),
}

/// A simulation, the times of its states, its blocked movements, and the buffer of its last reply.
pub(crate) struct Simulated {
    pub(crate) simulation: Simulation,
    pub(crate) times: Times,
    /// The number of states before each movement that a wall blocked.
    pub(crate) crashes: Vec<usize>,
    clock: Clock,
    /// The maximum number of states.
    max_states: usize,
    reply: Vec<u8>,
}

impl Simulated {
    pub(crate) fn new(simulation: Simulation, max_states: Option<u32>) -> Self {
        Self {
            simulation,
            times: Times::new(1),
            crashes: Vec::new(),
            clock: Clock::start(),
            max_states: max_states.map_or(usize::MAX, |states| states as usize),
            reply: Vec::new(),
        }
    }

    /// Answers a request.
    pub(crate) fn handle(&mut self, request: &[u8]) -> &[u8] {
        let max = self.max_states;
        if request.first() == Some(&b'S') && self.simulation.history().len() >= max {
            self.reply.clear();
            let reason = format!("cannot store another state: limit of {max} states reached");
            self.reply.extend(ERROR_PREFIX.bytes().chain(reason.bytes()));
            return &self.reply;
        }
        match self.simulation.handle(request, &mut self.reply) {
            // A missing time only makes the recording less precise.
            Change::State => drop(self.times.push(self.clock.now())),
            Change::Reset => (self.times, self.crashes) = (Times::new(1), Vec::new()),
            Change::Annotations => {}
            Change::Nothing => {
                if Reply::decode(&self.reply).is_ok_and(|reply| reply.is_crash()) {
                    self.crashes.push(self.simulation.history().len());
                }
            }
        }
        &self.reply
    }
}

/// Locks a simulation.
pub(crate) fn lock<'a>(
    simulated: &'a Mutex<Simulated>,
    py: Python<'_>,
) -> PyResult<MutexGuard<'a, Simulated>> {
    simulated
        .lock_py_attached(py)
        .map_err(|_| SimulatorError::new_err("an earlier request has failed unexpectedly"))
}

impl Backend {
    /// Sends a request and passes the reply to `read`.
    fn exchange<R>(
        &self,
        py: Python<'_>,
        request: &[u8],
        read: impl FnOnce(&[u8]) -> R,
    ) -> PyResult<R> {
        match self {
            Self::Process(simulated) => Ok(read(lock(simulated, py)?.handle(request))),
            Self::Socket(socket) => Ok(read(&socket.exchange(py, request)?)),
        }
    }

    /// Sends a request and decodes the reply.
    fn ask<R>(
        &self,
        py: Python<'_>,
        name: &'static str,
        request: &[u8],
        expected: impl FnOnce(Reply<'_>) -> Option<R>,
    ) -> PyResult<R> {
        self.exchange(py, request, |reply| decode_reply(name, reply, expected))?.map_err(run_error)
    }
}

fn is_ok(reply: Reply<'_>) -> Option<()> {
    (reply == Reply::Ok).then_some(())
}

impl PyConnection {
    /// Creates a connection. Without `annotations`, the simulator is asked whether it knows them.
    pub(crate) fn new(backend: Backend, annotations: Option<bool>) -> Self {
        let annotations = annotations.map_or_else(OnceLock::new, OnceLock::from);
        Self(Arc::new(Requests { backend, pending: Pending::default(), annotations }))
    }

    pub(crate) fn requests(&self) -> Arc<Requests> {
        Arc::clone(&self.0)
    }
}

impl Deref for PyConnection {
    type Target = Requests;

    fn deref(&self) -> &Requests {
        &self.0
    }
}

impl Requests {
    /// Asks for the description of the maze.
    pub(crate) fn info(&self, py: Python<'_>) -> PyResult<Info> {
        let json = self.backend.ask(py, "info", b"info", |reply| match reply {
            Reply::Info(json) => Some(String::from(json)),
            _ => None,
        })?;
        serde_json::from_str(&json).map_err(|error| run_error(RunError::Info(error)))
    }

    fn annotates(&self) -> bool {
        self.annotations.get() != Some(&false)
    }

    fn annotate(&self, annotation: Annotation<'_>) -> PyResult<()> {
        if self.annotates() { self.pending.push(annotation) } else { Ok(()) }
    }

    /// Sends the annotations, which belong to the next state.
    pub(crate) fn send_annotations(&self, py: Python<'_>) -> PyResult<()> {
        if self.pending.is_empty() {
            return Ok(());
        }
        if self.annotations.get().is_none() {
            let has_annotations = self.info(py)?.has_annotations();
            self.annotations.get_or_init(|| has_annotations);
        }
        if !self.annotates() {
            self.pending.clear();
        }
        while let Some((request, count)) = self.pending.request() {
            if let Err(error) = self.backend.ask(py, "A", &request, is_ok) {
                if error.is_instance_of::<Refused>(py) {
                    self.pending.clear();
                }
                return Err(error);
            }
            self.pending.remove(count);
        }
        Ok(())
    }

    /// Sends the last annotations of a client that was not closed, unless its last request has failed.
    /// Python reports errors on stderr.
    pub(crate) fn end(&self, py: Python<'_>) {
        if matches!(&self.backend, Backend::Socket(socket) if socket.is_idle())
            && let Err(error) = self.send_annotations(py)
        {
            error.write_unraisable(py, None);
        }
        self.drop_annotations();
    }

    /// Drops the annotations that were not sent.
    pub(crate) fn drop_annotations(&self) {
        self.pending.clear();
    }
}

#[pymethods]
impl PyConnection {
    /// The pose in which a mouse starts. A `Client` asks `mmsim` for it with `info`.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let start = self.info(py)?.start_pose();
        to_pose(py, start.ok_or_else(|| SimulatorError::new_err("invalid start"))?)
    }

    /// Sends the bytes of a request and returns the bytes of the reply.
    fn request<'py>(&self, py: Python<'py>, request: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        self.backend.exchange(py, request, |reply| PyBytes::new(py, reply))
    }

    /// Checks that the simulator replies.
    fn ping(&self, py: Python<'_>) -> PyResult<()> {
        self.backend.ask(py, "ping", b"ping", |reply| (reply == Reply::Pong).then_some(()))
    }

    /// Deletes all states in the simulator and begins a new search.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.pending.clear();
        self.backend.ask(py, "reset", b"reset", is_ok)
    }

    /// Returns the walls around a mouse in this pose.
    fn walls(
        &self,
        py: Python<'_>,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
    ) -> PyResult<Py<PyAny>> {
        let mut request = [0; 4];
        Request::Walls(pose(x, y, heading)?).encode(&mut request).map_err(value_error)?;
        let around = self.backend.ask(py, "W", &request, |reply| match reply {
            Reply::Walls(around) => Some(around),
            _ => None,
        })?;
        to_walls(py, around)
    }

    /// Reports the state of the mouse, for the history, the viewer and recordings.
    ///
    /// `weights` holds a number for each cell, such as the distance to the goal; numbers above 255
    /// are sent as 255. `walls` is the map of the mouse, or the flags of each cell (see
    /// `KnownMaze.walls`).
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
        let weights = GridBytes::read("weights", weights)?;
        let walls = match walls.cast::<PyKnownMaze>() {
            Ok(known) => {
                let known = known.get().lock(py)?;
                let [width, height] =
                    [known.size().width(), known.size().height()].map(usize::from);
                GridBytes { width, height, cells: flags(&known) }
            }
            Err(_) => GridBytes::read("walls", walls)?,
        };
        if let Backend::Process(simulated) = &self.backend {
            weights.check_size(lock(simulated, py)?.simulation.maze().size())?;
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
        self.send_annotations(py)?;
        self.backend.ask(py, "S", &request, is_ok)
    }

    /// Sets the text of a cell, at most 10 characters. An empty text clears it.
    fn text(
        &self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        text: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (cell, text) = (Cell::new(coordinate(x)?, coordinate(y)?), text.str()?);
        self.annotate(Annotation::Text { cell, text: &printable(&text.to_cow()?) })
    }

    /// Sets the colour of a cell, one of the letters kbacgorwyBCAGORVY of mms, or clears it.
    fn colour(
        &self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        letter: Option<&str>,
    ) -> PyResult<()> {
        let cell = Cell::new(coordinate(x)?, coordinate(y)?);
        if self.annotates() { self.pending.colour(cell, letter) } else { Ok(()) }
    }

    /// Declares a wall of a cell, whatever the flags of the states say.
    ///
    /// `state` is "1" for present, "0" for absent, "?" for unknown, or "-" as in the states.
    fn wall(
        &self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        heading: &Bound<'_, PyAny>,
        state: &str,
    ) -> PyResult<()> {
        let cell = Cell::new(coordinate(x)?, coordinate(y)?);
        let heading = self::heading(heading)?;
        if self.annotates() { self.pending.wall(cell, heading, state) } else { Ok(()) }
    }

    /// Clears all texts.
    fn clear_texts(&self) -> PyResult<()> {
        self.annotate(Annotation::ClearTexts)
    }

    /// Clears all colours.
    fn clear_colours(&self) -> PyResult<()> {
        self.annotate(Annotation::ClearColours)
    }

    /// Withdraws all declared walls.
    fn clear_walls(&self) -> PyResult<()> {
        self.annotate(Annotation::ClearWalls)
    }

    /// Logs one or more lines. Lines are cut after 1000 bytes.
    fn log(&self, text: &Bound<'_, PyAny>) -> PyResult<()> {
        let text = text.str()?;
        if self.annotates() { self.pending.log(&text.to_cow()?) } else { Ok(()) }
    }

    /// Names the mouse and its strategy, in at most 100 bytes each.
    #[pyo3(signature = (mouse, strategy = ""))]
    fn name(&self, mouse: &str, strategy: &str) -> PyResult<()> {
        self.annotate(Annotation::Mouse(&printable(mouse)))?;
        self.annotate(Annotation::Strategy(&printable(strategy)))
    }

    /// Reports that the mouse was put back at the start by hand.
    fn restart(&self) -> PyResult<()> {
        self.annotate(Annotation::Restart)
    }
}
