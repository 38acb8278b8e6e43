//! An address to which a mouse connects over ZeroMQ.

use std::fmt::Display;
use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use mmsim_protocol::ERROR_PREFIX;
use mmsim_server::LIMITS;
use mmsim_zmtp::{Answer, RepServer, Service, Waker};
use tracing::error;

/// A service for a mouse on a separate thread. Dropping it ends the thread, without waiting.
pub(crate) struct Endpoint {
    address: String,
    is_stopping: Arc<AtomicBool>,
    waker: Waker,
    thread: Option<JoinHandle<()>>,
}

impl Endpoint {
    /// Serves clients of `listener`.
    pub(crate) fn start(
        listener: TcpListener,
        mut service: impl Service + Send + 'static,
    ) -> io::Result<Self> {
        let mut server = RepServer::with_config(listener, LIMITS)?;
        let address = format!("tcp://{}", server.local_address()?);
        let (waker, is_stopping) = (server.waker(), Arc::new(AtomicBool::new(false)));
        let stopping = Arc::clone(&is_stopping);
        let thread = thread::Builder::new().name("endpoint".into()).spawn(move || {
            // The mouse receives no replies if the operating system fails to report events.
            if let Err(cause) = server.run(&mut service, || stopping.load(Ordering::Acquire)) {
                error!("cannot receive requests from the mouse: {cause}");
            }
        })?;
        Ok(Self { address, is_stopping, waker, thread: Some(thread) })
    }

    /// Returns the address for the mouse, such as `tcp://127.0.0.1:6574`.
    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// Returns a handle that wakes the thread.
    pub(crate) fn waker(&self) -> Waker {
        self.waker.clone()
    }

    /// Answers the requests that the mouse has sent before it exited, and ends the thread.
    pub(crate) fn finish(mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A panic has already been reported.
            let _ = thread.join();
        }
    }

    fn stop(&self) {
        self.is_stopping.store(true, Ordering::Release);
        self.waker.wake();
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Writes an error reply to a request, which does not count as activity.
pub(crate) fn refuse(reply: &mut Vec<u8>, reason: impl Display) -> Answer {
    *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
    Answer::Reply { is_activity: false }
}
