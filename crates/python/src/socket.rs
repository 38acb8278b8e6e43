//! A connection over a socket, whose waits Ctrl-C interrupts.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use mmsim_client::{Timeout, Transport, TransportError, Zmq};
use pyo3::prelude::*;

use crate::error::{NoReply, SimulatorError};
use crate::signals;

/// A socket in a thread of its own. A thread that waits for Python's signals cannot wait for the
/// socket at the same time.
pub(crate) struct Socket {
    endpoint: String,
    timeout: Timeout,
    /// The idle worker, if there is one. A thread that finds none starts another one.
    idle: Mutex<Option<Worker>>,
}

struct Worker {
    requests: Sender<Vec<u8>>,
    replies: Receiver<Result<Vec<u8>, TransportError>>,
    is_cancelled: Arc<AtomicBool>,
    /// The process of the thread, which a fork does not copy.
    process: u32,
}

impl Socket {
    /// Connects to a simulator, which may be started later.
    pub(crate) fn connect(endpoint: String, timeout: Timeout) -> PyResult<Self> {
        let idle = Some(Worker::start(&endpoint, timeout)?);
        Ok(Self { endpoint, timeout, idle: Mutex::new(idle) })
    }

    pub(crate) fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// Sends a request and returns the reply. A signal handler that raises an exception ends the
    /// wait; the next request uses a new connection.
    pub(crate) fn exchange(&self, py: Python<'_>, request: &[u8]) -> PyResult<Vec<u8>> {
        let mut worker = match self.take_idle() {
            Some(worker) => worker,
            None => Worker::start(&self.endpoint, self.timeout)?,
        };
        let gone = || SimulatorError::new_err("the connection has failed unexpectedly");
        worker.requests.send(request.to_vec()).map_err(|_| gone())?;
        loop {
            let reply;
            (worker, reply) = py.detach(move || {
                let reply = worker.replies.recv_timeout(signals::INTERVAL);
                (worker, reply)
            });
            match reply {
                Ok(reply) => {
                    *self.idle.lock().unwrap_or_else(PoisonError::into_inner) = Some(worker);
                    return reply.map_err(|error| transport_error(&error));
                }
                Err(RecvTimeoutError::Timeout) => py.check_signals()?,
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            }
        }
    }

    /// Closes the connection. A further request uses a new one.
    pub(crate) fn close(&self) {
        drop(self.take_idle());
    }

    fn take_idle(&self) -> Option<Worker> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).take();
        idle.filter(|worker| worker.process == process::id())
    }
}

impl Worker {
    fn start(endpoint: &str, timeout: Timeout) -> PyResult<Self> {
        let (requests, to_send) = mpsc::channel::<Vec<u8>>();
        let (received, replies) = mpsc::channel();
        let is_cancelled = Arc::new(AtomicBool::new(false));
        let (is_over, endpoint) = (Arc::clone(&is_cancelled), endpoint.to_string());
        let (connected, connection) = mpsc::channel();
        let run = move || {
            let on_wait = move |_: mmsim_client::Waiting<'_>| {
                if is_over.load(Ordering::Relaxed) {
                    // Ends this thread without a message: nobody waits for the reply.
                    std::panic::resume_unwind(Box::new(()));
                }
            };
            let mut socket = match Zmq::connect(&endpoint, timeout, on_wait) {
                Ok(socket) => socket,
                Err(error) => return drop(connected.send(Err(error))),
            };
            drop(connected.send(Ok(())));
            for request in to_send {
                let mut reply = Vec::new();
                let result = socket.exchange(&request, &mut reply).map(|()| reply);
                if received.send(result).is_err() {
                    break;
                }
            }
        };
        let thread = thread::Builder::new().name("micromouse-sim client".into());
        let failed = |reason| SimulatorError::new_err(format!("cannot start a thread: {reason}"));
        thread.spawn(run).map_err(|error| failed(error.to_string()))?;
        let connection = connection.recv().map_err(|error| failed(error.to_string()))?;
        connection.map_err(|error| transport_error(&error))?;
        Ok(Self { requests, replies, is_cancelled, process: process::id() })
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }
}

fn transport_error(error: &TransportError) -> PyErr {
    match error {
        TransportError::NoReply { .. } => {
            NoReply::new_err(format!("{error} (start a simulator with `mmsim`)"))
        }
        _ => SimulatorError::new_err(error.to_string()),
    }
}
