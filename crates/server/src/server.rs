//! The ZeroMQ socket around a simulation.

use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use mmsim_protocol::{ERROR_PREFIX, RequestError};
use tracing::{debug, info, warn};

use crate::simulation::refuse;
use crate::{Change, Recorder, ReplyBuffer, Simulation};

/// The largest frame that is received, in bytes; who sends a larger one is cut off.
pub const MAX_REQUEST_BYTES: i64 = 64 * 1024;

/// How long replies still on their way may delay the end of the server, in milliseconds.
const LINGER_MS: i32 = 500;

/// How long a [`Stop`] waits for the server, in milliseconds.
const STOP_MS: i32 = 1000;

/// A server that shall stop does so once no request has come for so long, in milliseconds …
const QUIET_MS: i32 = 20;

/// … or after this time, however many come.
const LAST_CALL: Duration = Duration::from_millis(200);

/// Where a [`Stop`] knocks. Each server has a context of its own, so the name is free in each.
const STOP_ENDPOINT: &str = "inproc://stop";

/// What a [`Stop`] sends. It counts only once the stop is called for, so no client can use it.
const STOP_REQUEST: &[u8] = b"\0stop";

/// A bound REP socket that serves a simulation until it is told to stop.
pub struct Server {
    context: zmq::Context,
    socket: zmq::Socket,
    address: String,
    stopped: Arc<AtomicBool>,
    recorder: Option<Recorder>,
}

/// An address on which no server can listen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// Somebody listens there already.
    #[error(
        "expected port {port} of {host} to be free, found it in use; is another server running?"
    )]
    InUse {
        /// The host.
        host: String,
        /// The port.
        port: u16,
    },
    /// The host is not one of this machine.
    #[error("expected the name or address of this machine, found {host:?}: {source}")]
    Host {
        /// What was given as host.
        host: String,
        /// What the name service says.
        source: io::Error,
    },
    /// Anything else that ZeroMQ says.
    #[error("cannot listen on port {port} of {host}: {source}")]
    Zmq {
        /// The host.
        host: String,
        /// The port.
        port: u16,
        /// What ZeroMQ says.
        source: zmq::Error,
    },
}

/// A server that could not go on.
#[derive(Debug, thiserror::Error)]
#[error("cannot receive requests on {address}: {source}")]
pub struct ServeError {
    /// Where it listened.
    pub address: String,
    /// What ZeroMQ says.
    pub source: zmq::Error,
}

impl Server {
    /// Listens on a port of this machine; port 0 takes a free one. The host may be a name, an
    /// address, or `*` for every IPv4 address of the machine.
    ///
    /// # Errors
    /// The port is in use, or the host is not one of this machine's.
    pub fn bind(host: &str, port: u16) -> Result<Self, BindError> {
        let resolved =
            resolve(host, port).map_err(|source| BindError::Host { host: host.into(), source })?;
        Self::bind_resolved(resolved).map_err(|source| match source {
            zmq::Error::EADDRINUSE => BindError::InUse { host: host.into(), port },
            source => BindError::Zmq { host: host.into(), port, source },
        })
    }

    fn bind_resolved(resolved: SocketAddr) -> zmq::Result<Self> {
        let context = zmq::Context::new();
        let socket = context.socket(zmq::REP)?;
        socket.set_linger(LINGER_MS)?;
        socket.set_maxmsgsize(MAX_REQUEST_BYTES)?;
        socket.set_ipv6(resolved.is_ipv6())?;
        // A client with a name of its own that starts again is the same client, not a stranger
        // whose name is taken.
        socket.set_router_handover(true)?;
        socket.bind(&format!("tcp://{resolved}"))?;
        let address = match socket.get_last_endpoint()? {
            Ok(address) => address,
            Err(_) => format!("tcp://{resolved}"),
        };
        socket.bind(STOP_ENDPOINT)?;
        Ok(Self { context, socket, address, stopped: Arc::default(), recorder: None })
    }

    /// Where clients connect, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Records each simulation, from reset to reset, into a file. A state that cannot be recorded
    /// is refused and not kept.
    pub fn with_recorder(mut self, recorder: Recorder) -> Self {
        self.recorder = Some(recorder);
        self
    }

    /// A way to stop the server from another thread.
    ///
    /// # Errors
    /// ZeroMQ has no socket left.
    pub fn stop_handle(&self) -> zmq::Result<Stop> {
        let socket = self.context.socket(zmq::REQ)?;
        socket.set_linger(0)?;
        socket.set_rcvtimeo(STOP_MS)?;
        socket.connect(STOP_ENDPOINT)?;
        Ok(Stop { socket, stopped: Arc::clone(&self.stopped) })
    }

    /// Serves the simulation until it is stopped. Every request gets exactly one reply, and
    /// nothing that a client sends ends it.
    ///
    /// # Errors
    /// The socket itself fails.
    pub fn run(mut self, simulation: &mut Simulation) -> Result<(), ServeError> {
        let address = self.address.clone();
        let failed = |source| ServeError { address: address.clone(), source };
        let (mut request, mut reply) = (zmq::Message::new(), ReplyBuffer::new());
        let (mut refused, mut end) = (0_u64, None);
        while end.is_none_or(|end| Instant::now() < end) {
            let frames = match self.receive(&mut request) {
                Ok(frames) => frames,
                // Nobody asks any more.
                Err(zmq::Error::EAGAIN) => break,
                Err(source) => return Err(failed(source)),
            };
            if &*request == STOP_REQUEST && self.stopped.load(Ordering::Acquire) {
                let _ = self.socket.send("", zmq::DONTWAIT);
                // Requests may have come in before, from other peers.
                self.socket.set_rcvtimeo(QUIET_MS).map_err(failed)?;
                end = Some(Instant::now() + LAST_CALL);
                continue;
            }
            if frames == 1 {
                let change = simulation.handle(&request, &mut reply);
                self.record(change, &request, simulation, &mut reply);
            } else {
                refuse(&mut reply, RequestError::Frames { found: frames });
            }
            if let Some(reason) = reply.strip_prefix(ERROR_PREFIX.as_bytes()) {
                refused += 1;
                log_refusal(&String::from_utf8_lossy(reason), refused);
            }
            if let Err(error) = self.socket.send(&reply, zmq::DONTWAIT) {
                debug!(%error, "reply not sent");
            }
        }
        if let Some(Err(error)) = self.recorder.as_mut().map(Recorder::close) {
            warn!("a recording is not closed, but whole: {error}");
        }
        info!(states = simulation.history().len(), refused, "stopped");
        Ok(())
    }

    /// Records what the request has changed. A state that cannot be recorded is taken back.
    fn record(
        &mut self,
        change: Change,
        request: &[u8],
        simulation: &mut Simulation,
        reply: &mut ReplyBuffer,
    ) {
        let Some(recorder) = &mut self.recorder else { return };
        match (recorder.follow(change, request, simulation), change) {
            (Ok(()), _) => {}
            (Err(error), Change::State) => {
                simulation.take_back();
                refuse(reply, error);
            }
            (Err(error), _) => warn!("a recording is not closed, but whole: {error}"),
        }
    }

    /// Receives one message, of which the first frame is kept, and gives the number of frames.
    fn receive(&self, first: &mut zmq::Message) -> zmq::Result<usize> {
        self.receive_frame(first)?;
        let (mut frames, mut further) = (1, zmq::Message::new());
        let mut more = first.get_more();
        while more {
            self.receive_frame(&mut further)?;
            more = further.get_more();
            frames += 1;
        }
        Ok(frames)
    }

    fn receive_frame(&self, frame: &mut zmq::Message) -> zmq::Result<()> {
        loop {
            match self.socket.recv(frame, 0) {
                // A signal, which is for others to act on.
                Err(zmq::Error::EINTR) => {}
                result => return result,
            }
        }
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

/// The address to listen on; of several, the first of the old kind, which clients try first.
fn resolve(host: &str, port: u16) -> io::Result<SocketAddr> {
    let host = match host {
        "*" => "0.0.0.0",
        host => host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host),
    };
    let mut addresses = (host, port).to_socket_addrs()?.collect::<Vec<_>>();
    addresses.sort_by_key(SocketAddr::is_ipv6);
    addresses.first().copied().ok_or(io::ErrorKind::NotFound.into())
}

/// Stops a [`Server`].
pub struct Stop {
    socket: zmq::Socket,
    stopped: Arc<AtomicBool>,
}

impl Stop {
    /// Lets the server end once it has answered the requests that have come in. Waits until it
    /// knows, but at most a second. Does nothing if the server has ended.
    pub fn stop(self) {
        self.stopped.store(true, Ordering::Release);
        // If it cannot be sent or nobody answers, the server has ended.
        let _ =
            self.socket.send(STOP_REQUEST, zmq::DONTWAIT).and_then(|()| self.socket.recv_bytes(0));
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use mmsim_maze::Maze;

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
                let client = zmq::Context::new().socket(zmq::REQ).unwrap();
                client.set_rcvtimeo(5000).unwrap();
                client.connect(server.address()).unwrap();
                client.send("ping", 0).unwrap();
                client
            })
            .collect();
        let stop = server.stop_handle().unwrap();
        thread::scope(|scope| {
            scope.spawn(|| stop.stop());
            server.run(&mut simulation()).unwrap();
        });
        for client in clients {
            assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
        }
    }

    #[test]
    fn a_name_may_come_back() {
        let server = Server::bind("127.0.0.1", 0).unwrap().spawn(simulation()).unwrap();
        for _ in 0..50 {
            let client = zmq::Context::new().socket(zmq::REQ).unwrap();
            client.set_identity(b"mouse").unwrap();
            client.set_rcvtimeo(5000).unwrap();
            client.set_linger(0).unwrap();
            client.connect(server.address()).unwrap();
            client.send("ping", 0).unwrap();
            assert_eq!(client.recv_bytes(0).unwrap(), b"pong");
        }
        server.stop().unwrap();
    }

    #[test]
    fn a_waiting_server_stops_and_one_that_has_ended_does_not_mind() {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let (stop, late) = (server.stop_handle().unwrap(), server.stop_handle().unwrap());
        thread::scope(|scope| {
            let running = scope.spawn(move || server.run(&mut simulation()));
            stop.stop();
            running.join().unwrap().unwrap();
        });
        late.stop();
    }
}
