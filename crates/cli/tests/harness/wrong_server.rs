//! A server that makes mistakes.

use std::thread::{self, JoinHandle};

use mmsim_maze::Maze;
use mmsim_server::Simulation;
use mmsim_tests::{TIMEOUT_MS, connect_to, within};

/// A message that ends the server's thread and is not part of the protocol.
const END: &[u8] = b"end";

/// Receives a request and the right reply, and returns the frames to send instead. Without any
/// frames, the server does not reply.
pub type Change = fn(&[u8], Vec<u8>) -> Vec<Vec<u8>>;

/// A server with a 16x16 maze whose replies are changed.
pub struct WrongServer {
    pub endpoint: String,
    thread: Option<JoinHandle<()>>,
}

impl WrongServer {
    /// Starts a server on a free port of the loopback interface.
    pub fn start(mut change: impl FnMut(&[u8], Vec<u8>) -> Vec<Vec<u8>> + Send + 'static) -> Self {
        let maze: Maze = mmsim_mazes::HARBOUR.parse().unwrap();
        let mut simulation = Simulation::new("harbour", maze);
        // Unlike a REP socket, a ROUTER socket can skip a reply.
        let socket = zmq::Context::new().socket(zmq::ROUTER).unwrap();
        socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
        socket.bind("tcp://127.0.0.1:*").unwrap();
        let endpoint = socket.get_last_endpoint().unwrap().unwrap();
        let thread = thread::spawn(move || {
            loop {
                let mut frames = socket.recv_multipart(0).unwrap();
                let request = frames.pop().unwrap();
                if request == END {
                    return;
                }
                let mut reply = Vec::new();
                simulation.handle(&request, &mut reply);
                let reply = change(&request, reply);
                if !reply.is_empty() {
                    // The client's routing id and the empty delimiter.
                    frames.truncate(2);
                    frames.extend(reply);
                    socket.send_multipart(frames, 0).unwrap();
                }
            }
        });
        Self { endpoint, thread: Some(thread) }
    }
}

impl Drop for WrongServer {
    fn drop(&mut self) {
        let socket = connect_to(&self.endpoint, zmq::REQ);
        socket.send(END, 0).unwrap();
        let thread = self.thread.take().unwrap();
        within("the wrong server to end", || drop(thread.join()));
        drop(socket);
    }
}
