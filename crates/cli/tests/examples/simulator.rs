//! A simulator that records each request, and may stop replying.

use std::thread::{self, JoinHandle};

use mmsim_maze::Maze;
use mmsim_server::{ReplyBuffer, Simulation};
use mmsim_tests::within;

/// A message that ends the simulator's thread and is not part of the protocol.
const END: &[u8] = b"end";

/// A simulator on a free port of the loopback interface.
pub(crate) struct Simulator {
    pub(crate) endpoint: String,
    thread: JoinHandle<Vec<Vec<u8>>>,
}

impl Simulator {
    /// Serves a maze in the text format.
    pub(crate) fn serve(maze: &str) -> Self {
        Self::start(maze, |_| true)
    }

    /// Serves a maze in the text format. `may_reply` receives the number of earlier requests. It may
    /// delay the reply, and returns false to stop the simulator.
    pub(crate) fn start(maze: &str, may_reply: impl Fn(usize) -> bool + Send + 'static) -> Self {
        let mut simulation = Simulation::new("captured", maze.parse::<Maze>().unwrap());
        let socket = zmq::Context::new().socket(zmq::REP).unwrap();
        socket.bind("tcp://127.0.0.1:*").unwrap();
        let endpoint = socket.get_last_endpoint().unwrap().unwrap();
        let thread = thread::spawn(move || {
            let (mut requests, mut reply) = (Vec::new(), ReplyBuffer::new());
            loop {
                let request = socket.recv_bytes(0).unwrap();
                if request == END {
                    return requests;
                }
                if !may_reply(requests.len()) {
                    return requests;
                }
                simulation.handle(&request, &mut reply);
                socket.send(&reply, 0).unwrap();
                requests.push(request);
            }
        });
        Self { endpoint, thread }
    }

    /// Stops the simulator and returns all answered requests.
    pub(crate) fn requests(self) -> Vec<Vec<u8>> {
        let socket = zmq::Context::new().socket(zmq::REQ).unwrap();
        socket.set_linger(0).unwrap();
        socket.connect(&self.endpoint).unwrap();
        // If the simulator has already stopped, the message is lost.
        socket.send(END, 0).unwrap();
        within("the simulator to end", || self.thread.join()).unwrap()
    }
}
