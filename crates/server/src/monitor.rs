//! Gives other threads access to a simulation while it is served.

use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, Sender};

use mmsim_maze::{Maze, Misreadings};
use mmsim_protocol::Info;
use mmsim_recording::{Block, LogBlock, LogEnd, LogLine, Times, TrailingAnnotations, read_log};
use mmsim_zmtp::ClientId;

use crate::control::{Control, Status};
use crate::service::SimulationService;

/// A query from a monitor, which the server's thread runs between requests.
pub(crate) type Query = Box<dyn FnOnce(&mut SimulationService<'_>) + Send>;

/// Reads the simulation of a running server. A monitor can also replace the maze.
///
/// [`status`](Self::status), [`unsaved_states`](Self::unsaved_states),
/// [`annotations`](Self::annotations), [`has_client`](Self::has_client) and
/// [`has_client_states`](Self::has_client_states) do not wait for the server's thread. All other
/// methods send queries, which the server's thread runs between requests. A query takes microseconds. A
/// slow caller never delays a search.
#[derive(Clone)]
pub struct Monitor {
    pub(crate) queries: Sender<Query>,
    pub(crate) control: Arc<Control>,
}

/// A description of the served simulation.
#[derive(Clone, Debug)]
pub struct Served {
    /// The run number.
    pub run: u32,
    /// The reply to `info`.
    pub info: Info,
    /// The true maze.
    pub maze: Maze,
    /// The name of the mouse, if it has sent its name and a state.
    pub mouse: Option<String>,
    /// The name of the mouse's strategy, if the mouse has sent it and a state.
    pub strategy: Option<String>,
}

/// The reason why a query failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MonitorError {
    /// A reset or a new maze has ended the run.
    #[error("run {run} has ended")]
    RunEnded {
        /// The requested run number.
        run: u32,
    },
    /// A client is searching the maze.
    #[error("another client is searching the maze (try again after the client has disconnected)")]
    HasClient,
    /// The server has stopped.
    #[error("the server has stopped")]
    Ended,
}

impl Monitor {
    /// Returns the current run number and the number of states in that run. Run 0 means that the
    /// server is not running yet.
    pub fn status(&self) -> Status {
        self.control.status.read()
    }

    /// Returns the number of states that a reset deletes: all states of the current run, or none if the
    /// server records them. It refuses states that it cannot record.
    pub fn unsaved_states(&self) -> usize {
        let is_recorded = self.control.is_recorded.load(Ordering::Acquire);
        if is_recorded { 0 } else { self.status().states }
    }

    /// Returns a description of the served simulation.
    ///
    /// # Errors
    /// Returns an error if the server has stopped.
    pub fn served(&self) -> Result<Served, MonitorError> {
        self.query(|service| {
            let (info, maze) = (service.simulation.info(), service.simulation.maze().clone());
            let context = service.simulation.history().newest_context();
            let [mouse, strategy] = [context.notes().mouse(), context.notes().strategy()]
                .map(|name| name.map(Into::into));
            Served { run: service.run, info, maze, mouse, strategy }
        })
    }

    /// Returns one block of up to [`Block::STATES`] consecutive states, or `None` if the run has no
    /// block with this index.
    ///
    /// # Errors
    /// Returns an error if the run or the server has stopped.
    pub fn block(&self, run: u32, index: usize) -> Result<Option<Block>, MonitorError> {
        self.query_run(run, move |service| service.simulation.history().block(index))
    }

    /// Returns the last `max` log lines that match a filter, up to the state with the index `last`,
    /// in order. The filter runs on the caller's thread.
    ///
    /// # Errors
    /// Returns an error if the run or the server has stopped.
    pub fn log(
        &self,
        run: u32,
        last: usize,
        max: usize,
        filter: impl Fn(&str) -> bool,
    ) -> Result<Vec<LogLine>, MonitorError> {
        let read = |blocks, end| self.log_block(run, blocks, end);
        read_log(&(0..=last), LogEnd::Last, max, filter, read)
    }

    /// Returns the log lines of the first or last block with log lines whose index is in `blocks`.
    /// See [`read_log`].
    ///
    /// # Errors
    /// Returns an error if the run or the server has stopped.
    pub fn log_block(
        &self,
        run: u32,
        blocks: RangeInclusive<usize>,
        end: LogEnd,
    ) -> Result<Option<LogBlock>, MonitorError> {
        self.query_run(run, move |service| service.simulation.history().log_block(blocks, end))
    }

    /// Returns the annotations after the last of `states` states, or none if the run has more states.
    ///
    /// # Errors
    /// Returns an error if the run or the server has stopped.
    pub fn trailing(&self, run: u32, states: usize) -> Result<TrailingAnnotations, MonitorError> {
        self.query_run(run, move |service| {
            let is_last = service.simulation.history().len() == states;
            if is_last { service.simulation.trailing() } else { TrailingAnnotations::default() }
        })
    }

    /// Returns the number of requests with annotations that the server has answered.
    pub fn annotations(&self) -> u64 {
        self.control.annotations.load(Ordering::Acquire)
    }

    /// Returns the times at which the states of a run arrived.
    ///
    /// # Errors
    /// Returns an error if the run or the server has stopped.
    pub fn times(&self, run: u32) -> Result<Times, MonitorError> {
        self.query_run(run, |service| service.times.clone())
    }

    /// Returns true if a client is searching the maze: it is connected, and it has sent a state, a
    /// wall reading, an annotation or `reset`.
    pub fn has_client(&self) -> bool {
        self.control.has_client.load(Ordering::Acquire)
    }

    /// Returns true if the states of the current run come from a client, and not from this program.
    pub fn has_client_states(&self) -> bool {
        self.control.has_client_states.load(Ordering::Acquire) && self.status().states > 0
    }

    /// Lets only this program search the maze, or lets clients search it again. While the simulation
    /// is reserved, clients can only read.
    pub fn reserve(&self, is_reserved: bool) {
        self.control.is_reserved.store(is_reserved, Ordering::Release);
    }

    /// Answers a request as if it had been sent to the server by `client`, or by this program if
    /// `client` is `None`. `frames` is the number of frames of the request. Returns the reply, and
    /// whether the request counts as activity (see [`mmsim_zmtp::Service::answer`]).
    ///
    /// # Errors
    /// Returns an error if the server has stopped.
    pub fn answer(
        &self,
        client: Option<ClientId>,
        request: &[u8],
        frames: usize,
    ) -> Result<(Vec<u8>, bool), MonitorError> {
        let request = request.to_vec();
        self.query(move |service| {
            let mut reply = Vec::new();
            let is_activity = service.answer_request(client, &request, frames, &mut reply);
            (reply, is_activity)
        })
    }

    /// Answers a request of this program, unless a client is searching the maze.
    ///
    /// # Errors
    /// Returns an error if a client is searching the maze or if the server has stopped.
    pub fn answer_without_clients(&self, request: &[u8]) -> Result<Vec<u8>, MonitorError> {
        let request = request.to_vec();
        self.query(move |service| {
            if service.has_client() {
                return Err(MonitorError::HasClient);
            }
            let mut reply = Vec::new();
            service.answer_request(None, &request, 1, &mut reply);
            Ok(reply)
        })?
    }

    /// Records that a client for which [`answer`](Self::answer) was called has disconnected.
    ///
    /// # Errors
    /// Returns an error if the server has stopped.
    pub fn disconnect(&self, client: ClientId) -> Result<(), MonitorError> {
        self.query(move |service| service.remove_client(client))
    }

    /// Replaces the maze and begins a new run with an empty history.
    ///
    /// # Errors
    /// Returns an error if the server has stopped.
    pub fn serve(&self, name: &str, maze: Maze) -> Result<Status, MonitorError> {
        let name = name.to_string();
        self.query(move |service| service.replace_maze(&name, maze))
    }

    /// Lets clients misread walls from now on.
    ///
    /// # Errors
    /// Returns an error if the server has stopped.
    pub fn misread(&self, misreadings: Misreadings) -> Result<(), MonitorError> {
        self.query(move |service| service.simulation.set_misreadings(misreadings))
    }

    fn query_run<T: Send + 'static>(
        &self,
        run: u32,
        query: impl FnOnce(&mut SimulationService<'_>) -> T + Send + 'static,
    ) -> Result<T, MonitorError> {
        self.query(move |service| (service.run == run).then(|| query(service)))?
            .ok_or(MonitorError::RunEnded { run })
    }

    fn query<T: Send + 'static>(
        &self,
        query: impl FnOnce(&mut SimulationService<'_>) -> T + Send + 'static,
    ) -> Result<T, MonitorError> {
        let (sender, receiver) = mpsc::sync_channel(1);
        let query: Query = Box::new(move |service| {
            let _ = sender.send(query(service));
        });
        self.queries.send(query).map_err(|_| MonitorError::Ended)?;
        self.control.waker.wake();
        receiver.recv().map_err(|_| MonitorError::Ended)
    }
}
