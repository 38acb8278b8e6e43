//! A running `mmsim` with its page, and clients that connect to it over `ZeroMQ`.

use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{Timeout, Transport, TransportError, Zmq, search_run};
use mmsim_formats::read_maze;
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::Info;
use mmsim_solvers::{BundledStrategy, Mouse};
use mmsim_tests::{TIMEOUT, connect_to};

use crate::harness::{Home, Serving};
use crate::http;
use crate::test_state::TestState;

/// Parses a bundled maze by file name.
pub(crate) fn bundled(name: &str) -> Maze {
    let mut files = mmsim_mazes::FILES.iter();
    files.find(|(file, _)| *file == name).unwrap().1.parse().unwrap()
}

pub(crate) fn maze_at(path: &Path) -> Maze {
    read_maze(path).unwrap()
}

/// Options that select free ports.
const PORTS: [&str; 4] = ["--port", "0", "--viewer-port", "0"];

pub(crate) struct Simulator {
    pub(crate) home: Home,
    pub(crate) serving: Serving,
    /// The URL of the page, without a trailing slash.
    pub(crate) page: String,
    socket: zmq::Socket,
}

impl Simulator {
    /// Starts `mmsim` with these arguments.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::start_in(Home::new(), arguments)
    }

    pub(crate) fn start_in(home: Home, arguments: &[&str]) -> Self {
        let has_port = arguments.contains(&"--viewer-port");
        let ports = if has_port { &PORTS[..2] } else { &PORTS };
        Self::start_until(home, &[ports, arguments].concat())
    }

    /// Starts `mmsim run` with these options and this command of the mouse.
    pub(crate) fn start_mouse(home: Home, options: &[&str], mouse: &[&str]) -> Self {
        let arguments = [&["run"], &PORTS[..], options, &["--"], mouse].concat();
        let mut simulator = Self::start_until(home, &arguments);
        simulator.serving.has_mouse = true;
        simulator
    }

    fn start_until(home: Home, arguments: &[&str]) -> Self {
        let serving = home.serve_until(arguments, "watch at");
        let page = page_address(&serving);
        let socket = connect(&serving.address);
        Self { home, serving, page, socket }
    }

    pub(crate) fn request(&self, request: &[u8]) -> Vec<u8> {
        mmsim_tests::ask(&self.socket, request)
    }

    /// Sends a request and asserts that the reply is `ok`.
    pub(crate) fn send(&self, request: &[u8]) {
        assert_eq!(self.request(request).escape_ascii().to_string(), "ok");
    }

    /// Replaces the client by one that has sent nothing. While a client that has sent states is
    /// connected, the page runs no mouse. `Socket::disconnect` would not close the connection.
    pub(crate) fn disconnect(&mut self) {
        self.socket = connect(&self.serving.address);
    }

    pub(crate) fn send_all(&self, requests: &[Vec<u8>]) {
        for request in requests {
            self.send(request);
        }
    }

    pub(crate) fn info(&self) -> Info {
        serde_json::from_slice(&self.request(b"info")).unwrap()
    }

    /// Returns the number of the current run.
    pub(crate) fn run_number(&self) -> u64 {
        http::get(&self.url("/api/sources/live")).json()["run"].as_u64().unwrap()
    }

    /// Runs a bundled strategy and returns the states that it sent.
    pub(crate) fn search(&self, maze: &Maze, strategy: BundledStrategy) -> Vec<TestState> {
        let zmq = Zmq::connect(&self.serving.address, Timeout::After(TIMEOUT), |_| {}).unwrap();
        let mut transport = StateRecorder { zmq, states: Vec::new() };
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
        search_run(&mut transport, &mut mouse, 10_000, |_, _| ControlFlow::Continue(())).unwrap();
        transport.states.iter().map(|message| TestState::decode(message, maze.size())).collect()
    }

    /// Returns the URL of a path.
    pub(crate) fn url(&self, path: &str) -> String {
        format!("{}{path}", self.page)
    }
}

/// Returns the URL of the page from a server's output, without a trailing slash.
pub(crate) fn page_address(serving: &Serving) -> String {
    let rest = serving.messages.split("watch at ").nth(1).unwrap();
    rest.lines().next().unwrap().trim_end_matches('/').to_string()
}

/// Connects a REQ socket with timeouts.
pub(crate) fn connect(address: &str) -> zmq::Socket {
    connect_to(address, zmq::REQ)
}

/// A transport that collects the states that a client sends.
struct StateRecorder<'a> {
    zmq: Zmq<'a>,
    states: Vec<Vec<u8>>,
}

impl Transport for StateRecorder<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        if request.first() == Some(&b'S') {
            self.states.push(request.to_vec());
        }
        self.zmq.exchange(request, reply)
    }
}
