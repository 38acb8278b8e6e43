//! A whole client by hand: a flood-fill mouse with a ZeroMQ socket, the wire codec, and the flood
//! of `mmsim-solvers`.
//!
//! Start a simulator with `mmsim`, then run this; an endpoint such as `tcp://127.0.0.1:6574` may be
//! given. `own-strategy.rs` shows how little is left of it with `mmsim-client`.

use std::error::Error;
use std::process::ExitCode;

use mmsim_protocol::{
    Cell, Heading, KnownMaze, MAX_STATE_BYTES, MazeSize, Order, Pose, Reply, Request, Unknown,
    WallsAround, encode_state,
};
use mmsim_solvers::{Distances, open_steps};

/// How long a reply may take, in milliseconds.
const PATIENCE: i32 = 5000;

fn main() -> ExitCode {
    match search() {
        Ok(steps) => {
            println!("goal reached after {steps} steps");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Searches the maze; gives the steps it took to the goal.
fn search() -> Result<u32, Box<dyn Error>> {
    let endpoint = std::env::args().nth(1).unwrap_or("tcp://127.0.0.1:6574".into());
    let simulator = Simulator::connect(endpoint)?;
    simulator.ping()?;
    simulator.reset()?;

    let size = MazeSize::CLASSIC;
    let mut pose = Pose::new(Cell::new(0, 0), Heading::North);
    let mut map = KnownMaze::new(size, pose.cell, size.central_cells());
    let mut steps = 0;
    loop {
        map.observe(pose, simulator.walls(pose)?)?;
        // Unknown walls are taken as open: the hope that drives a search.
        let distances = Distances::flood(map.walls(Unknown::Open), map.goals());
        let distance = |cell| distances.at(cell).unwrap_or(u16::MAX);
        simulator.state(pose, &map, distance)?;
        if map.goals().contains(pose.cell) {
            return Ok(steps);
        }
        // They come in the order front, left, right, back; of equally near cells the first counts.
        let (step, _) = open_steps(&map, pose)
            .filter(|&(_, cell)| distances.at(cell).is_some())
            .min_by_key(|&(_, cell)| distance(cell))
            .ok_or_else(|| format!("no way to the goal is left after {steps} steps"))?;
        pose = pose.after(step).ok_or("expected a wall at the edge of the maze")?;
        steps += 1;
    }
}

/// A socket that is connected to a simulator.
struct Simulator {
    endpoint: String,
    socket: zmq::Socket,
}

impl Simulator {
    /// Connects to a simulator that may not be there yet.
    fn connect(endpoint: String) -> Result<Self, Box<dyn Error>> {
        let socket = zmq::Context::new().socket(zmq::REQ)?;
        socket.set_rcvtimeo(PATIENCE)?;
        socket.set_linger(0)?; // what could not be sent does not keep the program
        let failed = |error| format!("cannot reach {endpoint}, expected tcp://HOST:PORT: {error}");
        socket.connect(&endpoint).map_err(failed)?;
        Ok(Self { endpoint, socket })
    }

    /// Makes sure that there is a simulator.
    fn ping(&self) -> Result<(), Box<dyn Error>> {
        self.demand(Request::Ping, Reply::Pong)
    }

    /// Lets it forget all states.
    fn reset(&self) -> Result<(), Box<dyn Error>> {
        self.demand(Request::Reset, Reply::Ok)
    }

    /// Which walls a mouse in this pose sees.
    fn walls(&self, pose: Pose) -> Result<WallsAround, Box<dyn Error>> {
        let mut buffer = [0; 4];
        let length = Request::Walls(pose).encode(&mut buffer)?;
        match Reply::decode(&self.ask(&buffer[..length])?)? {
            Reply::Walls(around) => Ok(around),
            reply => Err(unexpected(reply)),
        }
    }

    /// Tells what the mouse believes.
    fn state(
        &self,
        pose: Pose,
        map: &KnownMaze,
        weight: impl Fn(Cell) -> u16,
    ) -> Result<(), Box<dyn Error>> {
        let mut buffer = [0; MAX_STATE_BYTES];
        let length = encode_state(&mut buffer, pose, map, weight, Order::F)?;
        expect(Reply::Ok, &self.ask(&buffer[..length])?)
    }

    fn demand(&self, request: Request<'_>, expected: Reply<'_>) -> Result<(), Box<dyn Error>> {
        let mut buffer = [0; 5];
        let length = request.encode(&mut buffer)?;
        expect(expected, &self.ask(&buffer[..length])?)
    }

    /// Sends a request and gives the bytes of its reply.
    fn ask(&self, request: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
        self.socket.send(request, 0)?;
        self.socket.recv_bytes(0).map_err(|error| match error {
            zmq::Error::EAGAIN => format!(
                "no reply from {} within {} s; `mmsim` starts a simulator",
                self.endpoint,
                PATIENCE / 1000
            )
            .into(),
            error => error.into(),
        })
    }
}

fn expect(expected: Reply<'_>, message: &[u8]) -> Result<(), Box<dyn Error>> {
    match Reply::decode(message)? {
        reply if reply == expected => Ok(()),
        reply => Err(unexpected(reply)),
    }
}

/// The error that a reply is where another was expected.
fn unexpected(reply: Reply<'_>) -> Box<dyn Error> {
    match reply {
        Reply::Error(reason) => format!("the simulator refuses that: {reason}").into(),
        reply => format!("the reply is one to another request: {reply:?}").into(),
    }
}
