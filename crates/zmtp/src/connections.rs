//! All connections of a server. This module decides the order in which connections are served and
//! when they are closed. Functions that need the current time take it as an argument.

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::fmt;
use std::io::{Read, Write};
use std::net::IpAddr;
use std::time::Instant;

use tracing::debug;

use crate::codec::decoder::Phase;
use crate::config::ServerConfig;
use crate::connection::Connection;
use crate::eviction::{Activity, choose_evicted};
use crate::service::Service;

/// The maximum number of requests in one turn if no other client is waiting.
const MAX_REQUESTS_IN_A_ROW: usize = 8;

/// The connections of a server, and the queue for their turns.
pub(crate) struct Connections<S> {
    config: ServerConfig,
    entries: HashMap<usize, Entry<S>>,
    /// The identifiers of the connections that may have work to do, in the order of their turns.
    /// The queue contains each identifier at most once.
    queue: VecDeque<usize>,
    /// The deadlines of connections. Each deadline is paired with the identifier of its connection.
    deadlines: BTreeSet<(Instant, usize)>,
    /// Closed connections, which the server must still deregister.
    pub(crate) closed: Vec<Connection<S>>,
}

struct Entry<S> {
    connection: Connection<S>,
    activity: Activity,
    /// The time at which the server closes the connection, unless the connection is in
    /// [`Phase::Ready`] by then.
    deadline: Option<Instant>,
    is_queued: bool,
}

impl<S: Read + Write> Connections<S> {
    pub(crate) fn new(config: ServerConfig) -> Self {
        Self {
            config,
            entries: HashMap::new(),
            queue: VecDeque::new(),
            deadlines: BTreeSet::new(),
            closed: Vec::new(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns true if a new connection must replace another.
    pub(crate) fn is_full(&self) -> bool {
        self.len() >= self.config.max_connections
    }

    /// Adds the connection of a new client. The identifier must not belong to another connection.
    pub(crate) fn add(&mut self, id: usize, stream: S, address: IpAddr, now: Instant) {
        let deadline = now + self.config.handshake_time;
        let entry = Entry {
            connection: Connection::new(stream, &self.config),
            activity: Activity::new(address, now),
            deadline: Some(deadline),
            is_queued: true,
        };
        self.entries.insert(id, entry);
        self.queue.push_back(id);
        self.deadlines.insert((deadline, id));
    }

    /// Records that the stream of a connection may be readable or writable, and queues the
    /// connection.
    pub(crate) fn set_ready(&mut self, id: usize, readable: bool, writable: bool, now: Instant) {
        let Some(entry) = self.entries.get_mut(&id) else { return };
        if writable && entry.connection.has_output() {
            entry.activity.record_progress(now);
        }
        entry.connection.set_ready(readable, writable);
        if !entry.is_queued {
            entry.is_queued = true;
            self.queue.push_back(id);
        }
    }

    /// Returns true if at least one connection may have work to do.
    pub(crate) fn is_busy(&self) -> bool {
        !self.queue.is_empty()
    }

    /// Returns the earliest deadline of all connections.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.deadlines.first().map(|&(deadline, _)| deadline)
    }

    /// Returns true if at least one connection is not in [`Phase::Ready`].
    pub(crate) fn has_unready(&self) -> bool {
        self.entries.values().any(|entry| entry.connection.phase() != Phase::Ready)
    }

    /// Adds the replies that were due later and are due now, and queues their connections.
    fn add_due_replies(&mut self, service: &mut impl Service, now: Instant) {
        let mut reply = Vec::new();
        while let Some(client) = service.due_reply(now, &mut reply) {
            let mut entries = self.entries.iter_mut();
            let Some((&id, entry)) = entries.find(|(_, entry)| entry.connection.client() == client)
            else {
                continue;
            };
            entry.connection.reply(&reply);
            if !entry.is_queued {
                entry.is_queued = true;
                self.queue.push_back(id);
            }
        }
    }

    /// Records that a peer has closed its connection, and queues the connection.
    pub(crate) fn set_closed(&mut self, id: usize, now: Instant) {
        if let Some(entry) = self.entries.get_mut(&id) {
            entry.connection.set_closed();
        }
        self.set_ready(id, true, true, now);
    }

    /// Gives one turn to each queued connection, and then closes the connections whose deadlines
    /// have passed. A connection is also queued when a reply to it is due.
    pub(crate) fn serve(&mut self, service: &mut impl Service, now: Instant) {
        self.add_due_replies(service, now);
        for _ in 0..self.queue.len() {
            let Some(id) = self.queue.pop_front() else { break };
            if let Some(entry) = self.entries.get_mut(&id) {
                entry.is_queued = false;
                self.give_turn(id, service, now);
            }
        }
        while let Some(&(deadline, id)) = self.deadlines.first().filter(|(time, _)| *time <= now) {
            self.give_last_turn(id, service, now);
            if self.deadlines.contains(&(deadline, id)) {
                self.close(id, "handshake too slow, or no request after an oversized frame");
            }
        }
    }

    /// Closes a connection to make room for a new client with the address `newcomer`. Returns false
    /// if no connection may be closed.
    pub(crate) fn make_room(
        &mut self,
        newcomer: Option<IpAddr>,
        service: &mut impl Service,
        now: Instant,
    ) -> bool {
        let (count, mut previous) = (self.len(), None);
        while self.len() >= count {
            let candidates =
                self.entries.iter().filter(|(_, entry)| !entry.connection.is_waiting());
            let activities = candidates.map(|(&id, entry)| (id, &entry.activity));
            let Some(id) = choose_evicted(activities, newcomer, self.config.silence, now) else {
                return false;
            };
            // A connection with activity in its last turn is kept, but only once. Otherwise the
            // clients of one network could keep all connections by sending requests all the time.
            if previous == Some(id) || !self.give_last_turn(id, service, now) {
                self.close(id, "replaced by another connection");
            }
            previous = Some(id);
        }
        true
    }

    /// Sends pending replies, and removes each connection whose stream fails. Returns true if some
    /// replies are still pending.
    pub(crate) fn flush(&mut self) -> bool {
        self.queue.clear();
        self.entries.retain(|_, entry| entry.connection.send().is_ok());
        self.entries.values().any(|entry| entry.connection.has_output())
    }

    /// Gives one turn to a connection. Returns true if a request in this turn counted as activity.
    fn give_turn(&mut self, id: usize, service: &mut impl Service, now: Instant) -> bool {
        let Some(entry) = self.entries.get_mut(&id) else { return false };
        let max_requests = if self.queue.is_empty() { MAX_REQUESTS_IN_A_ROW } else { 1 };
        let old_phase = entry.connection.phase();
        let turn = match entry.connection.turn(max_requests, service) {
            Ok(turn) => turn,
            Err(reason) => {
                self.close(id, reason);
                return false;
            }
        };
        if turn.has_activity {
            entry.activity.record_request(now);
        }
        let phase = entry.connection.phase();
        if phase != old_phase {
            if let Some(deadline) = entry.deadline.take() {
                self.deadlines.remove(&(deadline, id));
            }
            entry.deadline = (phase == Phase::Oversized).then(|| now + self.config.oversized_time);
            self.deadlines.extend(entry.deadline.map(|deadline| (deadline, id)));
        }
        if turn.has_more && !entry.is_queued {
            entry.is_queued = true;
            self.queue.push_back(id);
        }
        turn.has_activity
    }

    /// Serves a connection once more before it is closed, in case a request that has just arrived
    /// is a reason to keep the connection. Returns true if such a request counted as activity.
    fn give_last_turn(&mut self, id: usize, service: &mut impl Service, now: Instant) -> bool {
        if let Some(entry) = self.entries.get_mut(&id) {
            entry.connection.set_ready(true, false);
        }
        self.give_turn(id, service, now)
    }

    fn close(&mut self, id: usize, reason: impl fmt::Display) {
        if let Some(Entry { connection, deadline, .. }) = self.entries.remove(&id) {
            if let Some(deadline) = deadline {
                self.deadlines.remove(&(deadline, id));
            }
            self.closed.push(connection);
            debug!("connection closed: {reason}");
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::codec::handshake::{GREETING, READY};
    use crate::connection::{Echo, Wire};

    const CONFIG: ServerConfig = ServerConfig { max_request_bytes: 5000, ..ServerConfig::DEFAULT };
    const HANDSHAKE_TIME: Duration = CONFIG.handshake_time;
    const OVERSIZED_TIME: Duration = CONFIG.oversized_time;
    const SILENCE: Duration = CONFIG.silence;
    const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);
    const ELSEWHERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(192, 0, 2, 7));
    const REQUEST: &[u8] = b"\x01\0\0\x01a";
    const MS: Duration = Duration::from_millis(1);

    /// Calls [`Connections::serve`] until no connection has work to do.
    fn serve(connections: &mut Connections<Wire>, now: Instant) {
        connections.serve(&mut Echo::default(), now);
        while connections.is_busy() {
            connections.serve(&mut Echo::default(), now);
        }
    }

    fn add(connections: &mut Connections<Wire>, wire: &Wire, now: Instant) -> usize {
        let id = connections.entries.keys().max().map_or(0, |id| id + 1);
        connections.add(id, wire.clone(), HERE, now);
        id
    }

    /// Returns the beginning of a request with a frame of 5001 bytes.
    fn oversized_header() -> Vec<u8> {
        [&b"\x01\0\x02"[..], &5001_u64.to_be_bytes()].concat()
    }

    fn closed(connections: &mut Connections<Wire>) -> usize {
        connections.closed.drain(..).count()
    }

    fn send(
        connections: &mut Connections<Wire>,
        id: usize,
        wire: &Wire,
        bytes: &[u8],
        now: Instant,
    ) {
        wire.push(bytes);
        connections.set_ready(id, true, false, now);
        serve(connections, now);
    }

    #[test]
    fn handshake_has_a_deadline() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        add(&mut connections, &Wire::silent(), start);
        add(&mut connections, &Wire::new(b""), start);
        assert!(connections.has_unready());
        serve(&mut connections, start);
        assert_eq!(connections.deadline(), Some(start + HANDSHAKE_TIME));
        serve(&mut connections, start + HANDSHAKE_TIME.saturating_sub(MS));
        assert_eq!((connections.len(), closed(&mut connections)), (2, 0));
        serve(&mut connections, start + HANDSHAKE_TIME);
        assert_eq!((connections.len(), closed(&mut connections)), (1, 1));
        assert_eq!(connections.deadline(), None, "the other one is ready");
        assert!(!connections.has_unready());
    }

    #[test]
    fn bytes_that_have_just_arrived_complete_a_handshake() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let wire = Wire::silent();
        add(&mut connections, &wire, start);
        serve(&mut connections, start);
        wire.push_handshake();
        // The handshake must be read although `set_ready` has not been called.
        serve(&mut connections, start + HANDSHAKE_TIME);
        assert_eq!((connections.len(), connections.deadline()), (1, None));
    }

    #[test]
    fn request_must_follow_an_oversized_frame() {
        let frame = [&oversized_header()[..], &[7; 5001]].concat();
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let (silent, active) = (Wire::new(b""), Wire::new(b""));
        let ids = [&silent, &active].map(|wire| add(&mut connections, wire, start));
        serve(&mut connections, start);
        assert_eq!(connections.deadline(), None);
        send(&mut connections, ids[0], &silent, &frame, start);
        send(&mut connections, ids[1], &active, &frame, start);
        let id = ids[1];
        assert!(connections.has_unready());
        assert_eq!(connections.deadline(), Some(start + OVERSIZED_TIME));
        send(&mut connections, id, &active, REQUEST, start + OVERSIZED_TIME.saturating_sub(MS));
        assert!(active.sent().ends_with(REQUEST));
        assert_eq!(connections.len(), 2);
        serve(&mut connections, start + OVERSIZED_TIME);
        assert_eq!((connections.len(), connections.deadline()), (1, None));
        send(&mut connections, id, &active, REQUEST, start + 100 * OVERSIZED_TIME);
        assert_eq!(connections.len(), 1);
    }

    #[test]
    fn oversized_frame_right_after_the_handshake_has_its_own_deadline() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let header = oversized_header();
        add(&mut connections, &Wire::new(&header), start);
        let late = Wire::silent();
        let id = add(&mut connections, &late, start);
        serve(&mut connections, start);
        assert_eq!(connections.deadline(), Some(start + OVERSIZED_TIME));
        serve(&mut connections, start + OVERSIZED_TIME);
        assert_eq!((connections.len(), connections.deadline()), (1, Some(start + HANDSHAKE_TIME)));
        late.push_handshake();
        let now = start + HANDSHAKE_TIME.saturating_sub(MS);
        send(&mut connections, id, &late, &header, now);
        assert_eq!(connections.deadline(), Some(now + OVERSIZED_TIME));
    }

    #[test]
    fn silent_connection_makes_room() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let (active, silent) = (Wire::new(REQUEST), Wire::new(b""));
        add(&mut connections, &active, start);
        add(&mut connections, &silent, start);
        serve(&mut connections, start);
        let mut make_room = |now| {
            let has_room = connections.make_room(Some(HERE), &mut Echo::default(), now);
            (has_room, connections.len())
        };
        assert_eq!(make_room(start + SILENCE.saturating_sub(MS)), (false, 2));
        assert_eq!(make_room(start + SILENCE), (true, 1));
        assert!(connections.entries.contains_key(&0), "the active one stays");
        // A connection is kept if a request has just arrived, but not if this request is `ping`.
        active.push(REQUEST);
        assert!(!connections.make_room(Some(HERE), &mut Echo::default(), start + 2 * SILENCE));
        active.push(b"\x01\0\0\x04ping");
        assert!(connections.make_room(Some(HERE), &mut Echo::default(), start + 3 * SILENCE));
        assert!(active.sent().ends_with(b"\x04ping"), "answered before it is closed");
        assert_eq!(closed(&mut connections), 2);
    }

    #[test]
    fn clients_that_send_all_the_time_make_room_for_another_network() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        for _ in 0..3 {
            add(&mut connections, &Wire::new(&REQUEST.repeat(1000)), start);
        }
        connections.serve(&mut Echo::default(), start);
        let make_room = |from, connections: &mut Connections<Wire>| {
            connections.make_room(Some(from), &mut Echo::default(), start + MS)
        };
        assert!(!make_room(HERE, &mut connections));
        assert!(make_room(ELSEWHERE, &mut connections));
        assert_eq!((connections.len(), closed(&mut connections)), (2, 1));
    }

    #[test]
    fn client_that_reads_its_replies_is_not_silent() {
        for (capacity, is_readable, is_writable, has_room) in
            [(91, false, true, false), (91, true, false, true), (usize::MAX, false, true, true)]
        {
            let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
            let wire = Wire::new(REQUEST);
            wire.set_capacity(capacity);
            let id = add(&mut connections, &wire, start);
            serve(&mut connections, start);
            let before = start + SILENCE.saturating_sub(MS);
            connections.set_ready(id, is_readable, is_writable, before);
            serve(&mut connections, before);
            let now = start + SILENCE;
            let found = connections.make_room(Some(HERE), &mut Echo::default(), now);
            assert_eq!(found, has_room, "{capacity} {is_readable} {is_writable}");
        }
    }

    #[test]
    fn client_whose_reply_is_due_later_is_kept_and_delays_nobody() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let (waiting, other) = (Wire::new(b"\x01\0\0\x05later"), Wire::new(REQUEST));
        let id = add(&mut connections, &waiting, start);
        add(&mut connections, &other, start);
        serve(&mut connections, start);
        assert!(other.sent().ends_with(REQUEST) && waiting.sent().ends_with(READY));
        let client = connections.entries[&id].connection.client();
        let late = start + 100 * SILENCE;
        let has_room = |connections: &mut Connections<Wire>| {
            connections.make_room(Some(HERE), &mut Echo::default(), late)
        };
        assert_eq!([has_room(&mut connections), has_room(&mut connections)], [true, false]);
        assert_eq!(connections.len(), 1, "only the other one is closed");
        connections.serve(&mut Echo { due: Some(client), ..Echo::default() }, late);
        assert!(waiting.sent().ends_with(b"\x01\0\0\x05later"));
        assert!(has_room(&mut connections));
        connections.serve(&mut Echo { due: Some(client), ..Echo::default() }, late);
    }

    #[test]
    fn clients_take_turns() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let wires = [(); 2].map(|()| Wire::new(&REQUEST.repeat(100)));
        for wire in &wires {
            add(&mut connections, wire, start);
        }
        let handshake = GREETING.len() + READY.len();
        for requests in 1..=20 {
            connections.serve(&mut Echo::default(), start);
            let sent = wires.each_ref().map(|wire| wire.sent().len() - handshake);
            assert_eq!(sent, [requests * REQUEST.len(); 2]);
        }
        let (mut connections, wire) = (Connections::new(CONFIG), Wire::new(&REQUEST.repeat(100)));
        add(&mut connections, &wire, start);
        connections.serve(&mut Echo::default(), start);
        assert_eq!(wire.sent().len() - handshake, MAX_REQUESTS_IN_A_ROW * REQUEST.len());
    }

    #[test]
    fn replies_are_flushed_and_failed_connections_dropped() {
        let (start, mut connections) = (Instant::now(), Connections::new(CONFIG));
        let wire = Wire::new(REQUEST);
        wire.set_capacity(91);
        let id = add(&mut connections, &wire, start);
        serve(&mut connections, start);
        assert!(connections.flush());
        wire.set_capacity(100);
        connections.set_ready(id, false, true, start);
        assert!(!connections.flush() && !connections.is_busy());
        assert!(wire.sent().ends_with(REQUEST));
        let failed = Wire::new(REQUEST);
        failed.set_capacity(91);
        let id = add(&mut connections, &failed, start);
        serve(&mut connections, start);
        connections.set_ready(id, false, true, start);
        failed.fail([std::io::ErrorKind::BrokenPipe]);
        assert!(!connections.flush());
        assert_eq!(connections.len(), 1);
    }
}
