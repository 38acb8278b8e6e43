//! The address to which a mouse connects: it forwards each request to the simulator, and holds the
//! reply to a state until the mouse may take its next step.

use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_maze::{CellSet, MazeSize};
use mmsim_protocol::{Annotation, AnnotationWriter, ERROR_PREFIX, MAX_NAME_BYTES, StateMessage};
use mmsim_server::{Monitor, MonitorError};
use mmsim_viewer::MouseControl;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, RepServer, Service};
use tracing::error;

/// What the mouse has reported since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    pub(crate) states: u64,
    pub(crate) is_goal_reached: bool,
}

/// An endpoint for the mouse, which is served by a separate thread until the process exits.
pub(crate) struct Gateway {
    address: String,
    simulator: Simulator,
    tracker: Arc<Mutex<Tracker>>,
}

/// The simulator, as a client of the gateway sees it.
#[derive(Clone)]
struct Simulator {
    monitor: Monitor,
    control: Arc<MouseControl>,
}

/// The progress of the mouse, and the maze in which it is measured.
#[derive(Default)]
struct Tracker {
    progress: Progress,
    maze: Option<(MazeSize, CellSet)>,
}

impl Gateway {
    /// Serves clients of `listener`.
    pub(crate) fn start(
        listener: TcpListener,
        monitor: Monitor,
        control: Arc<MouseControl>,
    ) -> io::Result<Self> {
        let mut server = RepServer::new(listener)?;
        let address = format!("tcp://{}", server.local_address()?);
        let (simulator, tracker) = (Simulator { monitor, control }, Arc::default());
        let mut forwarder =
            Forwarder { simulator: simulator.clone(), tracker: Arc::clone(&tracker) };
        thread::Builder::new().name("gateway".into()).spawn(move || {
            if let Err(cause) = server.run(&mut forwarder, || false) {
                error!("cannot receive requests from the mouse: {cause}");
            }
        })?;
        Ok(Self { address, simulator, tracker })
    }

    /// Returns the address for the mouse, such as `tcp://127.0.0.1:6574`.
    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// Resets the simulator for a run of the mouse.
    pub(crate) fn begin_run(&self) -> Result<(), MonitorError> {
        let monitor = &self.simulator.monitor;
        if monitor.status().states > 0 {
            monitor.answer(None, b"reset", 1)?;
        }
        self.simulator.name_mouse()?;
        let maze = monitor.served()?.maze;
        let (progress, maze) = (Progress::default(), Some((maze.size(), *maze.goals())));
        *lock(&self.tracker) = Tracker { progress, maze };
        Ok(())
    }

    pub(crate) fn progress(&self) -> Progress {
        lock(&self.tracker).progress
    }
}

impl Simulator {
    /// Adds the name of the mouse to its next state. The mouse may send another name.
    fn name_mouse(&self) -> Result<(), MonitorError> {
        let mut buffer = [0; MAX_NAME_BYTES + 16];
        let mut writer = AnnotationWriter::new(&mut buffer);
        let name = self.control.own().map_or("", |own| &own.name);
        if writer.push(Annotation::Mouse(name)).is_ok()
            && let Some(request) = writer.finish()
        {
            self.monitor.answer(None, request, 1)?;
        }
        Ok(())
    }
}

impl Tracker {
    /// Updates the progress after an accepted request.
    fn observe(&mut self, request: &[u8]) {
        let Some((size, goals)) = &self.maze else { return };
        if request == b"reset" {
            self.progress = Progress::default();
        } else if let Ok(pose) = StateMessage::new(request, *size).and_then(|state| state.pose()) {
            self.progress.states += 1;
            self.progress.is_goal_reached |= goals.contains(pose.cell);
        }
    }
}

fn lock(tracker: &Mutex<Tracker>) -> MutexGuard<'_, Tracker> {
    tracker.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Forwards the requests of the mouse. Other clients may use the address between two runs.
struct Forwarder {
    simulator: Simulator,
    tracker: Arc<Mutex<Tracker>>,
}

impl Forwarder {
    /// Forwards a request, and waits after a state until the mouse may take its next step.
    fn forward(
        &self,
        client: ClientId,
        request: &[u8],
        frames: usize,
    ) -> Result<(Vec<u8>, bool), String> {
        let Simulator { monitor, control } = &self.simulator;
        if control.wait_for_stop(Duration::ZERO).is_some() {
            // The process of the mouse is about to be killed.
            return Err("the mouse was stopped".into());
        }
        let is_own = control.is_own_running();
        let client = (!is_own).then_some(client);
        let (reply, is_activity) =
            monitor.answer(client, request, frames).map_err(|error| error.to_string())?;
        if reply == b"ok" {
            lock(&self.tracker).observe(request);
            if is_own && request == b"reset" {
                self.simulator.name_mouse().map_err(|error| error.to_string())?;
            } else if is_own && request.first() == Some(&b'S') {
                control.throttle().wait();
            }
        }
        Ok((reply, is_activity))
    }
}

impl Service for Forwarder {
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> bool {
        let (answer, is_activity) = self
            .forward(client, request, frames)
            .unwrap_or_else(|reason| (format!("{ERROR_PREFIX}{reason}").into_bytes(), false));
        *reply = answer;
        is_activity
    }

    fn disconnected(&mut self, client: ClientId) {
        // A server that has stopped has no clients.
        let _ = self.simulator.monitor.disconnect(client);
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
    }
}
