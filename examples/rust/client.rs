//! A complete client that does not use `mmsim-client`. The flood-fill mouse talks to the simulator
//! over a ZeroMQ socket, using the wire codec, and computes distances with `mmsim-solvers`.
//!
//! Start a simulator with `mmsim`, then run this program, optionally with an endpoint such as
//! `tcp://127.0.0.1:6574`. The `own-strategy.rs` example is shorter because it uses `mmsim-client`.

use std::error::Error;
use std::process::ExitCode;

use mmsim_protocol::{
    Cell, Heading, KnownMaze, MAX_STATE_BYTES, MapState, MazeSize, Order, Pose, Reply, Request,
    Unknown, WallsAround,
};
use mmsim_solvers::{Distances, open_steps};

/// Time limit for a reply, in milliseconds.
const TIMEOUT_MS: i32 = 5000;

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

/// Searches the maze and returns the number of steps to the goal.
fn search() -> Result<u32, Box<dyn Error>> {
    let variable = std::env::var("MMSIM_ENDPOINT").ok();
    let endpoint = std::env::args().nth(1).or_else(|| variable.clone());
    let endpoint = endpoint.unwrap_or("tcp://127.0.0.1:6574".into());
    // `mmsim run` sets the variable. It holds replies while the mouse is paused.
    let timeout_ms = if variable == Some(endpoint.clone()) { -1 } else { TIMEOUT_MS };
    let simulator = Simulator::connect(endpoint, timeout_ms)?;
    simulator.ping()?;
    simulator.reset()?;

    let size = MazeSize::CLASSIC;
    let mut pose = Pose::new(Cell::new(0, 0), Heading::North);
    let mut map = KnownMaze::new(size, pose.cell, size.central_cells());
    let mut steps = 0;
    loop {
        map.observe(pose, simulator.walls(pose)?)?;
        // Optimistic distances, with unknown walls open, lead the mouse into unexplored cells.
        let distances = Distances::flood(map.walls(Unknown::Open), map.goals());
        let distance = |cell| distances.at(cell).unwrap_or(u16::MAX);
        simulator.state(pose, &map, distance)?;
        if map.goals().contains(pose.cell) {
            return Ok(steps);
        }
        // On a tie, `min_by_key` returns the first step in the order front, left, right, back.
        let (step, _) = open_steps(&map, pose)
            .filter(|&(_, cell)| distances.at(cell).is_some())
            .min_by_key(|&(_, cell)| distance(cell))
            .ok_or_else(|| format!("goal unreachable after {steps} steps"))?;
        pose = pose.after(step).ok_or("expected a wall at the edge of the maze")?;
        steps += 1;
    }
}

/// A connection to a simulator.
struct Simulator {
    endpoint: String,
    socket: zmq::Socket,
}

impl Simulator {
    /// Connects to a simulator. The simulator may be started later. A timeout of -1 is no timeout.
    fn connect(endpoint: String, timeout_ms: i32) -> Result<Self, Box<dyn Error>> {
        let socket = zmq::Context::new().socket(zmq::REQ)?;
        socket.set_rcvtimeo(timeout_ms)?;
        socket.set_linger(0)?; // do not wait for unsent requests on exit
        let failed = |error| format!("cannot reach {endpoint}: {error} (expected tcp://HOST:PORT)");
        socket.connect(&endpoint).map_err(failed)?;
        Ok(Self { endpoint, socket })
    }

    /// Checks that the simulator replies.
    fn ping(&self) -> Result<(), Box<dyn Error>> {
        self.demand(Request::Ping, Reply::Pong)
    }

    /// Deletes all states in the simulator.
    fn reset(&self) -> Result<(), Box<dyn Error>> {
        self.demand(Request::Reset, Reply::Ok)
    }

    /// Returns the walls around a mouse in this pose.
    fn walls(&self, pose: Pose) -> Result<WallsAround, Box<dyn Error>> {
        let mut buffer = [0; 4];
        let length = Request::Walls(pose).encode(&mut buffer)?;
        match Reply::decode(&self.ask(&buffer[..length])?)? {
            Reply::Walls(around) => Ok(around),
            reply => Err(unexpected(reply)),
        }
    }

    /// Reports the pose, the map and the weights of the mouse.
    fn state(
        &self,
        pose: Pose,
        map: &KnownMaze,
        weight: impl Fn(Cell) -> u16,
    ) -> Result<(), Box<dyn Error>> {
        let mut buffer = [0; MAX_STATE_BYTES];
        let length = MapState::new(pose, map, weight, Order::F).encode(&mut buffer)?;
        expect(Reply::Ok, &self.ask(&buffer[..length])?)
    }

    fn demand(&self, request: Request<'_>, expected: Reply<'_>) -> Result<(), Box<dyn Error>> {
        let mut buffer = [0; 5];
        let length = request.encode(&mut buffer)?;
        expect(expected, &self.ask(&buffer[..length])?)
    }

    /// Sends a request and returns the bytes of its reply.
    fn ask(&self, request: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
        self.socket.send(request, 0)?;
        self.socket.recv_bytes(0).map_err(|error| match error {
            zmq::Error::EAGAIN => format!(
                "no reply from {} within {} s (start a simulator with `mmsim`)",
                self.endpoint,
                TIMEOUT_MS / 1000
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

/// Returns the error for an unexpected reply.
fn unexpected(reply: Reply<'_>) -> Box<dyn Error> {
    match reply {
        Reply::Error(reason) => format!("the simulator refused the request: {reason}").into(),
        reply => format!("unexpected reply: {reply:?}").into(),
    }
}
