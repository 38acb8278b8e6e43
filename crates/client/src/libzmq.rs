//! A REQ socket of libzmq that behaves like [`ReqClient`](mmsim_zmtp::ReqClient).

use std::mem;
use std::time::{Duration, Instant};

use mmsim_zmtp::{ClientConfig, Endpoint, EndpointError};
use zmq::SocketEvent;

use crate::zmq_transport::Client;

/// The endpoint at which a socket reports its events.
const EVENTS_ENDPOINT: &str = "inproc://events";

/// A libzmq socket that connects to one server and keeps at most one request.
pub(crate) struct LibzmqClient {
    endpoint: String,
    /// `None` after an error.
    link: Option<Link>,
    /// True if a request has no reply yet.
    is_waiting: bool,
}

/// A REQ socket and its events. Both sockets belong to a context of their own, which ends with them.
struct Link {
    socket: zmq::Socket,
    events: zmq::Socket,
    state: LinkState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum LinkState {
    /// The handshake is incomplete.
    Connecting,
    /// The server or the network has ended the handshake. libzmq connects again.
    Retrying,
    /// The handshake is complete.
    Connected,
    /// The connection has ended. libzmq might connect again and lose the request.
    Lost,
    /// The server has violated the protocol in the handshake. libzmq does not connect again.
    Refused,
}

impl LibzmqClient {
    /// Creates a client, which connects in the background. An endpoint is `tcp://HOST:PORT` or
    /// `ipc://PATH`.
    ///
    /// # Errors
    /// Returns the reason if the endpoint is invalid or the operating system has no resources left.
    pub(crate) fn new(endpoint: &str) -> Result<Self, String> {
        if !endpoint.starts_with("ipc://") {
            endpoint.parse::<Endpoint>().map_err(|error: EndpointError| error.to_string())?;
        }
        let link = Link::open(endpoint).map_err(|error| error.to_string())?;
        Ok(Self { endpoint: endpoint.into(), link: Some(link), is_waiting: false })
    }

    /// Returns the link for the next request, which may be a new one.
    fn usable_link(&mut self, is_waiting: bool) -> zmq::Result<&Link> {
        let mut link = self.link.take().filter(|_| !is_waiting);
        if let Some(link) = &mut link {
            link.read_events()?;
        }
        let is_usable = |link: &Link| !matches!(link.state, LinkState::Lost | LinkState::Refused);
        let link = match link.filter(is_usable) {
            Some(link) => link,
            None => Link::open(&self.endpoint)?,
        };
        Ok(self.link.insert(link))
    }

    fn send_once(&mut self, frames: &[&[u8]], is_waiting: bool) -> zmq::Result<()> {
        let frames = if frames.is_empty() { &[&[][..]] } else { frames };
        self.usable_link(is_waiting)?.socket.send_multipart(frames, zmq::DONTWAIT)
    }
}

impl Client for LibzmqClient {
    fn send(&mut self, frames: &[&[u8]]) -> Result<(), String> {
        let is_waiting = mem::replace(&mut self.is_waiting, true);
        let mut sent = self.send_once(frames, is_waiting);
        if sent == Err(zmq::Error::EAGAIN) {
            // The connection ended after its events were read, so the request has not left.
            self.link = None;
            sent = self.send_once(frames, false);
        }
        sent.map_err(|error| error.to_string())
    }

    fn receive(&mut self, reply: &mut Vec<u8>, wait: Duration) -> Result<Option<usize>, String> {
        let Some(link) = &mut self.link else { return Err("not connected".into()) };
        let received = link.receive(reply, wait).unwrap_or_else(|error| Err(error.to_string()));
        match received {
            Ok(frames) => self.is_waiting = frames.is_none(),
            Err(_) => self.link = None,
        }
        received
    }
}

impl Link {
    fn open(endpoint: &str) -> zmq::Result<Self> {
        let context = zmq::Context::new();
        let (socket, events) = (context.socket(zmq::REQ)?, context.socket(zmq::PAIR)?);
        // With IPv6, libzmq tries only the IPv6 address of a name that has both.
        socket.set_ipv6(endpoint.contains('['))?;
        socket.set_linger(0)?;
        let ClientConfig { max_reply_bytes, handshake_time, keepalive, .. } = ClientConfig::DEFAULT;
        socket.set_maxmsgsize(i64::try_from(max_reply_bytes).unwrap_or(i64::MAX))?;
        socket.set_handshake_ivl(i32::try_from(handshake_time.as_millis()).unwrap_or(i32::MAX))?;
        socket.set_tcp_keepalive(1)?;
        socket.set_tcp_keepalive_idle(i32::try_from(keepalive.as_secs()).unwrap_or(i32::MAX))?;
        let reported = [
            SocketEvent::HANDSHAKE_SUCCEEDED,
            SocketEvent::HANDSHAKE_FAILED_NO_DETAIL,
            SocketEvent::DISCONNECTED,
        ];
        let reported = reported.iter().map(|event| i32::from(event.to_raw())).sum();
        socket.monitor(EVENTS_ENDPOINT, reported)?;
        events.connect(EVENTS_ENDPOINT)?;
        socket.connect(endpoint)?;
        Ok(Self { socket, events, state: LinkState::Connecting })
    }

    /// Waits for a reply. The outer result is an error of libzmq, the inner one the end of the
    /// connection.
    fn receive(
        &mut self,
        reply: &mut Vec<u8>,
        wait: Duration,
    ) -> zmq::Result<Result<Option<usize>, String>> {
        let deadline = Instant::now().checked_add(wait);
        loop {
            let left = deadline.map(|end| end.saturating_duration_since(Instant::now()));
            if self.wait(left)? {
                return self.read_reply(reply).map(|frames| Ok(Some(frames)));
            }
            self.read_events()?;
            let reason = match self.state {
                // The reply may have arrived just before the connection ended.
                LinkState::Lost if self.wait(Some(Duration::ZERO))? => continue,
                LinkState::Lost => "closed by the peer",
                LinkState::Refused => {
                    "expected a REP or ROUTER socket without security, found another peer"
                }
                _ if left == Some(Duration::ZERO) => return Ok(Ok(None)),
                _ => continue,
            };
            return Ok(Err(reason.into()));
        }
    }

    /// Waits for a reply or an event. Returns true if there is a reply.
    fn wait(&self, left: Option<Duration>) -> zmq::Result<bool> {
        let milliseconds = left.map(|left| left.as_micros().div_ceil(1000));
        let milliseconds = milliseconds.and_then(|time| i64::try_from(time).ok()).unwrap_or(-1);
        let mut items =
            [self.socket.as_poll_item(zmq::POLLIN), self.events.as_poll_item(zmq::POLLIN)];
        match zmq::poll(&mut items, milliseconds) {
            Err(error) if error != zmq::Error::EINTR => Err(error),
            _ => Ok(items[0].is_readable()),
        }
    }

    fn read_reply(&self, reply: &mut Vec<u8>) -> zmq::Result<usize> {
        let (mut frame, mut frames) = (zmq::Message::new(), 0);
        loop {
            self.socket.recv(&mut frame, zmq::DONTWAIT)?;
            frames += 1;
            if !frame.get_more() {
                reply.clear();
                reply.extend_from_slice(&frame);
                return Ok(frames);
            }
        }
    }

    /// Reads the events that have occurred since the last call.
    fn read_events(&mut self) -> zmq::Result<()> {
        loop {
            let event = match self.events.recv_multipart(zmq::DONTWAIT) {
                Err(zmq::Error::EAGAIN | zmq::Error::EINTR) => return Ok(()),
                event => event?,
            };
            // An event begins with its number.
            let Some(number) = event.first().and_then(|frame| frame.first_chunk()) else {
                continue;
            };
            self.state = match (SocketEvent::from_raw(u16::from_ne_bytes(*number)), self.state) {
                // A new connection does not bring the request back.
                (_, state @ (LinkState::Lost | LinkState::Refused)) => state,
                (SocketEvent::HANDSHAKE_SUCCEEDED, _) => LinkState::Connected,
                (SocketEvent::HANDSHAKE_FAILED_NO_DETAIL, _) => LinkState::Retrying,
                (SocketEvent::DISCONNECTED, LinkState::Connected) => LinkState::Lost,
                (SocketEvent::DISCONNECTED, LinkState::Retrying) => LinkState::Connecting,
                // libzmq reports no event for most violations of the protocol.
                (SocketEvent::DISCONNECTED, LinkState::Connecting) => LinkState::Refused,
                (_, state) => state,
            };
        }
    }
}
