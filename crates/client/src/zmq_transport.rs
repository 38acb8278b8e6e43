//! Requests over a ZeroMQ REQ socket.

use std::time::{Duration, Instant};

use mmsim_zmtp::connection::DisconnectReason;
use mmsim_zmtp::{EndpointError, ReqClient};

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
pub struct Zmq<'a> {
    client: ReqClient,
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
        let failed = |reason: String| TransportError::Failed { endpoint: endpoint.into(), reason };
        let address = endpoint.parse().map_err(|error: EndpointError| failed(error.to_string()))?;
        let client = ReqClient::new(address).map_err(|error| failed(error.to_string()))?;
        let on_wait = Box::new(on_wait);
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
        self.client.send(request);
        let timeout = self.timeout.limit(self.answered);
        let (start, mut notices) = (Instant::now(), 0);
        let frames = loop {
            let left = timeout.map(|timeout| timeout.saturating_sub(start.elapsed()));
            let wait = left.unwrap_or(NOTICE_INTERVAL).min(NOTICE_INTERVAL);
            let received = self.client.receive(reply, wait);
            if let Some(frames) = received.map_err(|reason| self.disconnected(&reason))? {
                break frames;
            }
            let Self { endpoint, answered, .. } = self;
            let elapsed = start.elapsed();
            if let Some(after) = timeout.filter(|&timeout| elapsed >= timeout) {
                return Err(TransportError::NoReply { endpoint: endpoint.clone(), after });
            }
            notices += 1;
            (self.on_wait)(Waiting { endpoint, elapsed, notices, answered: *answered });
        };
        if frames != 1 {
            return Err(TransportError::Frames { endpoint: self.endpoint.clone(), found: frames });
        }
        self.answered = true;
        Ok(())
    }

    fn disconnected(&self, reason: &DisconnectReason) -> TransportError {
        let (endpoint, reason) = (self.endpoint.clone(), reason.to_string());
        TransportError::Disconnected { endpoint, reason }
    }
}

impl Transport for Zmq<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        self.exchange_frames(&[request], reply)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    #[test]
    fn a_limit_may_depend_on_earlier_replies() {
        let limits = |timeout: Timeout| [false, true].map(|answered| timeout.limit(answered));
        assert_eq!(limits(Timeout::default()), [None, Some(DEFAULT_LIMIT)]);
        let limit = Duration::from_secs(3);
        assert_eq!(limits(Timeout::After(limit)), [Some(limit); 2]);
        assert_eq!(limits(Timeout::Never), [None; 2]);
    }

    #[test]
    fn waits_for_a_missing_simulator_until_the_timeout() {
        let (mut notices, timeout) = (Vec::new(), Timeout::After(Duration::from_millis(2500)));
        let mut transport = Zmq::connect("tcp://127.0.0.1:1", timeout, |waiting| {
            assert!(!waiting.answered);
            notices.push(waiting.notices);
        })
        .unwrap();
        let error = transport.exchange(b"ping", &mut Vec::new()).unwrap_err();
        assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        drop(transport);
        assert_eq!(notices[0], 1);
    }

    #[cfg(not(windows))]
    #[test]
    fn a_request_after_a_timeout_succeeds() {
        let simulator = zmq::Context::new().socket(zmq::REP).unwrap();
        simulator.set_rcvtimeo(60_000).unwrap();
        simulator.bind("tcp://127.0.0.1:*").unwrap();
        let endpoint = simulator.get_last_endpoint().unwrap().unwrap();
        let timeout = Timeout::After(Duration::from_millis(300));
        let mut transport = Zmq::connect(&endpoint, timeout, |_| {}).unwrap();
        let mut reply = Vec::new();
        let error = transport.exchange(b"slow", &mut reply).unwrap_err();
        assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        let answering = thread::spawn(move || {
            for expected in [&b"slow"[..], b"ping"] {
                assert_eq!(simulator.recv_bytes(0).unwrap(), expected);
                simulator.send(expected, 0).unwrap();
            }
        });
        transport.timeout = Timeout::After(Duration::from_secs(60));
        transport.exchange(b"ping", &mut reply).unwrap();
        assert_eq!(reply, b"ping", "not the late reply");
        answering.join().unwrap();
    }

    #[test]
    fn an_invalid_endpoint_is_an_error() {
        let error =
            Zmq::connect("127.0.0.1:6574", Timeout::Default, |_| {}).err().unwrap().to_string();
        assert!(error.starts_with("cannot reach 127.0.0.1:6574: "), "{error}");
        for port in ["99999", "0", "http", "127.0.0.1"] {
            let endpoint = format!("tcp://host:{port}");
            let error = Zmq::connect(&endpoint, Timeout::Default, |_| {}).err().unwrap();
            assert!(error.to_string().contains("expected a port from 1 to 65535"), "{error}");
        }
        let error = Zmq::connect("ipc:///tmp/maze", Timeout::Default, |_| {}).err().unwrap();
        assert!(error.to_string().contains("expected tcp://"), "{error}");
    }

    #[test]
    fn another_protocol_is_an_error() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp://{}", listener.local_addr().unwrap());
        let server = thread::spawn(move || {
            let mut stream = listener.accept().unwrap().0;
            stream.write_all(b"HTTP/1.1 400 Bad Request\r\n").unwrap();
            // Waits until the client closes the connection.
            let _ = stream.read_to_end(&mut Vec::new());
        });
        let mut transport = Zmq::connect(&endpoint, Timeout::Never, |_| {}).unwrap();
        let error = transport.exchange(b"ping", &mut Vec::new()).unwrap_err().to_string();
        let reason = "expected a ZMTP greeting, found other bytes";
        assert_eq!(error, format!("no reply from {endpoint}: {reason}"));
        server.join().unwrap();
    }
}
