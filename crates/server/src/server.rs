//! The server around a simulation.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};

use mmsim_recording::Recorder;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{BindError, RepServer, Service, listen};

use crate::control::{Control, StopHandle};
use crate::monitor::{Monitor, Query};
use crate::service::SimulationService;
use crate::simulation::Simulation;
use crate::status::StatusCell;

/// The maximum number of queries answered before clients have their turn again.
const MAX_QUERIES_AT_ONCE: usize = 4;

/// A bound REP socket that serves a simulation until it is stopped.
#[must_use = "a server does nothing until it runs"]
pub struct Server {
    socket: RepServer,
    address: String,
    is_loopback: bool,
    control: Arc<Control>,
    recorder: Option<Recorder>,
    status: Arc<StatusCell>,
    queries: (Sender<Query>, Receiver<Query>),
}

/// A server that could not continue.
#[derive(Debug, thiserror::Error)]
#[error("cannot receive requests on {address}: {source}")]
pub struct ServeError {
    /// The address it listened on.
    pub address: String,
    /// The error of the operating system.
    pub source: io::Error,
}

impl Server {
    /// Listens on a port of this machine; port 0 selects a free port. The host is a name, an address,
    /// or `*` for all IPv4 addresses of this machine.
    ///
    /// # Errors
    /// The port is in use, the host cannot be resolved, its address does not belong to this machine, or
    /// the operating system refuses for another reason.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let failed = |source| BindError::Listen { host: host.into(), port, source };
        Self::from_listener(listen(host, port)?).map_err(failed)
    }

    fn from_listener(listener: TcpListener) -> io::Result<Self> {
        let socket = RepServer::new(listener)?;
        let local = socket.local_address()?;
        let control = Arc::new(Control::new(socket.waker()));
        Ok(Self {
            socket,
            address: format!("tcp://{local}"),
            is_loopback: local.ip().to_canonical().is_loopback(),
            control,
            recorder: None,
            status: Arc::default(),
            queries: mpsc::channel(),
        })
    }

    /// Returns the address that clients connect to, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Records each run, from reset to reset, into a file. A state that cannot be recorded is refused
    /// and not kept.
    pub fn with_recorder(mut self, recorder: impl Into<Option<Recorder>>) -> Self {
        self.recorder = recorder.into();
        self
    }

    /// Returns whether only programs on this machine can connect.
    pub fn is_loopback(&self) -> bool {
        self.is_loopback
    }

    /// Returns a handle that stops the server from another thread.
    pub fn stop_handle(&self) -> StopHandle {
        StopHandle::new(Arc::clone(&self.control))
    }

    /// Returns a monitor, which reads the simulation from other threads.
    pub fn monitor(&self) -> Monitor {
        let (status, control) = (Arc::clone(&self.status), Arc::clone(&self.control));
        Monitor::new(status, self.queries.0.clone(), control)
    }

    /// Serves the simulation until it is stopped. Every request gets exactly one reply, and no request
    /// stops the server.
    ///
    /// # Errors
    /// The operating system can no longer report which connection has sent something.
    pub fn run(mut self, simulation: &mut Simulation) -> Result<(), ServeError> {
        let status = Arc::clone(&self.status);
        let simulation = SimulationService::new(simulation, self.recorder.take(), status);
        let (queries, control) = (&self.queries.1, &*self.control);
        let mut event_loop = EventLoop { simulation, queries, control };
        let result = self.socket.run(&mut event_loop, || control.is_stopping());
        event_loop.simulation.finish();
        result.map_err(|source| ServeError { address: self.address.clone(), source })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.control.set_ended();
    }
}

/// Answers clients, and between their turns the queries of monitors.
struct EventLoop<'s> {
    simulation: SimulationService<'s>,
    queries: &'s Receiver<Query>,
    control: &'s Control,
}

impl Service for EventLoop<'_> {
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool {
        self.simulation.answer(request, frames, reply)
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        self.simulation.refuse(reason, reply);
    }

    fn after_round(&mut self) {
        for (count, query) in (1..).zip(self.queries.try_iter().take(MAX_QUERIES_AT_ONCE)) {
            query(&mut self.simulation);
            if count == MAX_QUERIES_AT_ONCE {
                // More queries may wait, for which nobody would wake the server again.
                self.control.wake();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use mmsim_maze::Maze;
    use mmsim_tests::{PATIENCE_MS, connect_to, within};

    use super::*;

    fn simulation() -> Simulation {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        Simulation::new("small", maze)
    }

    #[test]
    fn only_loopback_addresses_are_loopback() {
        for host in ["127.0.0.1", "localhost", "*"] {
            let server = Server::bind(host, 0).unwrap();
            assert!(server.address().starts_with("tcp://"), "{}", server.address());
            assert_eq!(server.is_loopback(), host != "*");
        }
    }

    #[test]
    fn requests_before_the_stop_are_answered() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let clients: Vec<zmq::Socket> = (0..20)
            .map(|_| {
                let client = connect_to(server.address(), zmq::REQ);
                client.send("ping", 0).unwrap();
                client
            })
            .collect();
        let stop = server.stop_handle();
        let stopping = thread::spawn(move || stop.stop());
        within("the server to stop", move || server.run(&mut simulation())).unwrap();
        stopping.join().unwrap();
        for client in clients {
            assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
        }
    }

    #[test]
    fn routing_identity_can_be_reused() {
        let server = Server::bind("127.0.0.1", 0).unwrap().spawn(simulation());
        for _ in 0..50 {
            let client = zmq::Context::new().socket(zmq::REQ).unwrap();
            client.set_identity(b"mouse").unwrap();
            client.set_rcvtimeo(PATIENCE_MS).unwrap();
            client.set_linger(0).unwrap();
            client.connect(server.address()).unwrap();
            client.send("ping", 0).unwrap();
            assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
        }
        within("the server to stop", || server.stop()).unwrap();
    }

    #[test]
    fn idle_server_stops_and_stopping_it_again_does_nothing() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (stop, late) = (server.stop_handle(), server.stop_handle());
        let running = thread::spawn(move || server.run(&mut simulation()));
        stop.stop();
        within("the server to stop", || running.join()).unwrap().unwrap();
        late.stop();
    }
}
