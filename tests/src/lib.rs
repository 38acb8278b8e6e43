//! What the tests across crates share: real mazes, transcripts, and a running server.
#![forbid(unsafe_code)]

mod malformed;
mod wait;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use mmsim_maze::{KnownMaze, Maze, Pose, Unknown};
use mmsim_protocol::{Cell, Heading};
use mmsim_server::{Background, Server, Simulation};
use mmsim_solvers::Distances;

pub use malformed::{good_state, malformed_requests};
pub use wait::{PATIENCE, PATIENCE_MS, exit_of, output, output_of, stop, wait_for, within};

/// The folder of real mazes and transcripts beside the project. They carry no licence, so they are
/// no part of it: where the folder is absent, this says so and the test has nothing to do.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
    if path.exists() {
        return Some(path);
    }
    // Past the test harness, which keeps to itself what passing tests print.
    let _ = writeln!(std::io::stderr(), "skipped, {} is not there", path.display());
    None
}

/// The folder of mazes that the project brings.
pub fn bundled_mazes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../mazes")
}

/// A file of lines that are each a JSON value.
///
/// # Panics
/// The file cannot be read or is no such file.
pub fn json_lines<T: serde::de::DeserializeOwned>(path: &Path) -> Vec<T> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// What a mouse that knows nothing of a maze but its size believes: the goal in the centre.
pub fn classic_map() -> (KnownMaze, Pose) {
    let size = mmsim_maze::MazeSize::CLASSIC;
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    (KnownMaze::new(size, start.cell, size.central_cells()), start)
}

/// Steps from a cell to the goal over what is known.
pub fn known_distance(map: &KnownMaze, from: Cell, unknown: Unknown) -> Option<u16> {
    Distances::flood(map.walls(unknown), map.goals()).at(from)
}

/// A server of this maze on a free port of loopback.
///
/// # Panics
/// There is no free port.
pub fn serve(maze: Maze) -> Background {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    server.spawn(Simulation::new("served", maze))
}

/// A socket of this kind, connected to the server, that gives up after [`PATIENCE`].
///
/// # Panics
/// `ZeroMQ` has no socket left.
pub fn connect(server: &Background, kind: zmq::SocketType) -> zmq::Socket {
    connect_to(server.address(), kind)
}

/// The same for a server of which only the address is known.
///
/// # Panics
/// `ZeroMQ` has no socket left.
pub fn connect_to(address: &str, kind: zmq::SocketType) -> zmq::Socket {
    let socket = zmq::Context::new().socket(kind).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(PATIENCE_MS).unwrap();
    socket.set_sndtimeo(PATIENCE_MS).unwrap();
    socket.connect(address).unwrap();
    socket
}

/// Sends a request and waits for its reply.
///
/// # Panics
/// There is no reply within [`PATIENCE`].
#[track_caller]
pub fn ask(socket: &zmq::Socket, request: &[u8]) -> Vec<u8> {
    let asked = socket.send(request, 0).and_then(|()| socket.recv_bytes(0));
    asked.unwrap_or_else(|error| {
        let start = request.get(..8).unwrap_or(request).escape_ascii();
        panic!("waited {PATIENCE:?} for a reply to {start}: {error}")
    })
}

/// The code in the project's README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;
