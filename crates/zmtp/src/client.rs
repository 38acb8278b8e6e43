//! The client, which connects to a server, sends requests and waits for their replies.

use std::io::{self, ErrorKind};
use std::mem;
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use std::vec;

use mio::net::TcpStream;
use mio::{Events, Interest, Poll, Token};
use socket2::{SockRef, TcpKeepalive};

use crate::codec::push_request;
use crate::config::ClientConfig;
use crate::connection::DisconnectReason;
use crate::endpoint::Endpoint;
use crate::req_connection::ReqConnection;

/// A REQ socket that connects to one server over TCP. All methods run on the caller's thread.
///
/// Call [`send`](Self::send), and then [`receive`](Self::receive) until it returns the reply. The
/// server may be started later, and may restart between two requests: while no connection exists,
/// `receive` tries to connect every [`retry_interval`](ClientConfig::retry_interval). A request is
/// never sent twice, because the server may have received it before the connection ended.
///
/// ```
/// use std::time::Duration;
///
/// use mmsim_zmtp::ReqClient;
///
/// # use std::io::{Read, Write};
/// # use mmsim_zmtp::codec::{GREETING, READY};
/// # let listener = mmsim_zmtp::listen("127.0.0.1", 0)?;
/// # let endpoint = format!("tcp://{}", listener.local_addr()?);
/// # let server = std::thread::spawn(move || -> std::io::Result<()> {
/// #     let mut stream = listener.accept()?.0;
/// #     stream.write_all(&[&GREETING[..], READY].concat())?;
/// #     stream.read_exact(&mut [0; 64 + 27 + 9])?;
/// #     stream.write_all(b"\x01\0\0\x05world")
/// # });
/// let mut client = ReqClient::new(endpoint.parse()?)?; // such as "tcp://127.0.0.1:6574"
/// let mut reply = Vec::new();
/// client.send(&[b"hello"]);
/// let frames = client.receive(&mut reply, Duration::from_secs(10))?;
/// assert_eq!(frames, Some(1), "no reply within 10 s, or a reply of several frames");
/// assert_eq!(reply, b"world");
/// # server.join().unwrap()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ReqClient {
    endpoint: Endpoint,
    config: ClientConfig,
    poll: Poll,
    events: Events,
    link: Link,
    /// The addresses of the server that have not been tried since the host was last resolved.
    addresses: vec::IntoIter<SocketAddr>,
    /// The latest request as encoded bytes.
    request: Vec<u8>,
    state: RequestState,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequestState {
    /// The client waits for no reply.
    Done,
    /// No byte of the request has been sent.
    Unsent,
    /// At least a part of the request may have been sent, and its reply has not arrived.
    Sent,
}

enum Link {
    /// No connection. The next attempt to connect is due at `retry_at`.
    Down { retry_at: Instant },
    /// A connection that has not been established by `give_up_at` is dropped.
    Connecting { stream: TcpStream, give_up_at: Instant },
    /// A connection whose handshake is not complete by `give_up_at` is dropped.
    Up { connection: ReqConnection<TcpStream>, give_up_at: Instant },
}

impl ReqClient {
    /// Creates a client with the default limits. The first call of [`receive`](Self::receive)
    /// connects to the server.
    ///
    /// # Errors
    /// Returns an error if the operating system has no resources left.
    pub fn new(endpoint: Endpoint) -> io::Result<Self> {
        Self::with_config(endpoint, ClientConfig::DEFAULT)
    }

    /// Creates a client with other limits.
    ///
    /// # Errors
    /// Returns an error if no client can work with these limits (a
    /// [`ConfigError`](crate::ConfigError) inside an [`ErrorKind::InvalidInput`]), or if the
    /// operating system has no resources left.
    pub fn with_config(endpoint: Endpoint, config: ClientConfig) -> io::Result<Self> {
        config.check()?;
        Ok(Self {
            endpoint,
            config,
            poll: Poll::new()?,
            events: Events::with_capacity(4),
            link: Link::Down { retry_at: Instant::now() },
            addresses: Vec::new().into_iter(),
            request: Vec::new(),
            state: RequestState::Done,
        })
    }

    /// Sets the next request, which has a body of one or more frames. [`receive`](Self::receive)
    /// sends it.
    ///
    /// If the reply to an earlier request has not arrived, `send` closes the connection, so the
    /// late reply can never be taken for the reply to this request. An earlier request that has not
    /// been sent is dropped.
    pub fn send(&mut self, frames: &[&[u8]]) {
        self.request.clear();
        push_request(&mut self.request, frames);
        let is_waiting = mem::replace(&mut self.state, RequestState::Unsent) == RequestState::Sent;
        if let Link::Up { connection, .. } = &mut self.link
            && connection.is_ready()
        {
            if is_waiting || !connection.is_idle() {
                self.link = Link::Down { retry_at: Instant::now() };
            } else {
                connection.push(&self.request);
                self.state = RequestState::Sent;
            }
        }
    }

    /// Waits for the reply to the latest request, for at most `wait`. Replaces the contents of
    /// `reply` with the last frame of the reply, and returns the number of its frames. A valid
    /// reply has one frame.
    ///
    /// Returns `None` if the reply has not arrived in time. The request remains active, so
    /// `receive` may be called again. The resolution of a host name may exceed `wait`.
    ///
    /// # Errors
    /// Returns an error if the connection ends after a part of the request has been sent, or if the
    /// server violates the protocol. The client then drops the request, and connects again for the
    /// next one.
    pub fn receive(
        &mut self,
        reply: &mut Vec<u8>,
        wait: Duration,
    ) -> Result<Option<usize>, DisconnectReason> {
        let deadline = Instant::now().checked_add(wait);
        loop {
            let frames = self.advance(reply).inspect_err(|_| self.state = RequestState::Done)?;
            if frames.is_some() {
                self.state = RequestState::Done;
                return Ok(frames);
            }
            let now = Instant::now();
            if deadline.is_some_and(|deadline| deadline <= now) {
                return Ok(None);
            }
            self.wait(deadline, now)?;
        }
    }

    /// Waits until the link may have work to do, or until `deadline`.
    fn wait(&mut self, deadline: Option<Instant>, now: Instant) -> io::Result<()> {
        let next = match &self.link {
            Link::Up { connection, .. } if connection.has_more() => Some(now),
            Link::Up { connection, .. } if connection.is_ready() => None,
            Link::Down { retry_at: at }
            | Link::Connecting { give_up_at: at, .. }
            | Link::Up { give_up_at: at, .. } => Some(*at),
        };
        let until = deadline.into_iter().chain(next).min();
        let timeout = until.map(|until| until.saturating_duration_since(now));
        match self.poll.poll(&mut self.events, timeout) {
            Err(error) if error.kind() == ErrorKind::Interrupted => return Ok(()),
            result => result?,
        }
        if let Link::Up { connection, .. } = &mut self.link {
            for event in &self.events {
                let is_closed = event.is_error() || event.is_read_closed();
                let is_readable = event.is_readable() || is_closed;
                connection.set_ready(is_readable, event.is_writable() || is_closed);
            }
        }
        Ok(())
    }

    /// Connects, sends and receives as far as possible without waiting. Returns the number of
    /// frames of the reply if it is complete.
    fn advance(&mut self, reply: &mut Vec<u8>) -> Result<Option<usize>, DisconnectReason> {
        loop {
            let now = Instant::now();
            let retry = self.retry(now);
            match mem::replace(&mut self.link, retry) {
                Link::Down { retry_at } if now < retry_at => {
                    self.link = Link::Down { retry_at };
                    return Ok(None);
                }
                Link::Down { .. } => {
                    if let Ok(stream) = self.connect() {
                        let give_up_at = now + self.config.handshake_time;
                        self.link = Link::Connecting { stream, give_up_at };
                    } else {
                        self.link = self.retry(now);
                    }
                }
                Link::Connecting { stream, give_up_at } => {
                    match is_connected(&stream, self.config.keepalive) {
                        Ok(true) => {
                            let connection = ReqConnection::new(stream, &self.config);
                            self.link = Link::Up { connection, give_up_at };
                        }
                        Ok(false) if now < give_up_at => {
                            self.link = Link::Connecting { stream, give_up_at };
                            return Ok(None);
                        }
                        _ => {}
                    }
                }
                Link::Up { mut connection, give_up_at } => {
                    let was_ready = connection.is_ready();
                    if was_ready && self.state == RequestState::Unsent {
                        if !connection.is_idle() {
                            continue;
                        }
                        connection.push(&self.request);
                        self.state = RequestState::Sent;
                    }
                    let is_sent = self.state == RequestState::Sent;
                    match connection.turn(reply) {
                        Ok(frames) if is_sent || frames.is_none() => {
                            let is_ready = connection.is_ready();
                            if is_ready || now < give_up_at {
                                self.link = Link::Up { connection, give_up_at };
                            }
                            if was_ready == is_ready {
                                return Ok(frames);
                            }
                            // The next connection resolves the host again.
                            self.addresses = Vec::new().into_iter();
                        }
                        Err(reason)
                            if is_sent || matches!(reason, DisconnectReason::Protocol(_)) =>
                        {
                            return Err(reason);
                        }
                        // The connection has ended, or has a reply to no request.
                        Ok(_) | Err(_) => {}
                    }
                }
            }
        }
    }

    /// Returns the link after a failed attempt to connect.
    fn retry(&self, now: Instant) -> Link {
        let has_other_address = self.addresses.len() > 0;
        let wait = if has_other_address { Duration::ZERO } else { self.config.retry_interval };
        Link::Down { retry_at: now + wait }
    }

    /// Starts to connect to the next address of the server.
    fn connect(&mut self) -> io::Result<TcpStream> {
        if self.addresses.len() == 0 {
            self.addresses = self.endpoint.resolve()?.into_iter();
        }
        let address = self.addresses.next().ok_or(ErrorKind::NotFound)?;
        let mut stream = TcpStream::connect(address)?;
        let interest = Interest::READABLE | Interest::WRITABLE;
        self.poll.registry().register(&mut stream, Token(0), interest)?;
        Ok(stream)
    }
}

/// Returns true if the stream is connected, and prepares it. Returns false if it is still
/// connecting.
fn is_connected(stream: &TcpStream, keepalive: Duration) -> io::Result<bool> {
    if let Some(error) = stream.take_error()? {
        return Err(error);
    }
    match stream.peer_addr() {
        // If no server listens, TCP can connect a port to itself.
        Ok(address) if stream.local_addr()? == address => Err(ErrorKind::ConnectionRefused.into()),
        Ok(_) => {
            stream.set_nodelay(true)?;
            // Detects a server that has disappeared without closing the connection.
            SockRef::from(stream).set_tcp_keepalive(&TcpKeepalive::new().with_time(keepalive))?;
            Ok(true)
        }
        Err(error) if error.kind() == ErrorKind::NotConnected => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    #[test]
    fn connection_to_itself_is_refused() {
        use socket2::{Domain, Socket, Type};

        use super::*;

        let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
        socket.bind(&"127.0.0.1:0".parse::<SocketAddr>().unwrap().into()).unwrap();
        socket.connect(&socket.local_addr().unwrap()).unwrap();
        socket.set_nonblocking(true).unwrap();
        let stream = TcpStream::from_std(socket.into());
        let error = is_connected(&stream, ClientConfig::DEFAULT.keepalive).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::ConnectionRefused);
    }
}
