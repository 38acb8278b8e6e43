//! The simulation as a server serves it: with times, a recording, and a status for other threads.

use std::sync::Arc;

use mmsim_maze::Maze;
use mmsim_protocol::{ERROR_PREFIX, RequestError};
use mmsim_recording::{Clock, HistoryFull, PushError, Recorder, Times};
use mmsim_zmtp::Service;
use mmsim_zmtp::codec::ProtocolError;
use tracing::{debug, info, warn};

use crate::simulation::{Change, ReplyBuffer, Simulation, refuse};
use crate::status::{MAX_RUN, Status, StatusCell};

/// The resolution of the times of live states, in nanoseconds.
const TICK_NS: u64 = 1000;

/// A simulation that is being served.
pub(crate) struct SimulationService<'s> {
    simulation: &'s mut Simulation,
    recorder: Option<Recorder>,
    clock: Clock,
    times: Times,
    run: u32,
    status: Arc<StatusCell>,
    refused: u64,
}

impl<'s> SimulationService<'s> {
    pub(crate) fn new(
        simulation: &'s mut Simulation,
        recorder: Option<Recorder>,
        status: Arc<StatusCell>,
    ) -> Self {
        let (clock, times) = (Clock::start(), Times::new(TICK_NS));
        let service = Self { simulation, recorder, clock, times, run: 1, status, refused: 0 };
        service.publish_status();
        service
    }

    /// Serves this maze from now on.
    pub(crate) fn replace_maze(&mut self, name: &str, maze: Maze) -> Status {
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

    /// Closes the recording and waits for its recorder.
    pub(crate) fn finish(mut self) {
        self.close_recording();
        if let Some(recorder) = self.recorder {
            recorder.finish();
        }
        let states = self.simulation.history().len();
        info!(states, refused = self.refused, "stopped");
    }

    /// Applies a change to the times, the recording and the status. A state that cannot be kept
    /// everywhere is removed from the history and refused.
    fn apply(&mut self, change: Change, request: &[u8], reply: &mut ReplyBuffer) {
        match change {
            Change::Nothing => {}
            Change::Reset => self.begin_run(),
            Change::State => {
                if let Err(reason) = self.keep_state(request) {
                    self.simulation.take_back();
                    refuse(reply, reason);
                }
                self.publish_status();
            }
        }
    }

    /// Keeps the time of the newest state and records the state. Returns the reason if it cannot.
    fn keep_state(&mut self, request: &[u8]) -> Result<(), String> {
        let history = self.simulation.history();
        let (states, limit) = (history.len() - 1, history.limit());
        if self.times.push(self.clock.now()).is_err() {
            return Err(PushError::OutOfMemory { states }.to_string());
        }
        let result = if history.bytes() + self.times.bytes() > limit {
            Err(HistoryFull { limit, states }.to_string())
        } else {
            let record = |recorder: &mut Recorder| {
                let describe = || (self.simulation.info(), self.simulation.maze());
                recorder.write(request, describe).map_err(|e| e.to_string())
            };
            self.recorder.as_mut().map_or(Ok(()), record)
        };
        if result.is_err() {
            self.times.undo_push();
        }
        result
    }

    fn begin_run(&mut self) {
        self.close_recording();
        self.times = Times::new(TICK_NS);
        self.run = if self.run == MAX_RUN { 1 } else { self.run + 1 };
        info!(run = self.run, "reset");
        self.publish_status();
    }

    fn close_recording(&mut self) {
        if let Some(Err(error)) = self.recorder.as_mut().map(Recorder::close) {
            warn!("cannot close a recording (its states are readable): {error}");
        }
    }

    fn publish_status(&self) {
        self.status.write(self.status());
    }
}

impl Service for SimulationService<'_> {
    /// Answers a request. `ping` and refused requests do not count as activity: a client can send them
    /// for ever without searching the maze.
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut ReplyBuffer) -> bool {
        if frames == 1 {
            let change = self.simulation.handle(request, reply);
            self.apply(change, request, reply);
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

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut ReplyBuffer) {
        refuse(reply, reason);
    }
}

/// Logs the first refusal as a warning and the others at level debug, so that a faulty client cannot
/// fill the log.
fn log_refusal(reason: &str, refused: u64) {
    if refused == 1 {
        warn!("refused a request: {reason} (further refusals are logged at level debug)");
    } else {
        debug!("refused a request: {reason}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_count_toward_the_history_limit() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let mut simulation = Simulation::new("small", maze).with_history_limit(100_000);
        let status: Arc<StatusCell> = Arc::default();
        let mut service = SimulationService::new(&mut simulation, None, Arc::clone(&status));
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        let kept = (0..200_000).take_while(|_| {
            service.answer(state, 1, &mut reply);
            reply == b"ok"
        });
        let kept = kept.count();
        assert!((10_000..100_000).contains(&kept), "{kept} states");
        assert!(reply.starts_with(
            b"error: cannot store another state: history limit of 0 MiB reached after "
        ));
        assert_eq!(status.read(), Status { run: 1, states: kept });
        assert_eq!(service.times().len(), kept);
        service.answer(b"reset", 1, &mut reply);
        service.answer(state, 1, &mut reply);
        assert_eq!(reply, b"ok");
    }

    #[test]
    fn each_reset_and_each_maze_begins_a_run() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let (mut simulation, status) = (Simulation::new("small", maze.clone()), Arc::default());
        let mut service = SimulationService::new(&mut simulation, None, Arc::clone(&status));
        let (state, mut reply) = (b"S\x00\x00NC\x01\x00C\x0d\x00", ReplyBuffer::new());
        service.answer(state, 1, &mut reply);
        service.answer(b"ping", 1, &mut reply);
        service.answer(state, 2, &mut reply);
        assert_eq!(status.read(), Status { run: 1, states: 1 });
        assert_eq!(service.times().len(), 1);
        service.answer(b"reset", 1, &mut reply);
        assert_eq!(status.read(), Status { run: 2, states: 0 });
        assert_eq!(service.times().len(), 0);
        service.answer(state, 1, &mut reply);
        assert_eq!(service.replace_maze("other", maze), Status { run: 3, states: 0 });
        assert_eq!(service.simulation().name(), "other");
        service.run = MAX_RUN;
        service.answer(b"reset", 1, &mut reply);
        assert_eq!(status.read().run, 1);
    }
}
