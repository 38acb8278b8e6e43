//! The server around a simulation: where it listens, how it serves, how it stops.

use std::io;
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use mio::Waker;
use mmsim_recording::Recorder;

use crate::bind::{BindError, listen};
use crate::host::{Board, Host};
use crate::monitor::Question;
use crate::network::Network;
use crate::{Monitor, ReplyBuffer, Simulation};

/// How long replies still on their way may delay the end of the server.
const LINGER: Duration = Duration::from_millis(500);

/// How long a [`Stop`] waits for the server.
const STOP: Duration = Duration::from_secs(1);

/// A server that shall stop does so once nothing has come for so long …
const QUIET: Duration = Duration::from_millis(20);

/// … or for so long, if somebody is about to connect …
const QUIET_HANDSHAKE: Duration = Duration::from_millis(100);

/// … or after this time, however much comes.
const LAST_CALL: Duration = Duration::from_millis(300);

/// Watchers that are answered before clients have their turn again.
const QUESTIONS_AT_ONCE: usize = 4;

/// A bound REP socket that serves a simulation until it is told to stop.
pub struct Server {
    network: Network,
    address: String,
    loopback: bool,
    shared: Arc<Shared>,
    recorder: Option<Recorder>,
    board: Arc<Board>,
    questions: (Sender<Question>, Receiver<Question>),
}

/// What a server has in common with those who watch or stop it.
pub(crate) struct Shared {
    waker: Waker,
    stopped: AtomicBool,
    ended: Mutex<bool>,
    has_ended: Condvar,
}

/// A server that could not go on.
#[derive(Debug, thiserror::Error)]
#[error("cannot receive requests on {address}: {source}")]
pub struct ServeError {
    /// Where it listened.
    pub address: String,
    /// What the system says.
    pub source: io::Error,
}

impl Server {
    /// Listens on a port of this machine; port 0 takes a free one. The host may be a name, an
    /// address, or `*` for every IPv4 address of the machine.
    ///
    /// # Errors
    /// The port is in use, or the host is not one of this machine's.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let failed = |source| BindError::Listen { host: host.into(), port, source };
        Self::of(listen(host, port)?).map_err(failed)
    }

    fn of(listener: TcpListener) -> io::Result<Self> {
        let network = Network::new(listener)?;
        let local = network.local_address()?;
        let shared = Shared {
            waker: network.waker()?,
            stopped: AtomicBool::new(false),
            ended: Mutex::new(false),
            has_ended: Condvar::new(),
        };
        let (address, loopback) =
            (format!("tcp://{local}"), local.ip().to_canonical().is_loopback());
        Ok(Self {
            network,
            address,
            loopback,
            shared: Arc::new(shared),
            recorder: None,
            board: Arc::default(),
            questions: mpsc::channel(),
        })
    }

    /// Where clients connect, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Records each simulation, from reset to reset, into a file. A state that cannot be recorded
    /// is refused and not kept.
    pub fn with_recorder(mut self, recorder: impl Into<Option<Recorder>>) -> Self {
        self.recorder = recorder.into();
        self
    }

    /// Whether only programs on this machine can connect.
    pub fn is_loopback(&self) -> bool {
        self.loopback
    }

    /// A way to stop the server from another thread.
    pub fn stop_handle(&self) -> Stop {
        Stop { shared: Arc::clone(&self.shared) }
    }

    /// A way to look at the simulation from other threads.
    pub fn monitor(&self) -> Monitor {
        Monitor::new(Arc::clone(&self.board), self.questions.0.clone(), Arc::clone(&self.shared))
    }

    /// Serves the simulation until it is stopped. Every request gets exactly one reply, and
    /// nothing that a client sends ends it.
    ///
    /// # Errors
    /// The system cannot say any more who has sent something.
    pub fn run(mut self, simulation: &mut Simulation) -> Result<(), ServeError> {
        let mut host = Host::new(simulation, self.recorder.take(), Arc::clone(&self.board));
        let result = self.serve(&mut host);
        host.end();
        result.map_err(|source| ServeError { address: self.address.clone(), source })
    }

    /// Has each request answered until the server is stopped.
    fn serve(&mut self, host: &mut Host<'_>) -> io::Result<()> {
        let (mut events, mut reply) = (Network::events(), ReplyBuffer::new());
        while !self.shared.stopped.load(Ordering::Acquire) {
            self.network.wait(&mut events, None)?;
            self.serve_once(host, &mut reply);
        }
        // Requests may have come in before, from any peer.
        let (begun, mut last) = (Instant::now(), Instant::now());
        loop {
            let quiet = if self.network.has_handshakes() { QUIET_HANDSHAKE } else { QUIET };
            let end = (begun + LAST_CALL).min(last + quiet);
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            if self.network.wait(&mut events, Some(left))? {
                last = Instant::now();
            }
            self.serve_once(host, &mut reply);
        }
        self.network.flush(&mut events, begun + LINGER)
    }

    /// Gives each client and each watcher a turn.
    fn serve_once(&mut self, host: &mut Host<'_>, reply: &mut ReplyBuffer) {
        self.network.serve(|request, frames, reply| host.answer(request, frames, reply), reply);
        for (count, question) in (1..).zip(self.questions.1.try_iter().take(QUESTIONS_AT_ONCE)) {
            question(host);
            if count == QUESTIONS_AT_ONCE {
                // There may be more, for which nobody would wake it again.
                self.shared.wake();
            }
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        *self.shared.ended.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shared.has_ended.notify_all();
    }
}

impl Shared {
    /// Lets the server look what there is to do. If it cannot be woken it has ended.
    pub(crate) fn wake(&self) {
        let _ = self.waker.wake();
    }
}

/// Stops a [`Server`].
#[derive(Clone)]
pub struct Stop {
    shared: Arc<Shared>,
}

impl Stop {
    /// Lets the server end once it has answered the requests that have come in. Waits until it
    /// has, but at most a second. Does nothing if the server has ended.
    pub fn stop(self) {
        let Shared { stopped, ended, has_ended, .. } = &*self.shared;
        stopped.store(true, Ordering::Release);
        self.shared.wake();
        let ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = has_ended.wait_timeout_while(ended, STOP, |ended| !*ended);
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
    fn a_port_in_use_is_named() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let port = server.address().rsplit(':').next().unwrap().parse().unwrap();
        let error = Server::bind("127.0.0.1", port).err().unwrap().to_string();
        assert_eq!(
            error,
            format!(
                "expected port {port} of 127.0.0.1 to be free, found it in use; is another server running?"
            )
        );
    }

    #[test]
    fn hosts_are_names_or_addresses_of_this_machine() {
        for host in ["127.0.0.1", "localhost", "*"] {
            let server = Server::bind(host, 0).unwrap();
            assert!(server.address().starts_with("tcp://"), "{}", server.address());
            assert_eq!(server.is_loopback(), host != "*");
        }
        let error = |host| Server::bind(host, 0).err().unwrap().to_string();
        assert!(error("no such host").starts_with("expected the name or address of this machine"));
        assert!(error("192.0.2.1").starts_with("cannot listen on port 0 of 192.0.2.1: "));
    }

    #[test]
    fn requests_that_came_in_before_the_stop_are_answered() {
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
    fn a_name_may_come_back() {
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
    fn a_waiting_server_stops_and_one_that_has_ended_does_not_mind() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (stop, late) = (server.stop_handle(), server.stop_handle());
        let running = thread::spawn(move || server.run(&mut simulation()));
        stop.stop();
        within("the server to stop", || running.join()).unwrap().unwrap();
        late.stop();
    }
}
