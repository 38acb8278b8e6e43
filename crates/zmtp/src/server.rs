//! The server, which handles its listening socket and all connections on one thread.

use std::io::{self, ErrorKind};
use std::mem;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::{Duration, Instant};

use mio::net::TcpStream;
use mio::{Events, Interest, Poll, Token};
use socket2::{SockRef, TcpKeepalive};
use tracing::{debug, warn};

use crate::config::ServerConfig;
use crate::connections::Connections;
use crate::service::Service;

const LISTENER: Token = Token(0);
const WAKER: Token = Token(1);

/// The maximum number of connections waiting to be accepted. The operating system may impose a
/// lower limit.
const BACKLOG: i32 = 1024;

/// The maximum number of events that one poll of the sockets returns.
const MAX_EVENTS: usize = 256;

/// The maximum number of connections that the server accepts before it serves existing connections.
const MAX_ACCEPTED_AT_ONCE: usize = 16;

/// The delay before the server tries again to accept connections. The server waits after it has
/// turned clients away, and after the operating system has run out of descriptors or memory.
const RETRY_DELAY: Duration = Duration::from_millis(100);

/// A server that is shutting down stops answering requests when it has received no input for this
/// time.
const QUIET: Duration = Duration::from_millis(20);

/// Like [`QUIET`], but for a server with at least one connection that is not ready for requests.
const QUIET_UNREADY: Duration = Duration::from_millis(100);

/// A server that is shutting down stops answering requests after this time, even if input still
/// arrives.
const MAX_DRAIN: Duration = Duration::from_millis(300);

/// The maximum duration of a shutdown, including the time for sending the last replies.
const LINGER: Duration = Duration::from_millis(500);

/// A REP socket that listens on TCP. One thread serves all connections.
#[must_use = "a server does nothing until it runs"]
pub struct RepServer {
    poll: Poll,
    events: Events,
    listener: mio::net::TcpListener,
    connections: Connections<TcpStream>,
    keepalive: Duration,
    accept: AcceptBackoff,
    /// The identifier of the next connection, which is also its [`Token`].
    next_id: usize,
    waker: Waker,
    has_warned: bool,
}

/// A handle that wakes a [`RepServer`] from another thread.
#[derive(Clone, Debug)]
pub struct Waker(Arc<mio::Waker>);

impl Waker {
    /// Makes [`RepServer::run`] call [`Service::due_reply`] and [`Service::after_round`], and then
    /// check whether to stop. Does nothing if the server has stopped.
    pub fn wake(&self) {
        let _ = self.0.wake();
    }
}

impl RepServer {
    /// Creates a server with the default limits, which accepts clients from `listener`.
    ///
    /// # Errors
    /// Returns an error if the operating system has no resources left.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        Self::with_config(listener, ServerConfig::DEFAULT)
    }

    /// Creates a server with other limits.
    ///
    /// # Errors
    /// Returns an error if no server can work with these limits (a
    /// [`ConfigError`](crate::ConfigError) inside an [`ErrorKind::InvalidInput`]), or if the
    /// operating system has no resources left.
    pub fn with_config(listener: TcpListener, config: ServerConfig) -> io::Result<Self> {
        config.check()?;
        listener.set_nonblocking(true)?;
        let (poll, mut listener) = (Poll::new()?, mio::net::TcpListener::from_std(listener));
        SockRef::from(&listener).listen(BACKLOG)?;
        poll.registry().register(&mut listener, LISTENER, Interest::READABLE)?;
        let waker = Waker(Arc::new(mio::Waker::new(poll.registry(), WAKER)?));
        Ok(Self {
            poll,
            events: Events::with_capacity(MAX_EVENTS),
            listener,
            connections: Connections::new(config),
            keepalive: config.keepalive,
            accept: AcceptBackoff::new(),
            next_id: WAKER.0 + 1,
            waker,
            has_warned: false,
        })
    }

    /// Returns the address of the listening socket.
    ///
    /// # Errors
    /// Returns an error if the operating system does not report the address.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Returns a handle that wakes the server from another thread.
    pub fn waker(&self) -> Waker {
        self.waker.clone()
    }

    /// Serves all clients until `is_stopping` returns true. [`Waker::wake`] makes the server call
    /// `is_stopping`.
    ///
    /// A stopping server answers requests that clients have already sent, for at most 0.3 s. `run`
    /// returns when the last replies have been sent, and at the latest 0.5 s after `is_stopping`
    /// has returned true.
    ///
    /// # Errors
    /// Returns an error if the operating system fails to report events. No client can cause this
    /// error.
    pub fn run(
        &mut self,
        service: &mut impl Service,
        is_stopping: impl Fn() -> bool,
    ) -> io::Result<()> {
        while !is_stopping() {
            self.wait(service.next_due(), None)?;
            self.serve_round(service);
        }
        let mut drain = Drain::new(Instant::now());
        while let Some(left) = drain.time_left(self.connections.has_unready(), Instant::now()) {
            if self.wait(service.next_due(), Some(left))? {
                drain.last_input = Instant::now();
            }
            self.serve_round(service);
        }
        // Sends the last replies.
        while self.connections.flush()
            && let Some(left) = drain.linger_left(Instant::now())
        {
            self.accept.is_pending = false;
            self.wait(None, Some(left))?;
        }
        Ok(())
    }

    /// Waits for an event, the waker, the next deadline or the time `next_due` of a reply, but no
    /// longer than `max`. Returns true if there was an event or if a connection may have work to do.
    fn wait(&mut self, next_due: Option<Instant>, max: Option<Duration>) -> io::Result<bool> {
        let (now, is_busy) = (Instant::now(), self.connections.is_busy());
        let timeout = if is_busy || self.accept.is_due(now) {
            Some(Duration::ZERO)
        } else {
            let deadlines = [self.connections.deadline(), self.accept.deadline(), next_due];
            let next = deadlines.into_iter().flatten().min();
            // The operating system counts in whole milliseconds, so it could return too early
            // without the extra millisecond.
            let left =
                next.map(|time| time.saturating_duration_since(now) + Duration::from_millis(1));
            left.into_iter().chain(max).min()
        };
        match self.poll.poll(&mut self.events, timeout) {
            // A signal has arrived. The caller checks whether to stop.
            Err(error) if error.kind() == ErrorKind::Interrupted => return Ok(true),
            result => result?,
        }
        let now = Instant::now();
        for event in &self.events {
            match event.token() {
                WAKER => {}
                LISTENER => self.accept.is_pending = true,
                Token(id) => {
                    // The next read or write returns the error, if there is one.
                    if event.is_error() || event.is_read_closed() {
                        self.connections.set_closed(id, now);
                    } else {
                        let (is_readable, is_writable) = (event.is_readable(), event.is_writable());
                        self.connections.set_ready(id, is_readable, is_writable, now);
                    }
                }
            }
        }
        Ok(!self.events.is_empty() || self.connections.is_busy())
    }

    /// Gives one turn to each connection that may have work to do, closes connections whose
    /// deadlines have passed, and accepts new connections.
    fn serve_round(&mut self, service: &mut impl Service) {
        let now = Instant::now();
        self.connections.serve(service, now);
        self.deregister_closed(service);
        self.accept(now, service);
        service.after_round();
    }

    fn accept(&mut self, now: Instant, service: &mut impl Service) {
        let mut has_turned_away = false;
        for _ in 0..MAX_ACCEPTED_AT_ONCE {
            if !self.accept.is_due(now) {
                break;
            }
            match self.listener.accept() {
                Ok((stream, address)) => {
                    if self.connections.is_full()
                        && !self.connections.make_room(Some(address.ip()), service, now)
                    {
                        has_turned_away = true;
                        debug!(%address, "connection turned away: the server is full");
                    } else if let Err(error) = self.add(stream, address.ip(), now) {
                        debug!(%error, %address, "cannot accept a connection");
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock => self.accept.is_pending = false,
                    // The client has already disconnected.
                    ErrorKind::ConnectionAborted
                    | ErrorKind::ConnectionReset
                    | ErrorKind::HostUnreachable
                    | ErrorKind::NetworkUnreachable
                    | ErrorKind::NetworkDown
                    | ErrorKind::Interrupted => {}
                    _ => {
                        // The operating system has no descriptor or memory for another connection.
                        if !mem::replace(&mut self.has_warned, true) {
                            let count = self.connections.len();
                            warn!("cannot accept more than {count} connections: {error}");
                        }
                        if !self.connections.make_room(None, service, now) {
                            self.accept.back_off(now);
                        }
                    }
                },
            }
            self.deregister_closed(service);
        }
        if has_turned_away {
            // Clients that are turned away reconnect immediately. The delay keeps them from
            // occupying the server.
            self.accept.back_off(now);
        }
    }

    fn add(&mut self, mut stream: TcpStream, address: IpAddr, now: Instant) -> io::Result<()> {
        stream.set_nodelay(true)?;
        // Detects clients that have disappeared without closing the connection.
        let keepalive = TcpKeepalive::new().with_time(self.keepalive);
        SockRef::from(&stream).set_tcp_keepalive(&keepalive)?;
        let (id, interest) = (self.next_id, Interest::READABLE | Interest::WRITABLE);
        self.poll.registry().register(&mut stream, Token(id), interest)?;
        self.connections.add(id, stream, address, now);
        self.next_id += 1;
        Ok(())
    }

    /// Deregisters and closes the streams of closed connections, so that new connections can be
    /// accepted immediately.
    fn deregister_closed(&mut self, service: &mut impl Service) {
        for connection in self.connections.closed.drain(..) {
            service.disconnected(connection.client());
            let mut stream = connection.into_stream();
            // Dropping the stream closes it even if this fails.
            let _ = self.poll.registry().deregister(&mut stream);
            self.accept.retry_at = None;
        }
    }
}

/// The schedule for accepting connections. While the server cannot take more connections, it delays
/// its next attempt to accept one.
#[derive(Debug)]
struct AcceptBackoff {
    /// True if a connection may be waiting to be accepted.
    is_pending: bool,
    /// The time of the next attempt, or `None` if the next attempt is not delayed.
    retry_at: Option<Instant>,
}

impl AcceptBackoff {
    const fn new() -> Self {
        Self { is_pending: true, retry_at: None }
    }

    /// Delays the next attempt to accept a connection.
    fn back_off(&mut self, now: Instant) {
        self.retry_at = Some(now + RETRY_DELAY);
    }

    /// Returns true if the server should try to accept a connection now.
    fn is_due(&self, now: Instant) -> bool {
        self.is_pending && self.retry_at.is_none_or(|time| time <= now)
    }

    /// Returns the time of the next attempt, or `None` if the next attempt is not delayed or if no
    /// connection is waiting.
    fn deadline(&self) -> Option<Instant> {
        self.retry_at.filter(|_| self.is_pending)
    }
}

/// The timer of a server that is shutting down but still answers requests that clients have already
/// sent.
#[derive(Debug)]
struct Drain {
    started: Instant,
    /// The time of the latest input.
    last_input: Instant,
}

impl Drain {
    const fn new(now: Instant) -> Self {
        Self { started: now, last_input: now }
    }

    /// Returns the time left for answering requests, or `None` if the time is up.
    fn time_left(&self, has_unready: bool, now: Instant) -> Option<Duration> {
        let quiet = if has_unready { QUIET_UNREADY } else { QUIET };
        let end = (self.started + MAX_DRAIN).min(self.last_input + quiet);
        end.checked_duration_since(now).filter(|left| !left.is_zero())
    }

    /// Returns the time left for sending replies, or `None` if the time is up.
    fn linger_left(&self, now: Instant) -> Option<Duration> {
        (self.started + LINGER).checked_duration_since(now).filter(|left| !left.is_zero())
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpStream;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread;

    use super::*;
    use crate::codec::handshake::{GREETING, READY, REQ_READY};
    use crate::connection::Echo;
    use crate::endpoint::listen;

    const MS: Duration = Duration::from_millis(1);

    /// Reads all bytes until the server closes the connection. Panics if no bytes arrive for 20 s.
    fn read_to_end(mut stream: TcpStream) -> Vec<u8> {
        let mut bytes = Vec::new();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn server_answers_disconnects_and_stops() {
        let mut server = RepServer::new(listen("127.0.0.1", 0).unwrap()).unwrap();
        let address = server.local_address().unwrap();
        let (waker, is_stopping) = (server.waker(), Arc::new(AtomicBool::new(false)));
        let flag = Arc::clone(&is_stopping);
        let thread = thread::spawn(move || {
            let mut echo = Echo::default();
            server.run(&mut echo, || flag.load(Ordering::Acquire)).map(|()| echo.rounds)
        });
        let mut invalid = TcpStream::connect(address).unwrap();
        invalid.write_all(b"GET / HTTP/1.1\r\n").unwrap();
        assert_eq!(read_to_end(invalid), GREETING[..10]);
        let mut client = TcpStream::connect(address).unwrap();
        client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        // The server needs several rounds for these requests, but receives only one event.
        let requests = b"\x01\0\0\x01a".repeat(1000);
        client.write_all(&[&GREETING[..], REQ_READY, &requests].concat()).unwrap();
        let expected = [&GREETING[..], READY, &requests].concat();
        let mut replies = vec![0; expected.len()];
        client.read_exact(&mut replies).unwrap();
        assert!(replies == expected);
        client.write_all(b"\x01\0\0\x01b").unwrap();
        is_stopping.store(true, Ordering::Release);
        waker.wake();
        let rounds = thread.join().unwrap().unwrap();
        assert!(rounds > 0, "`after_round` was not called");
        assert_eq!(read_to_end(client), b"\x01\0\0\x01b");
    }

    #[test]
    fn attempts_are_delayed_until_the_deadline_or_a_close() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        assert!(accept.is_due(start));
        assert_eq!(accept.deadline(), None);
        accept.back_off(start);
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(!accept.is_due(start + RETRY_DELAY.saturating_sub(MS)));
        assert!(accept.is_due(start + RETRY_DELAY));
        accept.retry_at = None;
        assert!(accept.is_due(start));
    }

    #[test]
    fn no_attempt_is_due_while_no_connection_waits() {
        let start = Instant::now();
        let mut accept = AcceptBackoff::new();
        accept.back_off(start);
        accept.is_pending = false;
        assert!(!accept.is_due(start + 2 * RETRY_DELAY));
        assert_eq!(accept.deadline(), None);
        accept.is_pending = true;
        assert_eq!(accept.deadline(), Some(start + RETRY_DELAY));
        assert!(accept.is_due(start + RETRY_DELAY));
    }

    #[test]
    fn drain_ends_after_silence() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        assert_eq!(drain.time_left(false, start), Some(20 * MS));
        assert_eq!(drain.time_left(false, start + 20 * MS), None);
        assert_eq!(drain.time_left(true, start + 20 * MS), Some(80 * MS));
        drain.last_input = start + 15 * MS;
        assert_eq!(drain.time_left(false, start + 20 * MS), Some(15 * MS));
    }

    #[test]
    fn drain_ends_in_spite_of_input() {
        let start = Instant::now();
        let mut drain = Drain::new(start);
        drain.last_input = start + 290 * MS;
        assert_eq!(drain.time_left(true, start + 290 * MS), Some(10 * MS));
        assert_eq!(drain.time_left(true, start + 300 * MS), None);
        assert_eq!(drain.linger_left(start + 300 * MS), Some(200 * MS));
        assert_eq!(drain.linger_left(start + 500 * MS), None);
    }
}
