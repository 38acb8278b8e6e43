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
    /// The endpoint is none.
    pub fn connect(
        endpoint: &str,
        timeout: Option<Duration>,
        on_wait: impl FnMut(Waiting<'_>) + 'a,
    ) -> Result<Self, TransportError> {
        let socket = connect(endpoint).map_err(|error| failed(endpoint, error))?;
        let on_wait = Box::new(on_wait);
        Ok(Self { socket, endpoint: endpoint.into(), timeout, answered: false, on_wait })
    }

    fn receive(&mut self, reply: &mut Vec<u8>) -> Result<(), TransportError> {
        let patience = self.timeout.or(self.answered.then_some(PATIENCE));
        let begun = Instant::now();
        loop {
            let left = patience.map_or(NOTICE, |all| all.saturating_sub(begun.elapsed()));
            // Round up: poll 0 ms would turn the last fraction of a millisecond into a busy loop.
            let wait =
                i64::try_from(left.min(NOTICE).as_micros().div_ceil(1000)).unwrap_or(i64::MAX);
            match self.socket.poll(zmq::POLLIN, wait) {
                Ok(0) => {}
                Ok(_) => break,
                Err(zmq::Error::EINTR) => continue,
                Err(error) => return Err(failed(&self.endpoint, error)),
            }
            let since = begun.elapsed();
            if let Some(after) = patience.filter(|&all| since >= all) {
                let endpoint = self.endpoint.clone();
                return Err(TransportError::NoReply { endpoint, after });
            }
            let Self { endpoint, answered, .. } = self;
            (self.on_wait)(Waiting { endpoint, since, answered: *answered });
        }
        let message = self.socket.recv_msg(0).map_err(|error| failed(&self.endpoint, error))?;
        reply.extend_from_slice(&message);
        self.answered = true;
        Ok(())
    }
}

impl Transport for Zmq<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        reply.clear();
        self.socket.send(request, 0).map_err(|error| failed(&self.endpoint, error))?;
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

fn failed(endpoint: &str, error: zmq::Error) -> TransportError {
    TransportError::Failed { endpoint: endpoint.into(), reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulator_that_is_not_there_is_waited_for_and_given_up() {
        let mut notices = 0;
        let patience = Duration::from_millis(1100);
        let mut transport = Zmq::connect("tcp://127.0.0.1:1", Some(patience), |waiting| {
            assert!(!waiting.answered);
            notices += 1;
        })
        .unwrap();
        let error = transport.exchange(b"ping", &mut Vec::new()).unwrap_err();
        assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        drop(transport);
        assert_eq!(notices, 1);
    }

    #[test]
    fn an_endpoint_that_is_none_is_an_error() {
        let error = Zmq::connect("127.0.0.1:6574", None, |_| {}).err().unwrap().to_string();
        assert!(error.starts_with("cannot reach 127.0.0.1:6574: "), "{error}");
    }
}
