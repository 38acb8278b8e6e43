//! The address to which a mouse connects: it forwards each request to the simulator, and holds the
//! reply to a state until the mouse may take its next step.

use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_maze::{CellSet, MazeSize};
use mmsim_protocol::{ERROR_PREFIX, StateMessage};
use mmsim_server::Monitor;
use mmsim_viewer::MouseControl;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{RepServer, Service};
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
    tracker: Arc<Mutex<Tracker>>,
}

/// The progress of the mouse, and what is needed to determine it.
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
        let tracker = Arc::<Mutex<Tracker>>::default();
        let mut forwarder = Forwarder { monitor, control, tracker: Arc::clone(&tracker) };
        thread::Builder::new().name("gateway".into()).spawn(move || {
            if let Err(cause) = server.run(&mut forwarder, || false) {
                error!("cannot receive requests from the mouse: {cause}");
            }
        })?;
        Ok(Self { address, tracker })
    }

    /// Returns the address for the mouse, such as `tcp://127.0.0.1:6574`.
    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// Begins a run in a maze with this size and goal.
    pub(crate) fn begin(&self, size: MazeSize, goals: CellSet) {
        *lock(&self.tracker) = Tracker { maze: Some((size, goals)), ..Tracker::default() };
    }

    pub(crate) fn progress(&self) -> Progress {
        lock(&self.tracker).progress
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

/// Forwards the requests of the mouse.
struct Forwarder {
    monitor: Monitor,
    control: Arc<MouseControl>,
    tracker: Arc<Mutex<Tracker>>,
}

impl Service for Forwarder {
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool {
        if self.control.wait_for_stop(Duration::ZERO).is_some() {
            // The process of the mouse is about to be killed.
            refuse(reply, "the mouse was stopped");
            return false;
        }
        let is_activity = match self.monitor.answer(request, frames) {
            Ok((answer, is_activity)) => {
                *reply = answer;
                is_activity
            }
            Err(error) => {
                refuse(reply, &error.to_string());
                false
            }
        };
        if reply == b"ok" {
            lock(&self.tracker).observe(request);
            if request.first() == Some(&b'S') && self.control.is_own_running() {
                self.control.throttle().wait();
            }
        }
        is_activity
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        refuse(reply, &reason.to_string());
    }
}

fn refuse(reply: &mut Vec<u8>, reason: &str) {
    *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
}
