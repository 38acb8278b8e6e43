//! Looking at a simulation while it is served.

use std::sync::Arc;
use std::sync::mpsc::{self, Sender};

use mmsim_maze::Maze;
use mmsim_protocol::Info;
use mmsim_recording::{Block, Times};

use crate::host::{Board, Host, Status};
use crate::server::Shared;

/// What a watcher wants to know, answered by the server's thread between two requests.
pub(crate) type Question = Box<dyn FnOnce(&mut Host<'_>) + Send>;

/// Looks at the simulation of a running server, and may give it another maze.
///
/// How many states there are is read without the server's doing. Everything else it answers between
/// two requests: a search waits for it as for a request of another client, which takes
/// microseconds, and never for whoever asked.
#[derive(Clone)]
pub struct Monitor {
    board: Arc<Board>,
    questions: Sender<Question>,
    shared: Arc<Shared>,
}

/// What is served.
#[derive(Clone, Debug)]
pub struct Served {
    /// The number of the run.
    pub run: u32,
    /// What `info` tells.
    pub info: Info,
    /// The true maze.
    pub maze: Maze,
}

/// Why a watcher gets no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MonitorError {
    /// The run asked for is over: a reset, or another maze.
    #[error("expected run {asked}, found that it is over")]
    RunEnded {
        /// The number of the run.
        asked: u32,
    },
    /// The server has ended.
    #[error("the server has ended")]
    Ended,
}

impl Monitor {
    pub(crate) const fn new(
        board: Arc<Board>,
        questions: Sender<Question>,
        shared: Arc<Shared>,
    ) -> Self {
        Self { board, questions, shared }
    }

    /// How many states there are now, and of which run. Run 0 is before the server runs.
    pub fn status(&self) -> Status {
        self.board.read()
    }

    /// What is served.
    ///
    /// # Errors
    /// The server has ended.
    pub fn served(&self) -> Result<Served, MonitorError> {
        self.ask(|host| {
            let simulation = host.simulation();
            let (info, maze) = (simulation.info(), simulation.maze().clone());
            Served { run: host.status().run, info, maze }
        })
    }

    /// A block of the states of a run, `None` if there are not so many.
    ///
    /// # Errors
    /// The run is over, or the server has ended.
    pub fn block(&self, run: u32, index: usize) -> Result<Option<Block>, MonitorError> {
        self.ask_of(run, move |host| host.simulation().history().block(index))
    }

    /// When each state of a run came.
    ///
    /// # Errors
    /// The run is over, or the server has ended.
    pub fn times(&self, run: u32) -> Result<Times, MonitorError> {
        self.ask_of(run, |host| host.times().clone())
    }

    /// Serves another maze from now on, with an empty history.
    ///
    /// # Errors
    /// The server has ended.
    pub fn serve(&self, name: &str, maze: Maze) -> Result<Status, MonitorError> {
        let name = name.to_string();
        self.ask(move |host| host.serve(&name, maze))
    }

    fn ask_of<T: Send + 'static>(
        &self,
        run: u32,
        question: impl FnOnce(&mut Host<'_>) -> T + Send + 'static,
    ) -> Result<T, MonitorError> {
        self.ask(move |host| (host.status().run == run).then(|| question(host)))?
            .ok_or(MonitorError::RunEnded { asked: run })
    }

    fn ask<T: Send + 'static>(
        &self,
        question: impl FnOnce(&mut Host<'_>) -> T + Send + 'static,
    ) -> Result<T, MonitorError> {
        let (tell, told) = mpsc::sync_channel(1);
        let question: Question = Box::new(move |host| {
            let _ = tell.send(question(host));
        });
        self.questions.send(question).map_err(|_| MonitorError::Ended)?;
        self.shared.wake();
        told.recv().map_err(|_| MonitorError::Ended)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_tests::within;

    use super::*;
    use crate::{Server, Simulation};

    const STATE: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";

    fn maze() -> Maze {
        "o---o---o\n| S   G |\no---o---o\n".parse().unwrap()
    }

    #[test]
    fn a_watcher_sees_what_clients_do_and_changes_the_maze() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let watch = server.monitor();
        assert_eq!(watch.status(), Status { run: 0, states: 0 });
        let server = server.spawn(Simulation::new("small", maze()));
        let client = mmsim_tests::connect_to(server.address(), zmq::REQ);
        let ask = |request: &[u8]| mmsim_tests::ask(&client, request);
        let states = 2 * Block::STATES + 3;
        for _ in 0..states {
            assert_eq!(ask(STATE), b"ok");
        }
        assert_eq!(watch.status(), Status { run: 1, states });
        let now = watch.served().unwrap();
        assert_eq!((now.run, now.info.states, now.maze), (1, states, maze()));
        for index in 0..3 {
            let block = watch.block(1, index).unwrap().unwrap().unpack().unwrap();
            assert_eq!(block.get(index * Block::STATES), Some(STATE));
            assert_eq!(block.len(), if index == 2 { 3 } else { Block::STATES });
        }
        assert!(watch.block(1, 3).unwrap().is_none());
        assert!(watch.times(1).unwrap().iter().is_sorted());
        assert_eq!(watch.times(1).unwrap().len(), states);

        ask(b"reset");
        assert_eq!(watch.block(1, 0).unwrap_err(), MonitorError::RunEnded { asked: 1 });
        let other: Maze = "o---o\n|SG |\no---o\n".parse().unwrap();
        assert_eq!(watch.serve("other", other), Ok(Status { run: 3, states: 0 }));
        assert!(ask(STATE).starts_with(b"error: expected S of 8 bytes for a maze of 1x1 cells"));
        assert!(ask(b"info").starts_with(br#"{"name":"other","width":1"#));
        within("the server to stop", || server.stop()).unwrap();
        assert_eq!(watch.served().unwrap_err(), MonitorError::Ended);
    }

    #[test]
    fn a_server_that_never_ran_answers_nobody() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let watch = server.monitor();
        drop(server);
        assert_eq!(watch.served().unwrap_err(), MonitorError::Ended);
    }
}
