//! Requests over a ZeroMQ REQ socket, of `mmsim-zmtp` or of libzmq.

use std::time::{Duration, Instant};

use mmsim_zmtp::{EndpointError, ReqClient};

#[cfg(feature = "libzmq")]
use crate::libzmq::LibzmqClient;
use crate::transport::{Transport, TransportError};

/// The time between two calls of `on_wait`.
const NOTICE_INTERVAL: Duration = Duration::from_secs(1);

/// The default limit for a simulator that has replied before.
const DEFAULT_LIMIT: Duration = Duration::from_secs(10);

/// The time limit for replies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timeout {
    /// No limit for the first reply, because the simulator may start later, and ten seconds for
    /// each later reply.
    #[default]
    Default,
    /// This limit for each reply.
    After(Duration),
    /// No limit. Use this for a mouse that `mmsim run` starts, because the simulator holds its
    /// replies while the mouse is paused.
    Never,
}

impl Timeout {
    /// Returns the limit for a reply of a simulator that has or has not replied before.
    fn limit(self, answered: bool) -> Option<Duration> {
        match self {
            Self::Default => answered.then_some(DEFAULT_LIMIT),
            Self::After(limit) => Some(limit),
            Self::Never => None,
        }
    }
}

/// A ZeroMQ REQ socket that connects to a simulator.
///
/// After a timeout, the next request uses a new connection, so a late reply is never taken for the
/// reply to another request. No request is sent twice: if the connection ends before the reply
/// arrives, the request fails.
pub struct Zmq<'a> {
    client: Box<dyn Client>,
    endpoint: String,
    timeout: Timeout,
    answered: bool,
    on_wait: Box<dyn FnMut(Waiting<'_>) + 'a>,
}

/// A notice that the simulator has not replied yet.
#[derive(Clone, Copy, Debug)]
pub struct Waiting<'a> {
    /// The endpoint of the simulator.
    pub endpoint: &'a str,
    /// The time since the request was sent.
    pub elapsed: Duration,
    /// The number of notices since the request was sent, including this one.
    pub notices: u32,
    /// True if the simulator has replied to an earlier request.
    pub answered: bool,
}

/// A socket that keeps at most one request. Errors are reasons for error messages.
pub(crate) trait Client {
    /// Sends a request. If an earlier request has no reply yet, uses a new connection.
    fn send(&mut self, frames: &[&[u8]]) -> Result<(), String>;

    /// Waits for the reply, for at most `wait`. Replaces the contents of `reply` with the last frame
    /// of the reply, and returns the number of its frames, or `None` if it has not arrived in time.
    fn receive(&mut self, reply: &mut Vec<u8>, wait: Duration) -> Result<Option<usize>, String>;
}

impl Client for ReqClient {
    fn send(&mut self, frames: &[&[u8]]) -> Result<(), String> {
        Self::send(self, frames);
        Ok(())
    }

    fn receive(&mut self, reply: &mut Vec<u8>, wait: Duration) -> Result<Option<usize>, String> {
        Self::receive(self, reply, wait).map_err(|reason| reason.to_string())
    }
}

impl<'a> Zmq<'a> {
    /// Connects to a simulator at `endpoint`, such as `tcp://127.0.0.1:6574`. The simulator may be
    /// started later.
    ///
    /// A request fails if there is no reply within `timeout`. While a request waits for its reply,
    /// `on_wait` is called once a second.
    ///
    /// # Errors
    /// Returns an error if `endpoint` is not a valid endpoint of the transport TCP.
    pub fn connect(
        endpoint: &str,
        timeout: Timeout,
        on_wait: impl FnMut(Waiting<'_>) + 'a,
    ) -> Result<Self, TransportError> {
        let client = endpoint
            .parse()
            .map_err(|error: EndpointError| error.to_string())
            .and_then(|address| ReqClient::new(address).map_err(|error| error.to_string()));
        Self::new(client, endpoint, timeout, on_wait)
    }

    /// Like [`connect`](Self::connect), but with a socket of libzmq, which also supports endpoints
    /// such as `ipc:///tmp/maze`.
    ///
    /// libzmq does not recognize a server that speaks another protocol than that of ZeroMQ, so
    /// requests to such a server end with the timeout.
    ///
    /// # Errors
    /// Returns an error if `endpoint` is not a valid endpoint of the transports TCP and IPC.
    #[cfg(feature = "libzmq")]
    pub fn connect_with_libzmq(
        endpoint: &str,
        timeout: Timeout,
        on_wait: impl FnMut(Waiting<'_>) + 'a,
    ) -> Result<Self, TransportError> {
        Self::new(LibzmqClient::new(endpoint), endpoint, timeout, on_wait)
    }

    fn new(
        client: Result<impl Client + 'static, String>,
        endpoint: &str,
        timeout: Timeout,
        on_wait: impl FnMut(Waiting<'_>) + 'a,
    ) -> Result<Self, TransportError> {
        let failed = |reason| TransportError::Failed { endpoint: endpoint.into(), reason };
        let (client, on_wait) = (Box::new(client.map_err(failed)?), Box::new(on_wait));
        Ok(Self { client, endpoint: endpoint.into(), timeout, answered: false, on_wait })
    }

    /// Like [`exchange`](Transport::exchange), but sends a request of several frames. Valid requests
    /// have one frame, so this method only serves to test servers.
    ///
    /// # Errors
    /// Returns an error if there is no reply.
    pub fn exchange_frames(
        &mut self,
        request: &[&[u8]],
        reply: &mut Vec<u8>,
    ) -> Result<(), TransportError> {
        let Self { client, endpoint, timeout, answered, on_wait } = self;
        let named = || endpoint.clone();
        let failed = |reason| TransportError::Failed { endpoint: named(), reason };
        let disconnected = |reason| TransportError::Disconnected { endpoint: named(), reason };
        client.send(request).map_err(failed)?;
        let timeout = timeout.limit(*answered);
        let (start, mut notices) = (Instant::now(), 0);
        let frames = loop {
            let left = timeout.map(|timeout| timeout.saturating_sub(start.elapsed()));
            let wait = left.unwrap_or(NOTICE_INTERVAL).min(NOTICE_INTERVAL);
            if let Some(frames) = client.receive(reply, wait).map_err(disconnected)? {
                break frames;
            }
            let elapsed = start.elapsed();
            if let Some(after) = timeout.filter(|&timeout| elapsed >= timeout) {
                return Err(TransportError::NoReply { endpoint: named(), after });
            }
            notices += 1;
            on_wait(Waiting { endpoint, elapsed, notices, answered: *answered });
        };
        if frames != 1 {
            return Err(TransportError::Frames { endpoint: named(), found: frames });
        }
        *answered = true;
        Ok(())
    }
}

impl Transport for Zmq<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.exchange_frames(&[request], reply)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_may_depend_on_earlier_replies() {
        let limits = |timeout: Timeout| [false, true].map(|answered| timeout.limit(answered));
        assert_eq!(limits(Timeout::default()), [None, Some(DEFAULT_LIMIT)]);
        let limit = Duration::from_secs(3);
        assert_eq!(limits(Timeout::After(limit)), [Some(limit); 2]);
        assert_eq!(limits(Timeout::Never), [None; 2]);
    }
}
