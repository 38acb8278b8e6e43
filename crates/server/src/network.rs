//! All connections of a server, served in one thread, each in its turn.

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::io::{self, ErrorKind};
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use mio::net::{TcpListener, TcpStream};
use mio::{Events, Interest, Poll, Token, Waker};
use socket2::{SockRef, TcpKeepalive};
use tracing::{debug, warn};

use crate::ReplyBuffer;
use crate::limits::{HANDSHAKE_TIME, MAX_CONNECTIONS, OVERSIZED_TIME};
use crate::peer::{End, Peer, Turn};
use crate::standing::{Standing, evict};

const LISTENER: Token = Token(0);
const WAKER: Token = Token(1);
const FIRST_PEER: usize = 2;

/// Connections that the operating system lets wait to be accepted; it may allow fewer.
const QUEUE: i32 = 1024;

/// Events taken at once.
const EVENTS: usize = 256;

/// Connections accepted before those that are there have their turn.
const ACCEPTED_AT_ONCE: usize = 16;

/// Delay before the next attempt to accept, after the system had no descriptor or memory left, or
/// newcomers were turned away. A connection that ends cuts it short.
const ACCEPT_AGAIN: Duration = Duration::from_millis(100);

/// Requests of one peer that are answered in a row while no other waits.
const REQUESTS_IN_A_ROW: usize = 8;

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
    /// The deadlines of all connections that have one.
    deadlines: BTreeSet<(Instant, Token)>,
    /// Whether somebody may wait to be accepted …
    acceptable: bool,
    /// … and until when there is no use in trying, unless a connection ends before.
    accept_again: Option<Instant>,
    warned: bool,
}

/// A peer as the network sees it.
struct Connection {
    peer: Peer<TcpStream>,
    standing: Standing,
    /// When it is cut off, unless it shows before that it speaks the protocol.
    deadline: Option<Instant>,
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
            deadlines: BTreeSet::new(),
            acceptable: true,
            accept_again: None,
            warned: false,
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
        match self.poll.poll(events, timeout) {
            // A signal, which is for others to act on.
            Err(error) if error.kind() == ErrorKind::Interrupted => return Ok(true),
            result => result?,
        }
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
                        if event.is_writable() && peer.has_output() {
                            connection.standing.record_progress(now);
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

    /// Events for [`Self::wait`].
    pub(crate) fn events() -> Events {
        Events::with_capacity(EVENTS)
    }

    /// Gives one turn to each peer that may have something for us, disconnects those whose deadline
    /// has passed, and accepts new peers as there is room. `answer` is as for [`Peer::turn`], and
    /// returns whether the request counts for the standing of its sender.
    pub(crate) fn serve(
        &mut self,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer) -> bool,
        reply: &mut ReplyBuffer,
    ) {
        for _ in 0..self.queue.len() {
            let Some(token) = self.queue.pop_front() else { break };
            if let Some(connection) = self.peers.get_mut(&token) {
                connection.queued = false;
                self.give_turn(token, &mut answer, reply);
            }
        }
        let now = Instant::now();
        while let Some(&late) = self.deadlines.first().filter(|(deadline, _)| *deadline <= now) {
            self.give_last_turn(late.1, &mut answer, reply);
            if self.deadlines.contains(&late) {
                self.end(late.1, &End::Late);
            }
        }
        self.accept(now, &mut answer, reply);
    }

    fn give_turn(
        &mut self,
        token: Token,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer) -> bool,
        reply: &mut ReplyBuffer,
    ) {
        let Some(connection) = self.peers.get_mut(&token) else { return };
        let in_a_row = if self.queue.is_empty() { REQUESTS_IN_A_ROW } else { 1 };
        let mut counts = false;
        let answer = |request: &[u8], frames, reply: &mut ReplyBuffer| {
            counts |= answer(request, frames, reply);
        };
        let turn = connection.peer.turn(in_a_row, answer, reply);
        let now = Instant::now();
        if counts {
            connection.standing.record_request(now);
        }
        if connection.peer.is_ready() {
            if let Some(deadline) = connection.deadline.take() {
                self.deadlines.remove(&(deadline, token));
            }
        } else if connection.deadline.is_none() {
            connection.deadline = Some(now + OVERSIZED_TIME);
            self.deadlines.insert((now + OVERSIZED_TIME, token));
        }
        match turn {
            Ok(Turn::Again) if !connection.queued => {
                connection.queued = true;
                self.queue.push_back(token);
            }
            Ok(_) => {}
            Err(end) => self.end(token, &end),
        }
    }

    /// Gives a turn to a peer that is about to be disconnected: what has just come in may save it.
    fn give_last_turn(
        &mut self,
        token: Token,
        answer: impl FnMut(&[u8], usize, &mut ReplyBuffer) -> bool,
        reply: &mut ReplyBuffer,
    ) {
        if let Some(connection) = self.peers.get_mut(&token) {
            connection.peer.readable = true;
            self.give_turn(token, answer, reply);
        }
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
        let deadline = self.deadlines.first().map(|&(deadline, _)| deadline);
        let next = accept.into_iter().chain(deadline).min()?;
        // The system counts in milliseconds and could otherwise be asked too early.
        Some(next.saturating_duration_since(now) + Duration::from_millis(1))
    }

    fn may_accept(&self, now: Instant) -> bool {
        self.acceptable && self.accept_again.is_none_or(|again| again <= now)
    }

    fn accept(
        &mut self,
        now: Instant,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer) -> bool,
        reply: &mut ReplyBuffer,
    ) {
        let mut turned_away = false;
        for _ in 0..ACCEPTED_AT_ONCE {
            if !self.may_accept(now) {
                break;
            }
            match self.listener.accept() {
                Ok((stream, address)) => {
                    let is_full = self.peers.len() >= MAX_CONNECTIONS;
                    if is_full && !self.make_room(Some(address.ip()), &mut answer, reply) {
                        turned_away = true;
                        debug!(%address, "connection turned away: every place is taken");
                    } else if let Err(error) = self.add(stream, address.ip(), now) {
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
                    _ => {
                        // The system has no descriptor or memory for another connection.
                        if !self.warned {
                            self.warned = true;
                            warn!(
                                "cannot accept more than {} connections: {error}",
                                self.peers.len()
                            );
                        }
                        if !self.make_room(None, &mut answer, reply) {
                            self.accept_again = Some(now + ACCEPT_AGAIN);
                        }
                    }
                },
            }
        }
        if turned_away {
            // Sockets that are turned away connect again at once, which must not keep the server busy.
            self.accept_again = Some(now + ACCEPT_AGAIN);
        }
    }

    /// Disconnects the peer that must make room for a newcomer from this address, if there is one.
    fn make_room(
        &mut self,
        newcomer: Option<IpAddr>,
        mut answer: impl FnMut(&[u8], usize, &mut ReplyBuffer) -> bool,
        reply: &mut ReplyBuffer,
    ) -> bool {
        let places = self.peers.len();
        loop {
            let standings =
                self.peers.iter().map(|(&token, connection)| (token, &connection.standing));
            let Some(token) = evict(standings, newcomer, Instant::now()) else { return false };
            let before = self.peers.get(&token).map(|connection| connection.standing);
            self.give_last_turn(token, &mut answer, reply);
            if self.peers.get(&token).map(|connection| connection.standing) == before {
                self.end(token, &End::Evicted);
            }
            if self.peers.len() < places {
                return true;
            }
        }
    }

    fn add(&mut self, mut stream: TcpStream, address: IpAddr, now: Instant) -> io::Result<()> {
        stream.set_nodelay(true)?;
        // A peer whose machine has gone says nothing any more; its place shall not be lost.
        SockRef::from(&stream).set_tcp_keepalive(&TcpKeepalive::new().with_time(KEEPALIVE))?;
        let token = Token(self.next);
        let interest = Interest::READABLE | Interest::WRITABLE;
        self.poll.registry().register(&mut stream, token, interest)?;
        self.next += 1;
        let deadline = now + HANDSHAKE_TIME;
        let connection = Connection {
            peer: Peer::new(stream),
            standing: Standing::new(address, now),
            deadline: Some(deadline),
            queued: true,
        };
        self.peers.insert(token, connection);
        self.queue.push_back(token);
        self.deadlines.insert((deadline, token));
        Ok(())
    }

    fn end(&mut self, token: Token, end: &End) {
        if let Some(Connection { mut peer, deadline, .. }) = self.peers.remove(&token) {
            if let Some(deadline) = deadline {
                self.deadlines.remove(&(deadline, token));
            }
            // It is closed all the same, and with that forgotten by the system.
            let _ = self.poll.registry().deregister(peer.stream_mut());
            self.accept_again = None;
            debug!("a connection has ended: {end}");
        }
    }
}
