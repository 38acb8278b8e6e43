//! A connection over a socket, whose waits Ctrl-C interrupts.

use std::process;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use mmsim_client::TransportError;
use mmsim_zmtp::{Endpoint, EndpointError, ReqClient};
use pyo3::prelude::*;

use crate::error::{NoReply, run_error};
use crate::signals;

/// A socket that several threads may use.
pub(crate) struct Socket {
    pub(crate) endpoint: String,
    address: Endpoint,
    /// The limit for each reply, or `None` for no limit.
    timeout: Option<Duration>,
    /// The connection that no thread uses, if there is one. A thread that finds none opens another.
    idle: Mutex<Option<Connected>>,
}

struct Connected {
    client: ReqClient,
    /// The process that opened the connection. After a fork, both processes have a copy.
    process: u32,
}

impl Connected {
    fn open(endpoint: &str, address: &Endpoint) -> PyResult<Self> {
        let client = ReqClient::new(address.clone()).map_err(|error| failed(endpoint, &error))?;
        Ok(Self { client, process: process::id() })
    }
}

impl Socket {
    /// Connects to a simulator, which may be started later.
    pub(crate) fn connect(endpoint: String, timeout: Option<Duration>) -> PyResult<Self> {
        let address = endpoint.parse().map_err(|error: EndpointError| failed(&endpoint, &error))?;
        let idle = Mutex::new(Some(Connected::open(&endpoint, &address)?));
        Ok(Self { endpoint, address, timeout, idle })
    }

    /// Sends a request and returns the reply. A signal handler that raises an exception ends the
    /// wait. After an error, the next request uses a new connection.
    pub(crate) fn exchange(&self, py: Python<'_>, request: &[u8]) -> PyResult<Vec<u8>> {
        let mut connected = match self.take_idle() {
            Some(connected) => connected,
            None => Connected::open(&self.endpoint, &self.address)?,
        };
        let client = &mut connected.client;
        client.send(&[request]);
        let (start, mut reply) = (Instant::now(), Vec::new());
        let frames = loop {
            let left = self.timeout.map(|timeout| timeout.saturating_sub(start.elapsed()));
            let wait = left.unwrap_or(signals::INTERVAL).min(signals::INTERVAL);
            let received = py.detach(|| client.receive(&mut reply, wait));
            py.check_signals()?;
            if let Some(frames) = received.map_err(|reason| self.disconnected(&reason))? {
                break frames;
            }
            if let Some(after) = self.timeout.filter(|&timeout| start.elapsed() >= timeout) {
                let error = TransportError::NoReply { endpoint: self.endpoint.clone(), after };
                let hint = "start a simulator with `mmsim`";
                return Err(NoReply::new_err(format!("{error} ({hint})")));
            }
        };
        if frames != 1 {
            let endpoint = self.endpoint.clone();
            return Err(run_error(TransportError::Frames { endpoint, found: frames }.into()));
        }
        *self.idle.lock().unwrap_or_else(PoisonError::into_inner) = Some(connected);
        Ok(reply)
    }

    /// Returns true if there is a connection that no thread uses, so that the last request has not failed.
    pub(crate) fn is_idle(&self) -> bool {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Closes the connection. A further request uses a new one.
    pub(crate) fn close(&self) {
        drop(self.take_idle());
    }

    fn take_idle(&self) -> Option<Connected> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).take();
        idle.filter(|connected| connected.process == process::id())
    }

    fn disconnected(&self, reason: &impl ToString) -> PyErr {
        let (endpoint, reason) = (self.endpoint.clone(), reason.to_string());
        run_error(TransportError::Disconnected { endpoint, reason }.into())
    }
}

fn failed(endpoint: &str, reason: &impl ToString) -> PyErr {
    let (endpoint, reason) = (endpoint.into(), reason.to_string());
    run_error(TransportError::Failed { endpoint, reason }.into())
}
