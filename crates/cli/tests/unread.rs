//! A server whose stderr is an open pipe that no process reads.

mod harness;

use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStderr, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;

use harness::{Home, read_until};
use mmsim_tests::{TIMEOUT, TIMEOUT_MS};

/// The number of refused requests: enough to fill both the pipe and the queue with log messages.
const REQUESTS: usize = 20_000;

struct Unread {
    child: Child,
    stderr: Option<BufReader<ChildStderr>>,
    socket: zmq::Socket,
}

impl Unread {
    /// Starts a server that logs each refused request, and sends enough requests to fill the pipe.
    fn start(home: &Home) -> Self {
        let mut command = home.server(&["-vv", "--port", "0"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let (stderr, messages) = read_until(child.stderr.take().unwrap(), "tcp://");
        let address = messages.split("tcp://").nth(1).unwrap().split(';').next().unwrap();
        let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
        socket.set_linger(0).unwrap();
        socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
        socket.connect(&format!("tcp://{address}")).unwrap();
        let server = Self { child, stderr: Some(stderr), socket };
        for number in 0..REQUESTS {
            let reply = server.ask("nonsense");
            let reply = reply.unwrap_or_else(|error| panic!("request {number}: {error}"));
            assert!(reply.starts_with(b"error: "), "{}", reply.escape_ascii());
        }
        server
    }

    fn ask(&self, request: &str) -> zmq::Result<Vec<u8>> {
        self.socket.send(request, 0)?;
        self.socket.recv_bytes(0)
    }
}

impl Drop for Unread {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Reads lines until a line contains the text. Returns this line.
fn line_with(lines: &Receiver<String>, text: &str) -> String {
    loop {
        let line = lines.recv_timeout(TIMEOUT);
        let line = line.unwrap_or_else(|error| panic!("no line with {text:?}: {error}"));
        if line.contains(text) {
            return line;
        }
    }
}

#[test]
fn a_full_stderr_pipe_does_not_block_the_server() {
    let mut server = Unread::start(&Home::new());
    let stderr = server.stderr.take().unwrap();
    let (send, lines) = mpsc::channel();
    thread::spawn(move || {
        stderr.lines().map_while(Result::ok).try_for_each(|line| send.send(line))
    });
    let lost = line_with(&lines, "messages lost");
    let lost: usize = lost.split(' ').next().unwrap().parse().unwrap();
    assert!((1..REQUESTS).contains(&lost), "{lost}");
    server.ask("more nonsense").unwrap();
    line_with(&lines, "more nonsense");
}

#[cfg(unix)]
#[test]
fn a_full_stderr_pipe_does_not_block_shutdown() {
    let mut server = Unread::start(&Home::new());
    let kill = format!("kill -s TERM {}", server.child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(mmsim_tests::wait_for_exit(&mut server.child).code(), Some(0));
}
