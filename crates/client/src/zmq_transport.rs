//! Requests over a ZeroMQ REQ socket.

use std::time::{Duration, Instant};

use crate::{Transport, TransportError};

/// How long a reply may take before the one who waits is told, and between two such notices.
const NOTICE: Duration = Duration::from_secs(1);

/// How long a simulator that has answered once may take for a reply, unless told otherwise.
const PATIENCE: Duration = Duration::from_secs(10);

/// A ZeroMQ REQ socket, connected to a simulator that may not be there yet.
pub struct Zmq<'a> {
    socket: zmq::Socket,
    endpoint: String,
    timeout: Option<Duration>,
    answered: bool,
    on_wait: Box<dyn FnMut(Waiting<'_>) + 'a>,
}

/// What there is to say while no reply comes.
#[derive(Clone, Copy, Debug)]
pub struct Waiting<'a> {
    /// Where the simulator should be.
    pub endpoint: &'a str,
    /// How long we have waited for this reply.
    pub since: Duration,
    /// How often this has been said of this reply, this time included.
    pub times: u32,
    /// Whether the simulator has answered an earlier request.
    pub answered: bool,
}

impl<'a> Zmq<'a> {
    /// Connects to a simulator at `endpoint`, such as `tcp://127.0.0.1:6574`. It may start later.
    ///
    /// Each reply may take as long as `timeout`. Without one, the first may take for ever, and
    /// each after it ten seconds. `on_wait` is called once a second while a reply is waited for.
    ///
    /// # Errors
    /// `endpoint` is not one of ZeroMQ's endpoints.
    pub fn connect(
        endpoint: &str,
        timeout: Option<Duration>,
        on_wait: impl FnMut(Waiting<'_>) + 'a,
    ) -> Result<Self, TransportError> {
        // ZeroMQ would wait for ever for a port that cannot be.
        if let Some(port) = endpoint.strip_prefix("tcp://").and_then(|rest| rest.rsplit(':').next())
            && !port.parse::<u16>().is_ok_and(|port| port > 0)
        {
            let found = format!("expected a port from 1 to 65535, found {port:?}");
            return Err(failed(endpoint, &found));
        }
        let socket = connect(endpoint).map_err(|error| failed(endpoint, &error))?;
        let on_wait = Box::new(on_wait);
        Ok(Self { socket, endpoint: endpoint.into(), timeout, answered: false, on_wait })
    }

    fn receive(&mut self, reply: &mut Vec<u8>) -> Result<(), TransportError> {
        let patience = self.timeout.or(self.answered.then_some(PATIENCE));
        let (begun, mut times) = (Instant::now(), 0);
        loop {
            let left = patience.map_or(NOTICE, |all| all.saturating_sub(begun.elapsed()));
            // Round up: poll 0 ms would turn the last fraction of a millisecond into a busy loop.
            let wait =
                i64::try_from(left.min(NOTICE).as_micros().div_ceil(1000)).unwrap_or(i64::MAX);
            match self.socket.poll(zmq::POLLIN, wait) {
                Ok(0) => {}
                Ok(_) => break,
                Err(zmq::Error::EINTR) => continue,
                Err(error) => return Err(failed(&self.endpoint, &error)),
            }
            let since = begun.elapsed();
            if let Some(after) = patience.filter(|&all| since >= all) {
                let endpoint = self.endpoint.clone();
                // This socket would wait on for the reply that did not come.
                self.socket = connect(&endpoint).map_err(|error| failed(&endpoint, &error))?;
                return Err(TransportError::NoReply { endpoint, after });
            }
            let Self { endpoint, answered, .. } = self;
            times += 1;
            (self.on_wait)(Waiting { endpoint, since, times, answered: *answered });
        }
        let frames =
            self.socket.recv_multipart(0).map_err(|error| failed(&self.endpoint, &error))?;
        let [frame] = frames.as_slice() else {
            let found = format!("expected a reply of one frame, found {}", frames.len());
            return Err(failed(&self.endpoint, &found));
        };
        reply.extend_from_slice(frame);
        self.answered = true;
        Ok(())
    }
}

impl Transport for Zmq<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        reply.clear();
        self.socket.send(request, 0).map_err(|error| failed(&self.endpoint, &error))?;
        self.receive(reply)
    }
}

fn connect(endpoint: &str) -> zmq::Result<zmq::Socket> {
    let socket = zmq::Context::new().socket(zmq::REQ)?;
    socket.set_linger(0)?;
    socket.set_ipv6(endpoint.contains('['))?;
    socket.connect(endpoint)?;
    Ok(socket)
}

fn failed(endpoint: &str, reason: &impl ToString) -> TransportError {
    TransportError::Failed { endpoint: endpoint.into(), reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulator_that_is_not_there_is_waited_for_and_given_up() {
        let (mut notices, patience) = (Vec::new(), Duration::from_millis(2500));
        let mut transport = Zmq::connect("tcp://127.0.0.1:1", Some(patience), |waiting| {
            assert!(!waiting.answered);
            notices.push(waiting.times);
        })
        .unwrap();
        let error = transport.exchange(b"ping", &mut Vec::new()).unwrap_err();
        assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        drop(transport);
        assert_eq!(notices[0], 1);
    }

    #[test]
    fn after_a_reply_that_did_not_come_the_next_request_is_served() {
        let simulator = zmq::Context::new().socket(zmq::REP).unwrap();
        simulator.set_rcvtimeo(60_000).unwrap();
        simulator.bind("tcp://127.0.0.1:*").unwrap();
        let endpoint = simulator.get_last_endpoint().unwrap().unwrap();
        let patience = Some(Duration::from_millis(300));
        let mut transport = Zmq::connect(&endpoint, patience, |_| {}).unwrap();
        let mut reply = Vec::new();
        let error = transport.exchange(b"slow", &mut reply).unwrap_err();
        assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        let answering = std::thread::spawn(move || {
            for expected in [&b"slow"[..], b"ping"] {
                assert_eq!(simulator.recv_bytes(0).unwrap(), expected);
                simulator.send(expected, 0).unwrap();
            }
        });
        transport.timeout = Some(Duration::from_secs(60));
        transport.exchange(b"ping", &mut reply).unwrap();
        assert_eq!(reply, b"ping", "not the late reply");
        answering.join().unwrap();
    }

    #[test]
    fn an_endpoint_that_is_none_is_an_error() {
        let error = Zmq::connect("127.0.0.1:6574", None, |_| {}).err().unwrap().to_string();
        assert!(error.starts_with("cannot reach 127.0.0.1:6574: "), "{error}");
        for port in ["99999", "0", "http", "127.0.0.1"] {
            let error = Zmq::connect(&format!("tcp://host:{port}"), None, |_| {}).err().unwrap();
            assert!(error.to_string().contains("expected a port from 1 to 65535"), "{error}");
        }
    }
}
