//! Helpers for integration tests. They find shared mazes and transcripts, run servers, and wait
//! with a timeout.
#![forbid(unsafe_code)]

mod malformed;
mod mms;
mod wait;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use mmsim_maze::{KnownMaze, Maze, Pose, Unknown};
use mmsim_protocol::{Cell, Heading};
use mmsim_server::{Background, Server, Simulation};
use mmsim_solvers::Distances;
use serde::{Deserialize, Deserializer};

pub use malformed::{good_state, malformed_requests};
pub use mms::{MMS_COLOURS, MMS_COMMANDS, MMS_REFUSED};
pub use wait::{
    TIMEOUT, TIMEOUT_MS, output, stop, wait_for, wait_for_exit, wait_with_output, within,
};

/// Returns a path in `../shared`, the folder of shared mazes and transcripts. The project does not
/// include these files because they have no licence. If the path does not exist, prints a message
/// to stderr and returns `None`, so that the test is skipped.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    if path.exists() {
        return Some(path);
    }
    // Written directly, since the test harness captures `eprintln!` of passing tests.
    let _ = writeln!(std::io::stderr(), "skipped: {} does not exist", path.display());
    None
}

/// Reads a file that contains one JSON value per line.
///
/// # Panics
/// Panics if the file cannot be read or parsed.
pub fn json_lines<T: serde::de::DeserializeOwned>(path: &Path) -> Vec<T> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A line of a transcript: a request and its reply.
#[derive(Deserialize)]
pub struct Exchange {
    /// The request.
    #[serde(deserialize_with = "from_hex")]
    pub req: Vec<u8>,
    /// The reply.
    #[serde(deserialize_with = "from_hex")]
    pub rep: Vec<u8>,
}

fn from_hex<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    let digits = String::deserialize(deserializer)?;
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16);
    let bytes = (0..digits.len()).step_by(2).map(byte).collect::<Result<_, _>>();
    bytes.map_err(serde::de::Error::custom)
}

/// Returns the map and start pose of a mouse in an unknown 16×16 maze with the goal in the centre.
pub fn classic_map() -> (KnownMaze, Pose) {
    let size = mmsim_maze::MazeSize::CLASSIC;
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    (KnownMaze::new(size, start.cell, size.central_cells()), start)
}

/// Returns the optimistic or pessimistic distance from a cell to the goal.
pub fn known_distance(map: &KnownMaze, from: Cell, unknown: Unknown) -> Option<u16> {
    Distances::flood(map.walls(unknown), map.goals()).at(from)
}

/// Serves a maze on a free port of the loopback interface.
///
/// # Panics
/// Panics if there is no free port.
pub fn serve(maze: Maze) -> Background {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    server.spawn(Simulation::new("served", maze))
}

/// Returns a socket of the given kind, connected to the server, with [`TIMEOUT`] as its timeout.
///
/// # Panics
/// Panics if `ZeroMQ` cannot create the socket.
pub fn connect(server: &Background, kind: zmq::SocketType) -> zmq::Socket {
    connect_to(server.address(), kind)
}

/// Returns a socket of the given kind, connected to this address, with [`TIMEOUT`] as its timeout.
///
/// # Panics
/// Panics if `ZeroMQ` cannot create the socket.
pub fn connect_to(address: &str, kind: zmq::SocketType) -> zmq::Socket {
    let socket = zmq::Context::new().socket(kind).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
    socket.set_sndtimeo(TIMEOUT_MS).unwrap();
    socket.connect(address).unwrap();
    socket
}

/// Sends a request and waits for its reply.
///
/// # Panics
/// Panics if there is no reply within [`TIMEOUT`].
#[track_caller]
pub fn ask(socket: &zmq::Socket, request: &[u8]) -> Vec<u8> {
    let asked = socket.send(request, 0).and_then(|()| socket.recv_bytes(0));
    asked.unwrap_or_else(|error| {
        let start = request.get(..8).unwrap_or(request).escape_ascii();
        panic!("waited {TIMEOUT:?} for a reply to {start}: {error}")
    })
}

/// A documentation test that compiles the strategy in the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../docs/clients.md")]
pub struct Clients;
