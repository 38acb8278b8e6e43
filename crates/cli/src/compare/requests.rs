//! Answers the requests of a mouse that connects over ZeroMQ.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use mmsim_maze::Maze;
use mmsim_protocol::{ERROR_PREFIX, Request};
use mmsim_server::{Simulation, listen};
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, RepServer, Service, Waker};

use super::own_search::{Kind, SharedProgress, lock};
use super::track::Track;
use crate::local_server::HOST;

/// The address to which the mouse connects, served by a separate thread. Dropping it ends the thread,
/// without waiting.
pub(super) struct Endpoint {
    address: String,
    is_stopping: Arc<AtomicBool>,
    waker: Waker,
}

impl Endpoint {
    /// Serves the maze on a free port.
    pub(super) fn start(maze: &Maze, progress: &SharedProgress) -> io::Result<Self> {
        let listener = listen(HOST, 0).map_err(io::Error::other)?;
        let mut server = RepServer::new(listener)?;
        let address = format!("tcp://{}", server.local_address()?);
        let (waker, is_stopping) = (server.waker(), Arc::new(AtomicBool::new(false)));
        let mut requests = Requests {
            simulation: Simulation::new("maze", maze.clone()),
            progress: Arc::clone(progress),
            is_reset: false,
        };
        let stopping = Arc::clone(&is_stopping);
        thread::Builder::new().name("endpoint".into()).spawn(move || {
            // If the operating system fails to report events, the mouse receives no replies and
            // reaches its time limit.
            let _ = server.run(&mut requests, || stopping.load(Ordering::Acquire));
        })?;
        Ok(Self { address, is_stopping, waker })
    }

    pub(super) fn address(&self) -> &str {
        &self.address
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        self.is_stopping.store(true, Ordering::Release);
        self.waker.wake();
    }
}

/// A simulation whose requests are noted in the progress of the search.
struct Requests {
    simulation: Simulation,
    progress: SharedProgress,
    /// True after a reset. The next state then begins the search anew; a reset at the end of a search
    /// changes nothing.
    is_reset: bool,
}

impl Service for Requests {
    fn answer(
        &mut self,
        _: ClientId,
        request: &[u8],
        _frames: usize,
        reply: &mut Vec<u8>,
    ) -> bool {
        let mut progress = lock(&self.progress);
        if !progress.accept(Kind::Client) {
            *reply = format!("{ERROR_PREFIX}the search is over").into_bytes();
            return false;
        }
        let maze = self.simulation.maze().clone();
        match Request::decode(request, maze.size()) {
            Ok(Request::Walls(pose)) => progress.track.read_walls(pose),
            Ok(Request::Reset) => self.is_reset = true,
            Ok(Request::State(state)) => {
                if std::mem::take(&mut self.is_reset) && progress.track.states() > 0 {
                    progress.track = Track::new(&maze);
                }
                if !progress.add(state.pose(), false) {
                    *reply = format!("{ERROR_PREFIX}the search is over").into_bytes();
                    return false;
                }
            }
            _ => {}
        }
        drop(progress);
        self.simulation.handle(request, reply);
        true
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
    }
}
