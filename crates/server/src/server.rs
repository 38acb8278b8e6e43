//! Serves a simulation over ZeroMQ.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};

use mmsim_protocol::{MAX_ANNOTATIONS_BYTES, MAX_STATE_BYTES};
use mmsim_recording::Recorder;
use mmsim_zmtp::{BindError, RepServer, ServerConfig, listen};

use crate::control::{Control, StopHandle};
use crate::monitor::{Monitor, Query};
use crate::service::SimulationService;
use crate::simulation::Simulation;

/// The limits for the clients of a simulator.
pub const LIMITS: ServerConfig = ServerConfig {
    max_request_bytes: 64 * 1024,
    // No valid request is longer.
    max_kept_bytes: MAX_ANNOTATIONS_BYTES,
    // A process can usually have 1,024 files open.
    max_connections: 1000,
    ..ServerConfig::DEFAULT
};

const _: () = assert!(LIMITS.check().is_ok() && LIMITS.max_kept_bytes >= MAX_STATE_BYTES);

/// A bound REP socket that serves a simulation until it is stopped.
#[must_use = "a server does nothing until it runs"]
pub struct Server {
    socket: RepServer,
    address: String,
    is_loopback: bool,
    pub(crate) control: Arc<Control>,
    recorder: Option<Recorder>,
    pub(crate) queries: (Sender<Query>, Receiver<Query>),
}

/// The error that stopped a server.
#[derive(Debug, thiserror::Error)]
#[error("cannot receive requests on {address}: {source}")]
pub struct ServeError {
    /// The address that the server listened on.
    pub address: String,
    /// The error that the operating system reported.
    pub source: io::Error,
}

impl Server {
    /// Listens on `port`, where 0 selects a free port. `host` is a name, an address, or `*` for all
    /// IPv4 addresses of this machine.
    ///
    /// # Errors
    /// Returns an error if the port is in use, the host cannot be resolved, its address does not
    /// belong to this machine, or the operating system reports another error.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let listener = listen(host, port)?;
        let failed = |source| BindError::Listen { host: host.into(), port, source };
        let socket = RepServer::with_config(listener, LIMITS).map_err(failed)?;
        let address = socket.local_address().map_err(failed)?;
        let control = Arc::new(Control::new(socket.waker()));
        Ok(Self {
            socket,
            address: format!("tcp://{address}"),
            is_loopback: address.ip().to_canonical().is_loopback(),
            control,
            recorder: None,
            queries: mpsc::channel(),
        })
    }

    /// Returns the address that clients connect to, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Records each run, from reset to reset, in a file of its own. The server refuses states that
    /// cannot be recorded.
    pub fn with_recorder(mut self, recorder: impl Into<Option<Recorder>>) -> Self {
        self.recorder = recorder.into();
        self
    }

    /// Returns true if only programs on this machine can connect.
    pub fn is_loopback(&self) -> bool {
        self.is_loopback
    }

    /// Returns a handle that stops the server from another thread.
    pub fn stop_handle(&self) -> StopHandle {
        StopHandle(Arc::clone(&self.control))
    }

    /// Returns a monitor, which reads the simulation from other threads.
    pub fn monitor(&self) -> Monitor {
        Monitor { queries: self.queries.0.clone(), control: Arc::clone(&self.control) }
    }

    /// Serves the simulation on a background thread.
    pub fn spawn(self, mut simulation: Simulation) -> Background {
        let (address, stop) = (self.address().to_string(), self.stop_handle());
        let thread = thread::spawn(move || self.run(&mut simulation).map(|()| simulation));
        Background { address, stop, thread }
    }

    /// Serves the simulation until the server is stopped. Every request gets exactly one reply, and
    /// no request stops the server.
    ///
    /// # Errors
    /// Returns an error if polling the connections fails.
    pub fn run(mut self, simulation: &mut Simulation) -> Result<(), ServeError> {
        let (recorder, queries, control) = (self.recorder.take(), &self.queries.1, &*self.control);
        let mut service = SimulationService::new(simulation, recorder, queries, control);
        let result = self.socket.run(&mut service, || control.is_stopping());
        service.finish();
        result.map_err(|source| ServeError { address: self.address.clone(), source })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.control.set_ended();
    }
}

/// A server on a background thread, which runs until it is stopped or the process ends.
///
/// ```
/// use mmsim_server::{Server, Simulation};
/// let maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let server = Server::bind("127.0.0.1", 0)?.spawn(Simulation::new("small", maze));
/// println!("listening on {}", server.address());
/// let simulation = server.stop()?;
/// assert!(simulation.history().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Background {
    address: String,
    stop: StopHandle,
    thread: JoinHandle<Result<Simulation, ServeError>>,
}

impl Background {
    /// Returns the address for clients, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Stops the server and returns the simulation with its history.
    ///
    /// # Errors
    /// Returns an error if the server has already failed.
    ///
    /// # Panics
    /// Panics if the server's thread has panicked, which is a bug in this crate.
    pub fn stop(self) -> Result<Simulation, ServeError> {
        self.stop.stop();
        // Propagates a panic of the server's thread.
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}
