//! A real `mmsim` that serves the page, and clients that talk to it over `ZeroMQ`.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{Transport, TransportError, Zmq, search_run};
use mmsim_maze::{KnownMaze, Maze};
use mmsim_protocol::Info;
use mmsim_solvers::{BundledStrategy, Mouse};
use mmsim_tests::{PATIENCE, bundled_mazes, connect_to};

use crate::harness::{Home, Serving};
use crate::http;
use crate::told::Told;

/// A bundled maze, by the name of its file.
pub(crate) fn bundled(name: &str) -> Maze {
    maze_at(&bundled_mazes().join(name))
}

pub(crate) fn maze_at(path: &Path) -> Maze {
    fs::read_to_string(path).unwrap().parse().unwrap()
}

/// A simulator with its page.
pub(crate) struct Simulator {
    pub(crate) home: Home,
    pub(crate) serving: Serving,
    /// The address of the page, without a slash at its end.
    pub(crate) page: String,
    socket: zmq::Socket,
}

impl Simulator {
    /// Serves with these arguments, such as a maze.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::start_in(Home::new(), arguments)
    }

    pub(crate) fn start_in(home: Home, arguments: &[&str]) -> Self {
        let ports = ["--port", "0", "--viewer-port", "0"];
        let serving = home.serve_until(&[&ports, arguments].concat(), "watch at");
        let page = page_address(&serving);
        let socket = connect(&serving.address);
        Self { home, serving, page, socket }
    }

    pub(crate) fn ask(&self, request: &[u8]) -> Vec<u8> {
        mmsim_tests::ask(&self.socket, request)
    }

    /// Sends a message that must be accepted.
    pub(crate) fn send(&self, request: &[u8]) {
        assert_eq!(self.ask(request).escape_ascii().to_string(), "ok");
    }

    pub(crate) fn send_all(&self, requests: &[Vec<u8>]) {
        for request in requests {
            self.send(request);
        }
    }

    pub(crate) fn info(&self) -> Info {
        serde_json::from_slice(&self.ask(b"info")).unwrap()
    }

    /// The number of the run that goes on.
    pub(crate) fn run(&self) -> u64 {
        http::get(&self.at("/api/sources/live")).json()["run"].as_u64().unwrap()
    }

    /// Lets a bundled mouse search, and gives all that it has told.
    pub(crate) fn search(&self, maze: &Maze, strategy: BundledStrategy) -> Vec<Told> {
        let zmq = Zmq::connect(&self.serving.address, Some(PATIENCE), |_| {}).unwrap();
        let mut heard = Heard { zmq, states: Vec::new() };
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
        search_run(&mut heard, &mut mouse, 10_000, |_, _| ControlFlow::Continue(())).unwrap();
        heard.states.iter().map(|message| Told::read(message, maze.size())).collect()
    }

    /// Where something else than the page itself is.
    pub(crate) fn at(&self, path: &str) -> String {
        format!("{}{path}", self.page)
    }
}

/// The address of the page that a server has said, without a slash at its end.
pub(crate) fn page_address(serving: &Serving) -> String {
    let rest = serving.said.split("watch at ").nth(1).unwrap();
    rest.trim().trim_end_matches('/').to_string()
}

/// A socket that gives up after some time.
pub(crate) fn connect(address: &str) -> zmq::Socket {
    connect_to(address, zmq::REQ)
}

/// Hears which states a client sends.
struct Heard<'a> {
    zmq: Zmq<'a>,
    states: Vec<Vec<u8>>,
}

impl Transport for Heard<'_> {
    fn exchange(&mut self, request: &[u8], reply: &mut Vec<u8>) -> Result<(), TransportError> {
        if request.first() == Some(&b'S') {
            self.states.push(request.to_vec());
        }
        self.zmq.exchange(request, reply)
    }
}
