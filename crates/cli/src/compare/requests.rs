//! Answers the requests of a mouse that connects over ZeroMQ.

use std::fmt::Display;
use std::io;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use mmsim_maze::Maze;
use mmsim_protocol::{ERROR_PREFIX, Request};
use mmsim_server::{LIMITS, Simulation, listen};
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, RepServer, Service, Waker};

use super::own_search::{MouseKind, SharedProgress, lock};
use crate::local_server::HOST;

/// The address to which the mouse connects, served by a separate thread. Dropping it ends the thread,
/// without waiting.
pub(super) struct Endpoint {
    address: String,
    is_stopping: Arc<AtomicBool>,
    waker: Waker,
    thread: Option<JoinHandle<()>>,
}

impl Endpoint {
    /// Serves the maze on a free port.
    pub(super) fn start(maze: &Maze, progress: &SharedProgress) -> io::Result<Self> {
        let listener = listen(HOST, 0).map_err(io::Error::other)?;
        let mut server = RepServer::with_config(listener, LIMITS)?;
        let address = format!("tcp://{}", server.local_address()?);
        let (waker, is_stopping) = (server.waker(), Arc::new(AtomicBool::new(false)));
        let mut requests = Requests {
            simulation: Simulation::new("maze", maze.clone()),
            progress: Arc::clone(progress),
            is_reset: false,
        };
        let stopping = Arc::clone(&is_stopping);
        let thread = thread::Builder::new().name("endpoint".into()).spawn(move || {
            // If the operating system fails to report events, the mouse receives no replies and
            // reaches its time limit.
            let _ = server.run(&mut requests, || stopping.load(Ordering::Acquire));
        })?;
        Ok(Self { address, is_stopping, waker, thread: Some(thread) })
    }

    pub(super) fn address(&self) -> &str {
        &self.address
    }

    /// Answers the requests that the mouse has sent before it exited, and ends the thread.
    pub(super) fn finish(mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // A panic has already been reported.
            let _ = thread.join();
        }
    }

    fn stop(&self) {
        self.is_stopping.store(true, Ordering::Release);
        self.waker.wake();
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        self.stop();
    }
}

/// A simulation whose requests are noted in the progress of the search.
struct Requests {
    simulation: Simulation,
    progress: SharedProgress,
    /// True after a reset, which puts the mouse back at the start before the next state.
    is_reset: bool,
}

impl Service for Requests {
    fn answer(&mut self, _: ClientId, request: &[u8], _frames: usize, reply: &mut Vec<u8>) -> bool {
        let mut progress = lock(&self.progress);
        if !progress.accept(MouseKind::Client) {
            let reason = if progress.is_over {
                "the search is over"
            } else {
                "the mouse has written commands of mms to its stdout"
            };
            return refuse(reply, reason);
        }
        match Request::decode(request, self.simulation.maze().size()) {
            Ok(Request::Walls(pose)) => progress.track.read_walls(pose),
            Ok(Request::Reset) => self.is_reset = true,
            Ok(Request::State(state)) => {
                if !progress.add(state.pose(), mem::take(&mut self.is_reset)) {
                    return refuse(reply, "the search is over");
                }
            }
            Ok(_) => {}
            Err(error) => progress.fault = Some(format!("last refused request: {error}")),
        }
        drop(progress);
        self.simulation.handle(request, reply);
        true
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        refuse(reply, reason);
    }
}

/// Writes an error reply. Returns false, because the request does not count as activity.
fn refuse(reply: &mut Vec<u8>, reason: impl Display) -> bool {
    *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
    false
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::mpsc;
    use std::time::Duration;

    use mmsim_client::{Timeout, Transport, Zmq};

    use super::*;
    use crate::compare::own_search::{EndSignal, Progress, SearchLimits};

    const FIRST: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";
    const LAST: &[u8] = b"S\x01\x00EC\x01\x00C\x0d\x17";

    /// Sends requests to an endpoint with a limit of 3 states, and returns the replies.
    fn answers(requests: &[&[u8]]) -> (Vec<Vec<u8>>, SharedProgress, mpsc::Receiver<EndSignal>) {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let (sender, over) = mpsc::channel();
        let limits = SearchLimits { time: Duration::MAX, states: 3 };
        let progress = Arc::new(Mutex::new(Progress::new(&maze, limits, sender)));
        let endpoint = Endpoint::start(&maze, &progress).unwrap();
        let mut client =
            Zmq::connect(endpoint.address(), Timeout::After(Duration::from_secs(300)), |_| {})
                .unwrap();
        let ask = |request: &&[u8]| {
            let mut reply = Vec::new();
            client.exchange(request, &mut reply).unwrap();
            reply
        };
        let replies = requests.iter().map(ask).collect();
        (replies, progress, over)
    }

    #[test]
    fn readings_and_states_are_noted() {
        let (replies, progress, _) =
            answers(&[b"reset", b"W\x00\x00N", FIRST, LAST, b"what?", b"reset"]);
        assert_eq!(replies[..4], [&b"ok"[..], &[1, 1, 0], b"ok", b"ok"]);
        assert!(replies[4].starts_with(b"error: expected "));
        let figures = lock(&progress).track.figures();
        assert_eq!(
            (figures.steps_to_goal, figures.turns, figures.path_found),
            (Some(1), 1, Some(1))
        );
    }

    #[test]
    fn a_reset_puts_the_mouse_back_at_the_start() {
        let (_, progress, _) = answers(&[b"reset", FIRST, LAST, b"reset", FIRST]);
        let mut progress = lock(&progress);
        let figures = progress.track.figures();
        assert_eq!((figures.goal_reached, figures.steps_in_all), (true, 1));
        let (_, progress, _) = answers(&[FIRST, b"reset", LAST]);
        assert!(lock(&progress).track.jump().is_some());
    }

    #[test]
    fn states_beyond_the_limit_are_refused() {
        let (replies, progress, over) = answers(&[FIRST, FIRST, FIRST, FIRST, b"ping"]);
        assert_eq!(replies[3..], [b"error: the search is over"; 2]);
        assert_eq!(lock(&progress).track.states(), 3);
        assert!(matches!(over.try_recv(), Ok(EndSignal::StepLimit)));
    }

    #[test]
    fn commands_of_mms_are_ignored_after_a_request() {
        let (_, progress, _) = answers(&[b"ping"]);
        assert!(!lock(&progress).accept(MouseKind::Mms));
    }
}
