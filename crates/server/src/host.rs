//! What the thread of a server works on: the simulation and all that follows it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mmsim_maze::Maze;
use mmsim_protocol::{ERROR_PREFIX, RequestError};
use mmsim_recording::{Clock, HistoryFull, PushError, Recorder, Times};
use tracing::{debug, info, warn};

use crate::simulation::refuse;
use crate::{Change, ReplyBuffer, Simulation};

/// A simulation, served.
pub(crate) struct Host<'s> {
    simulation: &'s mut Simulation,
    recorder: Option<Recorder>,
    clock: Clock,
    times: Times,
    run: u32,
    board: Arc<Board>,
    refused: u64,
}

/// Where a server tells anybody who looks how many states there are, and of which run.
#[derive(Debug, Default)]
pub(crate) struct Board(AtomicU64);

/// How many states there are, and of which run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// The number of the run: the first is 1, and each reset and each maze begins another.
    pub run: u32,
    /// How many states it has.
    pub states: usize,
}

/// Bits for the number of states, which leaves 24 for that of the run.
const STATES_BITS: u32 = 40;

/// Live times are kept to the microsecond, in nanoseconds.
const TICK_NS: u64 = 1000;

/// The largest number of a run; the next one is 1 again.
const LAST_RUN: u32 = (1 << (64 - STATES_BITS)) - 1;

impl Board {
    pub(crate) fn read(&self) -> Status {
        let both = self.0.load(Ordering::Acquire);
        let states = both & ((1 << STATES_BITS) - 1);
        Status {
            run: u32::try_from(both >> STATES_BITS).unwrap_or(LAST_RUN),
            states: usize::try_from(states).unwrap_or(usize::MAX),
        }
    }

    fn write(&self, Status { run, states }: Status) {
        self.0.store((u64::from(run) << STATES_BITS) | states as u64, Ordering::Release);
    }
}

impl<'s> Host<'s> {
    pub(crate) fn new(
        simulation: &'s mut Simulation,
        recorder: Option<Recorder>,
        board: Arc<Board>,
    ) -> Self {
        let (clock, times) = (Clock::start(), Times::new(TICK_NS));
        let host = Self { simulation, recorder, clock, times, run: 1, board, refused: 0 };
        host.tell();
        host
    }

    /// Answers a request of so many frames. Returns whether it is worth a place: whether the sender
    /// searches the maze, rather than only keeping its connection.
    pub(crate) fn answer(
        &mut self,
        request: &[u8],
        frames: usize,
        reply: &mut ReplyBuffer,
    ) -> bool {
        if frames == 1 {
            let change = self.simulation.handle(request, reply);
            self.follow(change, request, reply);
        } else {
            refuse(reply, RequestError::Frames { found: frames });
        }
        if let Some(reason) = reply.strip_prefix(ERROR_PREFIX.as_bytes()) {
            self.refused += 1;
            log_refusal(&String::from_utf8_lossy(reason), self.refused);
            return false;
        }
        *reply != *b"pong"
    }

    /// Serves this maze from now on.
    pub(crate) fn serve(&mut self, name: &str, maze: Maze) -> Status {
        self.simulation.replace(name, maze);
        self.begin_run();
        self.status()
    }

    pub(crate) fn simulation(&self) -> &Simulation {
        self.simulation
    }

    pub(crate) fn times(&self) -> &Times {
        &self.times
    }

    pub(crate) fn status(&self) -> Status {
        Status { run: self.run, states: self.simulation.history().len() }
    }

    /// Ends what follows the simulation.
    pub(crate) fn end(mut self) {
        self.close_recording();
        if let Some(recorder) = self.recorder {
            recorder.finish();
        }
        let states = self.simulation.history().len();
        info!(states, refused = self.refused, "stopped");
    }

    /// Lets all follow what a request has changed. A state that cannot be recorded is taken back.
    fn follow(&mut self, change: Change, request: &[u8], reply: &mut ReplyBuffer) {
        match change {
            Change::Nothing => {}
            Change::Reset => self.begin_run(),
            Change::State => {
                if let Err(reason) = self.follow_state(request) {
                    self.simulation.take_back();
                    refuse(reply, reason);
                }
                self.tell();
            }
        }
    }

    /// Keeps the time of the newest state and records it, or says why it cannot stay.
    fn follow_state(&mut self, request: &[u8]) -> Result<(), String> {
        let history = self.simulation.history();
        let (states, limit) = (history.len() - 1, history.limit());
        if self.times.push(self.clock.now()).is_err() {
            return Err(PushError::OutOfMemory { states }.to_string());
        }
        let kept = if history.bytes() + self.times.bytes() > limit {
            Err(HistoryFull { limit, states }.to_string())
        } else {
            let follow = |recorder: &mut Recorder| {
                let describe = || (self.simulation.info(), self.simulation.maze());
                recorder.write(request, describe).map_err(|e| e.to_string())
            };
            self.recorder.as_mut().map_or(Ok(()), follow)
        };
        if kept.is_err() {
            self.times.undo_push();
        }
        kept
    }

    fn begin_run(&mut self) {
        self.close_recording();
        self.times = Times::new(TICK_NS);
        self.run = if self.run == LAST_RUN { 1 } else { self.run + 1 };
        info!(run = self.run, "reset");
        self.tell();
    }

    fn close_recording(&mut self) {
        if let Some(Err(error)) = self.recorder.as_mut().map(Recorder::close) {
            warn!("cannot close a recording, whose states can be read nevertheless: {error}");
        }
    }

    fn tell(&self) {
        self.board.write(self.status());
    }
}

/// The first refusal is worth a warning; a client that goes on like that shall not fill the log.
fn log_refusal(reason: &str, refused: u64) {
    if refused == 1 {
        warn!("refused a request: {reason} (further ones are logged at level debug)");
    } else {
        debug!("refused a request: {reason}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_shows_what_is_written() {
        let board = Board::default();
        for status in [(1, 0), (7, 412), (LAST_RUN, (1 << STATES_BITS) - 1)] {
            let status = Status { run: status.0, states: status.1 };
            board.write(status);
            assert_eq!(board.read(), status);
        }
    }

    #[test]
    fn times_count_for_the_limit() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze).with_history_limit(100_000);
        let board: Arc<Board> = Arc::default();
        let mut host = Host::new(&mut simulation, None, Arc::clone(&board));
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        let kept = (0..200_000).take_while(|_| {
            host.answer(state, 1, &mut reply);
            reply == b"ok"
        });
        let kept = kept.count();
        assert!((10_000..100_000).contains(&kept), "{kept} states");
        assert!(reply.starts_with(
            b"error: cannot store another state: history limit of 0 MiB reached after "
        ));
        assert_eq!(board.read(), Status { run: 1, states: kept });
        assert_eq!(host.times().len(), kept);
        host.answer(b"reset", 1, &mut reply);
        host.answer(state, 1, &mut reply);
        assert_eq!(reply, b"ok");
    }

    #[test]
    fn runs_are_counted_from_reset_to_reset() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let (mut simulation, board) = (Simulation::new("small", maze.clone()), Arc::default());
        let mut host = Host::new(&mut simulation, None, Arc::clone(&board));
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        host.answer(state, 1, &mut reply);
        host.answer(b"ping", 1, &mut reply);
        host.answer(state, 2, &mut reply);
        assert_eq!(board.read(), Status { run: 1, states: 1 });
        assert_eq!(host.times().len(), 1);
        host.answer(b"reset", 1, &mut reply);
        assert_eq!(board.read(), Status { run: 2, states: 0 });
        assert_eq!(host.times().len(), 0);
        host.answer(state, 1, &mut reply);
        assert_eq!(host.serve("other", maze), Status { run: 3, states: 0 });
        assert_eq!(host.simulation().name(), "other");
        host.run = LAST_RUN;
        host.answer(b"reset", 1, &mut reply);
        assert_eq!(board.read().run, 1);
    }
}
