//! All connections of a server, served in one thread, each in its turn.

use std::collections::{HashMap, VecDeque};
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token, Waker};
use socket2::{SockRef, TcpKeepalive};
use tracing::{debug, warn};

use crate::ReplyBuffer;
use crate::limits::{HANDSHAKE_TIME, MAX_CONNECTIONS, SILENCE};
use crate::lookout::Lookout;
use crate::peer::{End, Peer, Turn};

const LISTENER: Token = Token(0);
const WAKER: Token = Token(1);
const FIRST_PEER: usize = 2;

/// Connections that the operating system lets wait to be accepted; it may allow fewer.
const QUEUE: i32 = 1024;

/// Events taken at once.
const EVENTS: usize = 256;

/// Connections accepted before those that are there have their turn.
const ACCEPTED_AT_ONCE: usize = 16;

/// When the system could not give a connection for want of descriptors or memory, it is asked
/// again once a connection has ended or after so long.
const ACCEPT_AGAIN: Duration = Duration::from_millis(250);

/// Silence after which the system asks a peer's machine whether it is still there.
const KEEPALIVE: Duration = Duration::from_secs(60);

/// A listening socket and the peers that have connected to it.
pub(crate) struct Network {
    poll: Poll,
    listener: TcpListener,
    peers: HashMap<Token, Connection>,
    next: usize,
    /// Those that may do something now, each once in a while, oldest first.
    queue: VecDeque<Token>,
    /// When those are cut off that have not shown by then that they speak the protocol.
    handshakes: VecDeque<(Instant, Token)>,
    /// Whether somebody may wait to be accepted …
    acceptable: bool,
    /// … and until when there is no use in trying, unless a connection ends before.
    accept_again: Option<Instant>,
    warned: bool,
    lookout: Lookout,
}

/// A peer as the network sees it.
struct Connection {
    peer: Peer<TcpStream>,
    /// When it last had something for us.
    heard: Instant,
    /// Whether it waits for its turn.
    queued: bool,
}

impl Network {
    /// Takes over a socket that listens.
    pub(crate) fn new(listener: std::net::TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        let (poll, mut listener) = (Poll::new()?, TcpListener::from_std(listener));
        SockRef::from(&listener).listen(QUEUE)?;
        poll.registry().register(&mut listener, LISTENER, Interest::READABLE)?;
        Ok(Self {
            poll,
            listener,
            peers: HashMap::new(),
            next: FIRST_PEER,
            queue: VecDeque::new(),
            handshakes: VecDeque::new(),
            acceptable: true,
            accept_again: None,
            warned: false,
            lookout: Lookout::new(),
        })
    }

    pub(crate) fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// What ends a [`Self::wait`] from another thread. There may be one only.
    pub(crate) fn waker(&self) -> io::Result<Waker> {
        Waker::new(self.poll.registry(), WAKER)
    }

    /// Waits until somebody may have something for us, until the waker is used, or at most for so
    /// long. Gives whether anything has happened.
    pub(crate) fn wait(&mut self, events: &mut Events, most: Option<Duration>) -> io::Result<bool> {
        let timeout = self.until_next_timer(Instant::now()).into_iter().chain(most).min();
        match self.poll(events, timeout) {
            // A signal, which is for others to act on.
            Err(error) if error.kind() == ErrorKind::Interrupted => return Ok(true),
            result => result?,
        }
        self.lookout.has_come(!events.is_empty());
        let now = Instant::now();
        for event in &*events {
            match event.token() {
                WAKER => {}
                LISTENER => self.acceptable = true,
                token => {
                    if let Some(connection) = self.peers.get_mut(&token) {
                        let peer = &mut connection.peer;
                        // Trying to read or write is how one learns of an error.
                        let gone = event.is_error() || event.is_read_closed();
                        // Who reads late is not silent either.
                        if event.is_readable() || event.is_writable() && peer.has_output() {
                            connection.heard = now;
                        }
                        peer.readable |= event.is_readable() || gone;
                        peer.writable |= event.is_writable() || gone;
                        if !connection.queued {
                            connection.queued = true;
                            self.queue.push_back(token);
                        }
                    }
                }
            }
        }
        Ok(!events.is_empty() || !self.queue.is_empty())
    }

    fn poll(&mut self, events: &mut Events, timeout: Option<Duration>) -> io::Result<()> {
        let Self { poll, lookout, .. } = self;
        let found = lookout.look(timeout.unwrap_or(Duration::MAX), || {
            poll.poll(events, Some(Duration::ZERO))?;
            Ok(!events.is_empty())
        })?;
        if found { Ok(()) } else { poll.poll(events, timeout) }
    }

    /// Events for [`Self::wait`].
    pub(crate) fn events() -> Events {
        Events::with_capacity(EVENTS)
    }

    /// Gives each peer that may have something for us one turn, ends late handshakes, and accepts
    /// new peers as there is room. `answer` is as for [`Peer::turn`].
    pub(crate) fn serve(
        &mut self,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer),
        reply: &mut ReplyBuffer,
    ) {
        for _ in 0..self.queue.len() {
            let Some(token) = self.queue.pop_front() else { break };
            let Some(connection) = self.peers.get_mut(&token) else { continue };
            let turn = connection.peer.turn(&mut answer, reply);
            connection.queued = matches!(turn, Ok(Turn::Again));
            match turn {
                Ok(Turn::Idle) => {}
                Ok(Turn::Again) => self.queue.push_back(token),
                Err(end) => self.end(token, &end),
            }
        }
        self.end_late_handshakes(Instant::now());
        self.accept(Instant::now());
    }

    /// Whether anybody is in a handshake.
    pub(crate) fn has_handshakes(&self) -> bool {
        self.peers.values().any(|connection| !connection.peer.is_ready())
    }

    /// Sends the replies that are still on their way, until they are gone or the time has come.
    pub(crate) fn flush(&mut self, events: &mut Events, end: Instant) -> io::Result<()> {
        loop {
            self.peers.retain(|_, connection| connection.peer.send().is_ok());
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() || !self.peers.values().any(|connection| connection.peer.has_output())
            {
                return Ok(());
            }
            self.queue.clear();
            self.acceptable = false;
            self.wait(events, Some(left))?;
        }
    }

    fn until_next_timer(&self, now: Instant) -> Option<Duration> {
        if !self.queue.is_empty() || self.may_accept(now) {
            return Some(Duration::ZERO);
        }
        let accept = self.accept_again.filter(|_| self.acceptable);
        let handshake = self.handshakes.front().map(|&(end, _)| end);
        let next = accept.into_iter().chain(handshake).min()?;
        // The system counts in milliseconds and could otherwise be asked too early.
        Some(next.saturating_duration_since(now) + Duration::from_millis(1))
    }

    fn end_late_handshakes(&mut self, now: Instant) {
        while let Some(&(end, token)) = self.handshakes.front() {
            if self.peers.get(&token).is_some_and(|connection| !connection.peer.is_ready()) {
                if now < end {
                    break;
                }
                self.end(token, &End::Late);
            }
            self.handshakes.pop_front();
        }
    }

    fn may_accept(&self, now: Instant) -> bool {
        self.acceptable && self.accept_again.is_none_or(|again| again <= now)
    }

    fn accept(&mut self, now: Instant) {
        for _ in 0..ACCEPTED_AT_ONCE {
            if !self.may_accept(now) {
                return;
            }
            let mut in_place_of = None;
            if self.peers.len() >= MAX_CONNECTIONS {
                in_place_of = self.silent(now);
                if in_place_of.is_none() {
                    return;
                }
            }
            match self.listener.accept() {
                Ok((stream, address)) => {
                    if let Some(token) = in_place_of {
                        self.end(token, &End::Silent);
                    }
                    if let Err(error) = self.add(stream, now) {
                        debug!(%error, %address, "connection not accepted");
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock => self.acceptable = false,
                    // It has gone already.
                    ErrorKind::ConnectionAborted
                    | ErrorKind::ConnectionReset
                    | ErrorKind::HostUnreachable
                    | ErrorKind::NetworkUnreachable
                    | ErrorKind::NetworkDown
                    | ErrorKind::Interrupted => {}
                    _ => self.no_more(&error, now),
                },
            }
        }
    }

    /// The system cannot give another connection.
    fn no_more(&mut self, error: &io::Error, now: Instant) {
        if !self.warned {
            self.warned = true;
            warn!("{} connections, no more for now: {error}", self.peers.len());
        }
        match self.silent(now) {
            Some(token) => self.end(token, &End::Silent),
            None => self.accept_again = Some(now + ACCEPT_AGAIN),
        }
    }

    /// Who has been silent for longest, if that is so long that another may take its place; else
    /// there is no use in trying before.
    fn silent(&mut self, now: Instant) -> Option<Token> {
        loop {
            let (&token, connection) = self.peers.iter_mut().min_by_key(|(_, peer)| peer.heard)?;
            if connection.heard + SILENCE > now {
                self.accept_again = Some(connection.heard + SILENCE);
                return None;
            }
            // It may have spoken at this very moment.
            if !connection.peer.has_unread(TcpStream::peek) {
                return Some(token);
            }
            connection.heard = now;
        }
    }

    fn add(&mut self, mut stream: TcpStream, now: Instant) -> io::Result<()> {
        stream.set_nodelay(true)?;
        // A peer whose machine has gone says nothing any more; its place shall not be lost.
        SockRef::from(&stream).set_tcp_keepalive(&TcpKeepalive::new().with_time(KEEPALIVE))?;
        let token = Token(self.next);
        let interest = Interest::READABLE | Interest::WRITABLE;
        self.poll.registry().register(&mut stream, token, interest)?;
        self.next += 1;
        let connection = Connection { peer: Peer::new(stream), heard: now, queued: true };
        self.peers.insert(token, connection);
        self.queue.push_back(token);
        self.handshakes.push_back((now + HANDSHAKE_TIME, token));
        Ok(())
    }

    fn end(&mut self, token: Token, end: &End) {
        if let Some(Connection { mut peer, .. }) = self.peers.remove(&token) {
            // It is closed all the same, and with that forgotten by the system.
            let _ = self.poll.registry().deregister(peer.stream_mut());
            self.accept_again = None;
            debug!("a connection has ended: {end}");
        }
    }
}
