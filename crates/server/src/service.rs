//! Serves a simulation, and keeps the time of each state and the recording of the states.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;

use mmsim_maze::Maze;
use mmsim_protocol::{ERROR_PREFIX, RequestError};
use mmsim_recording::{Clock, PushError, Recorder, Times};
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, Service};
use tracing::{debug, info, warn};

use crate::control::{Control, MAX_RUN, Status};
use crate::monitor::Query;
use crate::simulation::{Change, ReplyBuffer, Simulation, refuse};

/// The resolution of the times of live states, in nanoseconds.
const TICK_NS: u64 = 1000;

/// The reason for refusing a client that may only read.
const RESERVED: &str = "the simulator is running a mouse, and only the connection of this mouse may send reset, S and A (try again after its run)";

/// The maximum number of queries from monitors that run before the server answers clients again.
const MAX_QUERIES_AT_ONCE: usize = 4;

/// A simulation that answers the requests of clients and the queries of monitors.
pub(crate) struct SimulationService<'s> {
    pub(crate) simulation: &'s mut Simulation,
    pub(crate) times: Times,
    pub(crate) run: u32,
    recorder: Option<Recorder>,
    clock: Clock,
    refused: u64,
    /// The connected clients that have searched the maze.
    clients: BTreeSet<ClientId>,
    /// The client that has sent the newest request of a search.
    newest_client: Option<ClientId>,
    queries: &'s Receiver<Query>,
    control: &'s Control,
}

impl<'s> SimulationService<'s> {
    pub(crate) fn new(
        simulation: &'s mut Simulation,
        recorder: Option<Recorder>,
        queries: &'s Receiver<Query>,
        control: &'s Control,
    ) -> Self {
        let (clock, times) = (Clock::start(), Times::new(TICK_NS));
        control.is_recorded.store(recorder.is_some(), Ordering::Release);
        let service = Self {
            simulation,
            times,
            run: 1,
            recorder,
            clock,
            refused: 0,
            clients: BTreeSet::new(),
            newest_client: None,
            queries,
            control,
        };
        service.publish_status();
        service
    }

    /// Replaces the maze and begins a new run with the same history limit.
    pub(crate) fn replace_maze(&mut self, name: &str, maze: Maze) -> Status {
        let limit = self.simulation.history.limit();
        let misreadings = self.simulation.misreadings();
        let simulation = Simulation::new(name, maze).with_misreadings(misreadings);
        *self.simulation = simulation.with_history_limit(limit);
        self.control.has_client_states.store(false, Ordering::Release);
        self.begin_run()
    }

    /// Closes the recording and waits for the recorder to finish.
    pub(crate) fn finish(mut self) {
        self.close_recording();
        if let Some(recorder) = self.recorder {
            recorder.finish();
        }
        let states = self.simulation.history().len();
        info!(states, refused = self.refused, "stopped");
    }

    /// Stores the time of the newest state and records the state. Returns an error message if the
    /// time cannot be stored or the state cannot be recorded.
    fn keep_state(&mut self, request: &[u8]) -> Result<(), String> {
        let (simulation, times) = (&*self.simulation, &mut self.times);
        let (states, limit) = (simulation.history.len() - 1, simulation.history.limit());
        let out_of_memory = |_| PushError::OutOfMemory { states }.to_string();
        times.push(self.clock.now()).map_err(out_of_memory)?;
        let result = if simulation.history.bytes() + times.bytes() > limit {
            Err(PushError::Full { limit, states }.to_string())
        } else if let Some(recorder) = &mut self.recorder {
            let describe = || (simulation.info(), simulation.maze());
            let update = simulation.history.newest_update();
            recorder.write(update, request, describe).map_err(|error| error.to_string())
        } else {
            Ok(())
        };
        if result.is_err() {
            times.undo_push();
        }
        result
    }

    /// Records annotations. Returns an error message if they cannot be recorded.
    fn keep_annotations(&mut self, request: &[u8]) -> Result<(), String> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        recorder.write_annotations(request).map_err(|error| error.to_string())
    }

    fn begin_run(&mut self) -> Status {
        self.close_recording();
        self.times = Times::new(TICK_NS);
        self.run = if self.run == MAX_RUN { 1 } else { self.run + 1 };
        info!(run = self.run, "reset");
        self.publish_status()
    }

    fn close_recording(&mut self) {
        if let Some(Err(error)) = self.recorder.as_mut().map(Recorder::close) {
            warn!("cannot close a recording (its states are readable): {error}");
        }
    }

    /// Returns true if a connected client has searched the maze.
    pub(crate) fn has_client(&self) -> bool {
        !self.clients.is_empty()
    }

    fn add_client(&mut self, client: ClientId) {
        if self.newest_client != Some(client) {
            self.newest_client = Some(client);
            self.clients.insert(client);
            self.control.has_client.store(true, Ordering::Release);
        }
    }

    pub(crate) fn remove_client(&mut self, client: ClientId) {
        if self.clients.remove(&client) {
            self.newest_client = None;
            self.control.has_client.store(self.has_client(), Ordering::Release);
        }
    }

    fn publish_status(&self) -> Status {
        let status = Status { run: self.run, states: self.simulation.history.len() };
        self.control.status.write(status);
        status
    }

    /// Answers a request of a client, or of this program if `client` is `None`. Returns true if the
    /// request counts as activity, which keeps a connection open when the server is full. `ping` and
    /// refused requests do not count, because a client can send them forever without searching the
    /// maze.
    pub(crate) fn answer_request(
        &mut self,
        client: Option<ClientId>,
        request: &[u8],
        frames: usize,
        reply: &mut ReplyBuffer,
    ) -> bool {
        let is_reserved = client.is_some() && self.control.is_reserved.load(Ordering::Acquire);
        let is_search = !is_reserved && !matches!(request, b"ping" | b"info");
        if is_reserved && frames == 1 {
            self.simulation.read(request, RESERVED, reply);
        } else if frames == 1 {
            let change = self.simulation.handle_from(client, request, reply);
            if matches!(change, Change::State | Change::Reset) {
                self.control.has_client_states.store(client.is_some(), Ordering::Release);
            }
            match change {
                Change::Nothing => {}
                Change::Reset => {
                    self.begin_run();
                }
                Change::Annotations => {
                    if let Err(reason) = self.keep_annotations(request) {
                        self.simulation.undo_annotations(client, request);
                        refuse(reply, reason);
                    }
                    self.control.annotations.fetch_add(1, Ordering::Release);
                }
                Change::State => {
                    // A state that cannot be recorded is removed from the history.
                    if let Err(reason) = self.keep_state(request) {
                        self.simulation.undo_state();
                        refuse(reply, reason);
                    }
                    self.publish_status();
                }
            }
        } else {
            refuse(reply, RequestError::Frames { found: frames });
        }
        let Some(reason) = reply.strip_prefix(ERROR_PREFIX.as_bytes()) else {
            if let Some(client) = client
                && is_search
            {
                self.add_client(client);
            }
            return *reply != *b"pong";
        };
        let reason = String::from_utf8_lossy(reason);
        self.refused += 1;
        // Only the first refusal is a warning, so a faulty client cannot fill the log.
        if self.refused == 1 {
            warn!("refused a request: {reason} (further refusals are logged at level debug)");
        } else {
            debug!("refused a request: {reason}");
        }
        false
    }
}

impl Service for SimulationService<'_> {
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut ReplyBuffer,
    ) -> Answer {
        Answer::Reply { is_activity: self.answer_request(Some(client), request, frames, reply) }
    }

    fn disconnected(&mut self, client: ClientId) {
        self.remove_client(client);
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut ReplyBuffer) {
        refuse(reply, reason);
    }

    fn after_round(&mut self) {
        for count in 1..=MAX_QUERIES_AT_ONCE {
            let Ok(query) = self.queries.try_recv() else { break };
            query(self);
            if count == MAX_QUERIES_AT_ONCE {
                // Without another wake-up, further queries would wait for the next request.
                self.control.waker.wake();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::Server;

    #[test]
    fn times_count_toward_the_history_limit() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze).with_history_limit(100_000);
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (status, queries) = (&server.control.status, &server.queries.1);
        let mut service = SimulationService::new(&mut simulation, None, queries, &server.control);
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        let kept = (0..200_000).take_while(|_| {
            service.answer_request(None, state, 1, &mut reply);
            reply == b"ok"
        });
        let kept = kept.count();
        assert!((10_000..100_000).contains(&kept), "{kept} states");
        assert!(reply.starts_with(
            b"error: cannot store another state: history limit of 0 MiB reached after "
        ));
        assert_eq!(status.read(), Status { run: 1, states: kept });
        assert_eq!(service.times.len(), kept);
        service.answer_request(None, b"reset", 1, &mut reply);
        service.answer_request(None, state, 1, &mut reply);
        assert_eq!(reply, b"ok");
    }

    #[test]
    fn pings_and_refused_requests_are_no_activity() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze);
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let queries = &server.queries.1;
        let mut service = SimulationService::new(&mut simulation, None, queries, &server.control);
        let state: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";
        let mut is_activity = |request: &[u8], frames| {
            service.answer_request(None, request, frames, &mut ReplyBuffer::new())
        };
        for request in [b"W\x00\x00N", state, b"info", b"reset"] {
            assert!(is_activity(request, 1), "{}", request.escape_ascii());
            assert!(!is_activity(request, 2), "{}", request.escape_ascii());
        }
        for request in [&b"ping"[..], b"", b"W\x09\x00N", b"pong", &state[1..]] {
            assert!(!is_activity(request, 1), "{}", request.escape_ascii());
        }
    }

    #[test]
    fn each_reset_and_each_maze_begins_a_run() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze.clone());
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (status, queries) = (&server.control.status, &server.queries.1);
        let mut service = SimulationService::new(&mut simulation, None, queries, &server.control);
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        service.answer_request(None, state, 1, &mut reply);
        service.answer_request(None, b"ping", 1, &mut reply);
        service.answer_request(None, state, 2, &mut reply);
        assert_eq!(status.read(), Status { run: 1, states: 1 });
        assert_eq!(service.times.len(), 1);
        service.answer_request(None, b"reset", 1, &mut reply);
        assert_eq!(status.read(), Status { run: 2, states: 0 });
        assert_eq!(service.times.len(), 0);
        service.answer_request(None, state, 1, &mut reply);
        assert_eq!(service.replace_maze("other", maze), Status { run: 3, states: 0 });
        assert_eq!(service.simulation.info().maze, "other");
        service.run = MAX_RUN;
        service.answer_request(None, b"reset", 1, &mut reply);
        assert_eq!(status.read().run, 1);
    }
}
