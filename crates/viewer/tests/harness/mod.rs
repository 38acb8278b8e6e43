//! A simulator with a viewer, and an HTTP client.
#![allow(dead_code, unreachable_pub, missing_docs)] // no test file uses all of it

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, Maze};
use mmsim_mouse::MouseControl;
use mmsim_protocol::{MapState, Order};
use mmsim_recording::Recorder;
use mmsim_server::{Background, Server, Simulation};
use mmsim_tests::{TIMEOUT, ask, connect, stop, wait_for, within};
use mmsim_viewer::{Limits, Viewer, ViewerConfig, ViewerHandle};
use serde_json::Value;

pub const SMALL: &str =
    "o---o---o---o\n|           |\no   o---o   o\n| S |     G |\no---o---o---o\n";
pub const CLOSED: &str = "o---o---o\n| S | G |\no---o---o\n";

/// A simulator with a viewer.
pub struct WatchedServer {
    pub server: Background,
    pub viewer: ViewerHandle,
    pub host: String,
}

impl WatchedServer {
    pub fn new(host: &str, recordings: Option<&Path>) -> Self {
        Self::with_limits(host, recordings, Limits::default())
    }

    pub fn with_limits(host: &str, recordings: Option<&Path>, limits: Limits) -> Self {
        Self::with_mouse(host, recordings, limits, Arc::default())
    }

    pub fn with_mouse(
        host: &str,
        recordings: Option<&Path>,
        limits: Limits,
        control: Arc<MouseControl>,
    ) -> Self {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let viewer = Viewer::bind(host, 0).unwrap().with_limits(limits);
        let mazes = Catalogue::from_texts(&[
            ("a/small.txt", SMALL),
            ("closed.txt", CLOSED),
            ("invalid.txt", "?"),
        ]);
        let config = ViewerConfig::default()
            .with_live(&server, "a/small.txt".as_ref())
            .with_mouse(control)
            .with_mazes(mazes)
            .with_recordings(recordings.map(Path::to_path_buf));
        let monitor = server.monitor();
        let recorder = recordings.map(|folder| Recorder::new(folder).unwrap());
        let server = server.with_recorder(recorder).spawn(Simulation::new("small", maze()));
        let viewer = viewer.spawn(config).unwrap();
        // The first run starts with the server.
        wait_for("the server to start", || (monitor.status().run == 1).then_some(()));
        let port = viewer.address().split(':').nth(2).unwrap();
        let port = port.split('/').next().unwrap().to_string();
        Self { server, viewer, host: format!("127.0.0.1:{port}") }
    }

    /// Connects to the viewer with generous timeouts.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream.set_write_timeout(Some(TIMEOUT)).unwrap();
        stream
    }

    /// Sends a request with additional headers.
    pub fn send(&self, method: &str, path: &str, headers: &[&str], body: &[u8]) -> Response {
        let Self { host, .. } = self;
        let mut stream = self.connect();
        let length = format!("content-length: {}", body.len());
        let host = format!("host: {host}");
        let host =
            if headers.iter().any(|header| header.starts_with("host:")) { "" } else { &host };
        let request = format!("{method} {path} HTTP/1.1");
        let lines = [&[request.as_str(), "connection: close", &length, host], headers].concat();
        let lines: Vec<_> = lines.into_iter().filter(|line| !line.is_empty()).collect();
        let head = lines.join("\r\n") + "\r\n";
        stream.write_all(&[head.as_bytes(), b"\r\n", body].concat()).unwrap();
        Response::read(stream)
    }

    pub fn get(&self, path: &str) -> Response {
        self.send("GET", path, &[], b"")
    }

    pub fn post(&self, path: &str, body: &Value) -> Response {
        let origin = format!("origin: http://{}", self.host);
        self.send(
            "POST",
            path,
            &[&origin, "content-type: application/json"],
            body.to_string().as_bytes(),
        )
    }

    /// Requests an action of a mouse.
    pub fn act(&self, action: &Value) -> Response {
        self.post("/api/mouse", action)
    }

    /// Sends `count` states as a client and returns them. In consecutive states, the mouse is in
    /// different cells.
    pub fn send_states(&self, count: usize) -> Vec<Vec<u8>> {
        let client = connect(&self.server, zmq::REQ);
        (0..count)
            .map(|number| {
                let state = state(number);
                assert_eq!(ask(&client, &state), b"ok");
                state
            })
            .collect()
    }

    pub fn stop(self) {
        stop_viewer(self.viewer);
        stop(self.server);
    }
}

pub fn stop_viewer(viewer: ViewerHandle) {
    within("the page to stop", || viewer.stop());
}

pub struct Response {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Response {
    pub fn read(mut stream: TcpStream) -> Self {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        Self::parse(&bytes)
    }

    pub fn parse(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|end| end == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap().to_lowercase();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let mut body = bytes[end + 4..].to_vec();
        if head.contains("transfer-encoding: chunked") {
            body = decode_chunks(&body);
        }
        Self { status, head, body }
    }

    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(self.text()).unwrap_or_else(|_| panic!("{}", self.text()))
    }
}

fn decode_chunks(mut body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    while let Some(line) = body.windows(2).position(|end| end == b"\r\n") {
        let length =
            usize::from_str_radix(std::str::from_utf8(&body[..line]).unwrap(), 16).unwrap();
        whole.extend_from_slice(&body[line + 2..line + 2 + length]);
        body = &body[line + 4 + length..];
    }
    whole
}

pub fn maze() -> Maze {
    SMALL.parse().unwrap()
}

pub fn state(number: usize) -> Vec<u8> {
    let cells = [(0, 0), (0, 1), (1, 1), (2, 1)];
    let (x, y) = cells[number % cells.len()];
    let mut pose = maze().start();
    pose.cell = Cell::new(x, y);
    let map = mmsim_maze::KnownMaze::unexplored(&maze());
    let mut buffer = [0; 64];
    let weight = |cell: Cell| u16::try_from(number % 100).unwrap() + u16::from(cell.x);
    let length = MapState::new(pose, &map, weight, Order::C).encode(&mut buffer).unwrap();
    let mut state = buffer[..length].to_vec();
    // The start: visited, with walls to the east, west and south.
    state[length - 6] = 1 | 2 | 4 | 8;
    state
}
