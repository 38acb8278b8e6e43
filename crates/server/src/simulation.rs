//! Turns the bytes of a request into the bytes of its reply.

use std::fmt;
use std::io::Write;

use mmsim_maze::{Cell, Maze, Misreadings, Pose, WallSensor, WallsAround};
use mmsim_protocol::{Annotation, CRASH_PREFIX, ERROR_PREFIX, Info, Reply, Request};
use mmsim_recording::{History, PushError, TrailingAnnotations, UpdateTracker};
use mmsim_zmtp::ClientId;

/// The true maze and every state that a client has reported since the last reset.
#[derive(Debug)]
pub struct Simulation {
    name: String,
    maze: Maze,
    pub(crate) history: History,
    updates: UpdateTracker,
    sensor: WallSensor,
    /// The cell of the newest state, or `None` if the mouse may have been put elsewhere since.
    at: Option<Cell>,
}

/// The reason for refusing a request of a mouse that a wall has blocked.
#[derive(Debug, thiserror::Error)]
#[error("{CRASH_PREFIX}there is a wall between {from} and {to}")]
struct Blocked {
    from: Cell,
    to: Cell,
}

impl Simulation {
    /// Creates a simulation of this maze with an empty history. The reply to `info` contains
    /// `name`.
    pub fn new(name: &str, maze: Maze) -> Self {
        let history = History::new(maze.size());
        let sensor = WallSensor::new(Misreadings::default(), &maze);
        let updates = UpdateTracker::default();
        Self { name: name.into(), maze, history, updates, sensor, at: None }
    }

    /// Lets the mouse misread walls. It then learns from an error reply if a wall blocks it: its
    /// requests from a neighbouring cell of its newest state are refused.
    #[must_use]
    pub fn with_misreadings(mut self, misreadings: Misreadings) -> Self {
        self.sensor = WallSensor::new(misreadings, &self.maze);
        self
    }

    /// Changes how the mouse misreads walls from now on.
    pub(crate) fn set_misreadings(&mut self, misreadings: Misreadings) {
        self.sensor = WallSensor::new(misreadings, &self.maze);
    }

    /// Returns the misreadings.
    pub const fn misreadings(&self) -> Misreadings {
        *self.sensor.misreadings()
    }

    /// Limits the history to this number of bytes. At the limit, further states are refused and
    /// earlier states are kept.
    #[must_use]
    pub fn with_history_limit(mut self, bytes: usize) -> Self {
        self.history = History::with_limit(self.maze.size(), bytes);
        self
    }

    /// Returns the true maze.
    pub const fn maze(&self) -> &Maze {
        &self.maze
    }

    /// Returns the states since the last reset.
    pub const fn history(&self) -> &History {
        &self.history
    }

    /// Returns the annotations after the newest state.
    pub fn trailing(&self) -> TrailingAnnotations {
        self.updates.trailing()
    }

    /// Answers one request of the only client, like [`handle_from`](Self::handle_from).
    pub fn handle(&mut self, request: &[u8], reply: &mut ReplyBuffer) -> Change {
        self.handle_from(None, request, reply)
    }

    /// Answers one request and returns the change to the run. Every request gets exactly one reply.
    /// Only `reset` and valid states change the history. Each connection has a limit of annotations.
    pub fn handle_from(
        &mut self,
        client: Option<ClientId>,
        request: &[u8],
        reply: &mut ReplyBuffer,
    ) -> Change {
        match Request::decode(request, self.maze.size()) {
            Ok(Request::Ping) => set(reply, Reply::Pong),
            Ok(Request::Reset) => {
                self.history.clear();
                self.updates.clear();
                self.sensor.restart();
                self.at = None;
                set(reply, Reply::Ok);
                return Change::Reset;
            }
            Ok(Request::Walls(pose)) => match self.read_walls(pose) {
                Ok(around) => {
                    self.updates.read(pose);
                    set(reply, Reply::Walls(around));
                }
                Err(blocked) => refuse(reply, blocked),
            },
            Ok(Request::State(state)) => {
                let cell = state.pose().cell;
                if let Err(blocked) = self.check_movement(cell) {
                    refuse(reply, blocked);
                    return Change::Nothing;
                }
                match self.push(request) {
                    Ok(()) => {
                        self.at = Some(cell);
                        set(reply, Reply::Ok);
                        return Change::State;
                    }
                    Err(error) => refuse(reply, error),
                }
            }
            Ok(Request::Annotations(list)) => {
                match self.updates.annotate_from(client.map(u64::from), list) {
                    Ok(()) => {
                        if list.iter().any(|one| one == Annotation::Restart) {
                            self.at = None;
                        }
                        set(reply, Reply::Ok);
                        return Change::Annotations;
                    }
                    Err(error) => refuse(reply, error),
                }
            }
            Ok(Request::Info) => match serde_json::to_string(&self.info()) {
                Ok(json) => set(reply, Reply::Info(&json)),
                Err(error) => refuse(reply, error),
            },
            Ok(_) => refuse(reply, "unsupported request"),
            Err(error) => refuse(reply, error),
        }
        Change::Nothing
    }

    /// Answers one request of a client that may only read, and whose readings are not recorded.
    /// Refuses other requests for this reason.
    pub(crate) fn read(&mut self, request: &[u8], reason: &str, reply: &mut ReplyBuffer) {
        match Request::decode(request, self.maze.size()) {
            Ok(Request::Walls(pose)) => {
                let around = self.sensor.clone().around(self.maze.walls(), pose);
                set(reply, Reply::Walls(around));
            }
            Ok(other) if other.is_write() => refuse(reply, reason),
            _ => {
                self.handle(request, reply);
            }
        }
    }

    /// Reads the walls around a mouse that has moved to this pose from that of its newest state.
    fn read_walls(&mut self, pose: Pose) -> Result<WallsAround, Blocked> {
        self.check_movement(pose.cell)?;
        Ok(self.sensor.around(self.maze.walls(), pose))
    }

    /// Returns an error if a wall blocks a mouse that misreads walls.
    fn check_movement(&self, to: Cell) -> Result<(), Blocked> {
        match self.at.filter(|_| !self.sensor.is_exact()) {
            Some(from) if self.maze.walls().separate(from, to) => Err(Blocked { from, to }),
            _ => Ok(()),
        }
    }

    fn push(&mut self, state: &[u8]) -> Result<(), PushError> {
        self.history.push_with_update(self.updates.update(), state)?;
        self.updates.report();
        Ok(())
    }

    /// Removes the newest state, which could not be recorded. Works only directly after the request
    /// that added the state.
    pub(crate) fn undo_state(&mut self) {
        self.history.undo_push();
        self.updates.undo_report();
        self.at = None;
    }

    /// Removes the annotations of a request, which could not be recorded. Works only directly after
    /// the request.
    pub(crate) fn undo_annotations(&mut self, client: Option<ClientId>, request: &[u8]) {
        if let Ok(Request::Annotations(list)) = Request::decode(request, self.maze.size()) {
            self.updates.undo_annotate_from(client.map(u64::from), list);
        }
    }

    /// Returns the reply to `info`.
    pub fn info(&self) -> Info {
        let Self { name, maze, history, .. } = self;
        Info::new(name, maze.size(), maze.start(), maze.goals(), history.len())
    }
}

/// The change that a request makes to a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// No change.
    Nothing,
    /// A state was added.
    State,
    /// Annotations were added.
    Annotations,
    /// All states were deleted.
    Reset,
}

/// The buffer into which a simulation writes its reply, overwriting earlier contents.
pub type ReplyBuffer = Vec<u8>;

fn set(buffer: &mut ReplyBuffer, reply: Reply<'_>) {
    buffer.resize(reply.len(), 0);
    // Encoding cannot fail, because the buffer is as long as the reply.
    let _ = reply.encode(buffer);
}

/// Writes an error reply.
pub(crate) fn refuse(buffer: &mut ReplyBuffer, reason: impl fmt::Display) {
    buffer.clear();
    // Writing into a vector cannot fail.
    let _ = write!(buffer, "{ERROR_PREFIX}{reason}");
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{MazeSize, Pose, Walls, WallsAround};
    use mmsim_protocol::{Cell, Heading, KnownMaze, MAX_STATE_BYTES, MapState, Order};
    use proptest::prelude::*;

    use super::*;

    fn simulation(size: MazeSize) -> Simulation {
        let maze = Maze::new(Walls::open(size), Cell::new(0, 0), size.central_cells()).unwrap();
        Simulation::new("open", maze)
    }

    fn reply(simulation: &mut Simulation, request: &[u8]) -> Vec<u8> {
        let mut reply = vec![0xa5; 7];
        simulation.handle(request, &mut reply);
        reply
    }

    fn state(size: MazeSize, pose: Pose, weight: u16) -> Vec<u8> {
        let map = KnownMaze::new(size, pose.cell, size.central_cells());
        let mut buffer = [0; MAX_STATE_BYTES];
        let length = MapState::new(pose, &map, |_| weight, Order::C).encode(&mut buffer).unwrap();
        buffer[..length].to_vec()
    }

    #[test]
    fn each_request_gets_its_reply() {
        let mut simulation = simulation(MazeSize::CLASSIC);
        let start = Pose::new(Cell::new(0, 0), Heading::North);
        assert_eq!(reply(&mut simulation, b"ping"), b"pong");
        let around = WallsAround { left: true, front: false, right: false };
        assert_eq!(Reply::decode(&reply(&mut simulation, b"W\x00\x00N")), Ok(Reply::Walls(around)));
        for number in 0..3 {
            let state = state(MazeSize::CLASSIC, start, number);
            assert_eq!(reply(&mut simulation, &state), b"ok");
            assert_eq!(simulation.history().get(number.into()), Some(state));
        }
        let info: Info = serde_json::from_slice(&reply(&mut simulation, b"info")).unwrap();
        assert_eq!((info.maze.as_str(), info.states), ("open", 3));
        assert_eq!(reply(&mut simulation, b"reset"), b"ok");
        assert!(simulation.history().is_empty());
    }

    #[test]
    fn full_history_refuses_states_only() {
        let size = MazeSize::CLASSIC;
        let mut simulation = simulation(size).with_history_limit(1100);
        let state = state(size, Pose::new(Cell::new(0, 0), Heading::North), 1);
        let mut buffer = ReplyBuffer::new();
        assert_eq!(simulation.handle(&state, &mut buffer), Change::State);
        assert_eq!(reply(&mut simulation, &state), b"ok");
        for _ in 0..3 {
            assert_eq!(simulation.handle(&state, &mut buffer), Change::Nothing);
            assert!(buffer.starts_with(
                b"error: cannot store another state: history limit of 0 MiB reached after 2 "
            ));
            assert_eq!(simulation.history().len(), 2);
            assert_eq!(reply(&mut simulation, b"ping"), b"pong");
        }
        assert_eq!(simulation.handle(b"reset", &mut buffer), Change::Reset);
        assert_eq!(reply(&mut simulation, &state), b"ok");
    }

    #[test]
    fn readings_belong_to_the_next_stored_state() {
        let size = MazeSize::CLASSIC;
        let mut simulation = simulation(size).with_history_limit(2000);
        let pose = |y| Pose::new(Cell::new(0, y), Heading::East);
        let report = |simulation: &mut Simulation, y| {
            let reply = reply(simulation, &state(size, pose(y), 1));
            (reply == b"ok").then(|| simulation.history().newest_update().to_vec())
        };
        assert_eq!(report(&mut simulation, 0).unwrap(), b"U");
        reply(&mut simulation, b"W\x00\x01E");
        reply(&mut simulation, b"W\x00\x05E");
        for _ in 0..3 {
            assert_eq!(report(&mut simulation, 1).unwrap(), b"R\x00\x05E");
            simulation.undo_state();
        }
        assert_eq!(report(&mut simulation, 1).unwrap(), b"R\x00\x05E");
        assert_eq!(report(&mut simulation, 5).unwrap(), b"");
        simulation.undo_state();
        reply(&mut simulation, b"W\x00\x01E");
        assert_eq!(report(&mut simulation, 7).unwrap(), b"N");
        reply(&mut simulation, b"W\x00\x07E");
        assert_eq!(report(&mut simulation, 7), None, "the history is full");
        reply(&mut simulation, b"reset");
        assert_eq!(report(&mut simulation, 7).unwrap(), b"U");
    }

    #[test]
    fn annotations_belong_to_the_next_stored_state() {
        let size = MazeSize::CLASSIC;
        let mut simulation = simulation(size).with_history_limit(2000);
        let state = state(size, Pose::new(Cell::new(0, 0), Heading::North), 1);
        let text = |simulation: &Simulation, index| {
            let context = simulation.history().context(index).unwrap();
            context.notes().text(Cell::new(1, 2)).to_string()
        };
        assert!(simulation.info().has_annotations());
        assert_eq!(reply(&mut simulation, b"AT\x01\x02\x01aM\x07Theseus"), b"ok");
        assert!(reply(&mut simulation, b"AT\x01\x02\x01xT\x01").starts_with(b"error: expected "));
        assert!(reply(&mut simulation, &[b'S'; 517]).starts_with(b"error: "));
        assert_eq!(reply(&mut simulation, &state), b"ok");
        assert_eq!(text(&simulation, 0), "a");
        assert_eq!(reply(&mut simulation, b"AT\x01\x02\x01b"), b"ok");
        assert_eq!(text(&simulation, 0), "a");
        for _ in 0..2 {
            assert_eq!(reply(&mut simulation, &state), b"ok");
            assert_eq!(text(&simulation, 1), "b");
            simulation.undo_state();
        }
        assert_eq!(reply(&mut simulation, &state), b"ok");
        assert_eq!([0, 1].map(|index| text(&simulation, index)), ["a", "b"]);
        assert_eq!(reply(&mut simulation, &state), b"ok");
        assert!(reply(&mut simulation, &state).starts_with(b"error: "), "the history is full");
        assert_eq!(reply(&mut simulation, b"AT\x01\x02\x01c"), b"ok");
        assert_eq!(reply(&mut simulation, b"reset"), b"ok");
        assert_eq!(reply(&mut simulation, &state), b"ok");
        assert!(simulation.history().context(0).unwrap().notes().is_empty());
    }

    #[test]
    fn annotations_trail_until_the_next_state() {
        let size = MazeSize::CLASSIC;
        let mut simulation = simulation(size);
        let state = state(size, Pose::new(Cell::new(0, 0), Heading::North), 1);
        let lines = |simulation: &Simulation| simulation.trailing().log_lines(1).count();
        for request in [&state[..], b"reset"] {
            assert_eq!(reply(&mut simulation, &state), b"ok");
            for count in 1..=3 {
                assert_eq!(reply(&mut simulation, b"AL\x01\0a"), b"ok");
                assert_eq!(lines(&simulation), count);
            }
            simulation.undo_annotations(None, b"AL\x01\0a");
            assert_eq!(lines(&simulation), 2);
            assert_eq!(reply(&mut simulation, request), b"ok");
            assert_eq!(lines(&simulation), 0);
        }
    }

    #[test]
    fn pending_annotations_are_limited() {
        let mut simulation = simulation(MazeSize::CLASSIC);
        let line = [&b"AL\xe8\x03"[..], &[b'x'; 1000]].concat();
        let state = state(MazeSize::CLASSIC, Pose::new(Cell::new(0, 0), Heading::North), 1);
        let (mut error, mut lines) = (ReplyBuffer::new(), 0);
        for (states, end) in [&state[..], b"reset", &state].into_iter().enumerate() {
            let clients = [None].into_iter().chain((0..5).map(|_| Some(ClientId::unique())));
            let counts = clients.map(|client| {
                let mut send = || simulation.handle_from(client, &line, &mut error);
                let count = (0..1000).take_while(|_| send() == Change::Annotations).count();
                assert!(error.starts_with(b"error: cannot store more annotations "));
                count
            });
            let counts: Vec<_> = counts.collect();
            assert_eq!(counts, [65, 65, 65, 65, 1, 0], "after {states} ends");
            lines = counts.iter().sum();
            assert_eq!(reply(&mut simulation, end), b"ok");
        }
        assert_eq!(simulation.history().log(0, 1000, |_| true).len(), lines);
        assert_eq!(reply(&mut simulation, &line), b"ok");
    }

    #[test]
    fn a_mouse_that_misreads_walls_is_blocked_by_a_wall() {
        let size = MazeSize::CLASSIC;
        let maze = Maze::new(Walls::closed(size), Cell::new(0, 0), size.central_cells()).unwrap();
        let state = |y| state(size, Pose::new(Cell::new(0, y), Heading::North), 1);
        let never = Misreadings { probability: f64::MIN_POSITIVE, ..Misreadings::default() };
        let mut simulation = Simulation::new("closed", maze.clone()).with_misreadings(never);
        let blocked = b"error: crash: there is a wall between (0, 0) and (0, 1)";
        assert_eq!(reply(&mut simulation, b"W\x00\x01N"), [1, 1, 1], "its place is unknown");
        assert_eq!(reply(&mut simulation, &state(0)), b"ok");
        for _ in 0..2 {
            assert_eq!(reply(&mut simulation, b"W\x00\x01N"), blocked);
            assert_eq!(reply(&mut simulation, &state(1)), blocked);
            assert_eq!(simulation.history().len(), 1);
        }
        for request in [&b"reset"[..], b"AR"] {
            assert_eq!(reply(&mut simulation, &state(0)), b"ok");
            assert_eq!(reply(&mut simulation, request), b"ok");
            assert_eq!(reply(&mut simulation, &state(1)), b"ok", "it was put elsewhere");
            assert_eq!(reply(&mut simulation, b"reset"), b"ok");
        }
        let mut exact = Simulation::new("closed", maze);
        for y in 0..3 {
            assert_eq!(reply(&mut exact, &state(y)), b"ok", "what a mouse believes is stored");
        }
    }

    #[test]
    fn a_client_that_may_only_read_does_not_change_the_readings() {
        let half = Misreadings { probability: 0.5, seed: 1, are_fixed: false };
        let size = MazeSize::CLASSIC;
        let readings = |is_disturbed: bool| {
            let mut simulation = self::simulation(size).with_misreadings(half);
            let mut other = ReplyBuffer::new();
            [(); 50].map(|()| {
                if is_disturbed {
                    simulation.read(b"W\x03\x03N", "", &mut other);
                }
                reply(&mut simulation, b"W\x04\x04N")
            })
        };
        assert_eq!(readings(true), readings(false));
    }

    #[test]
    fn state_length_depends_on_the_maze_size() {
        let mut simulation = simulation(MazeSize::new(21, 21).unwrap());
        assert_eq!(reply(&mut simulation, b"W\x14\x14N"), [0, 1, 1]);
        assert!(reply(&mut simulation, b"W\x15\x14N").starts_with(b"error: "));
        let error = reply(&mut simulation, &[b'S'; 518]);
        insta::assert_snapshot!(String::from_utf8(error).unwrap(), @"error: expected a state of 888 bytes for a maze of 21x21 cells, found 518 bytes");
    }

    proptest! {
        #[test]
        fn any_request_gets_one_reply_and_errors_change_nothing(
            (width, height) in (1usize..=32, 1usize..=32),
            requests in prop::collection::vec(
                prop_oneof![
                    prop::collection::vec(any::<u8>(), 0..600),
                    prop::collection::vec(any::<u8>(), 0..5).prop_map(|rest| [vec![b'W'], rest].concat()),
                    (0u8..40, 0u8..40, 0usize..4).prop_map(|(x, y, heading)| {
                        vec![b'W', x, y, b"NESW"[heading]]
                    }),
                    Just(b"ping".to_vec()),
                    Just(b"info".to_vec()),
                ],
                1..20,
            ),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let mut simulation = simulation(size);
            let start = state(size, Pose::new(Cell::new(0, 0), Heading::North), 1);
            prop_assert_eq!(reply(&mut simulation, &start), b"ok");
            for request in requests {
                let reply = reply(&mut simulation, &request);
                let valid = Request::decode(&request, size).is_ok();
                let decoded = Reply::decode(&reply);
                prop_assert!(decoded.is_ok(), "{:?}", decoded);
                prop_assert_eq!(valid, !matches!(decoded, Ok(Reply::Error(_))));
                prop_assert_eq!(simulation.history().len(), 1);
            }
            prop_assert_eq!(simulation.history().get(0), Some(start));
        }
    }
}
