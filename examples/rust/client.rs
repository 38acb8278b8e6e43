//! A whole client by hand: a left-wall follower with a ZeroMQ socket and the wire codec, and
//! nothing else of this project.
//!
//! Start a simulator with `mmsim --maze hedgerow`, whose goal a wall follower reaches, then run
//! this; an endpoint such as `tcp://127.0.0.1:6574` may be given.

use std::error::Error;
use std::process::ExitCode;

use mmsim_protocol::{
    Cell, Heading, KnownMaze, MAX_STATE_BYTES, MazeSize, Order, Pose, Reply, Request, Step,
    encode_state,
};

const MAX_STEPS: u32 = 1000;

fn main() -> ExitCode {
    match search() {
        Ok(Some(steps)) => {
            println!("goal reached after {steps} steps");
            ExitCode::SUCCESS
        }
        Ok(None) => {
            println!("goal not reached after {MAX_STEPS} steps");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Searches the maze; gives the steps it took to the goal, `None` if they were not enough.
fn search() -> Result<Option<u32>, Box<dyn Error>> {
    let endpoint = std::env::args().nth(1).unwrap_or("tcp://127.0.0.1:6574".into());
    let socket = zmq::Context::new().socket(zmq::REQ)?;
    socket.connect(&endpoint).map_err(|error| format!("cannot reach {endpoint}: {error}"))?;

    let size = MazeSize::CLASSIC;
    let mut pose = Pose::new(Cell::new(0, 0), Heading::North);
    let mut map = KnownMaze::new(size, pose.cell, size.central_cells());
    let mut visits = [[0; 16]; 16];
    let mut buffer = [0; MAX_STATE_BYTES];

    let length = Request::Reset.encode(&mut buffer)?;
    ask(&socket, &buffer[..length])?;
    for steps in 0..=MAX_STEPS {
        let length = Request::Walls(pose).encode(&mut buffer)?;
        let reply = ask(&socket, &buffer[..length])?;
        let Reply::Walls(around) = Reply::decode(&reply)? else {
            return Err("expected three bytes of walls".into());
        };
        map.note(pose, around)?;

        visits[usize::from(pose.cell.x)][usize::from(pose.cell.y)] += 1;
        let weight = |cell: Cell| visits[usize::from(cell.x)][usize::from(cell.y)];
        let length = encode_state(&mut buffer, pose, &map, weight, Order::C)?;
        ask(&socket, &buffer[..length])?;

        if map.goals().contains(pose.cell) {
            return Ok(Some(steps));
        }
        // The left hand on the wall. In a dead end it turns round.
        let step = if !around.left {
            Step::Left
        } else if !around.front {
            Step::Front
        } else if !around.right {
            Step::Right
        } else {
            Step::Back
        };
        pose = pose.after(step).ok_or("expected a wall at the edge of the maze")?;
    }
    Ok(None)
}

/// Sends a request and gives its reply, unless that says that the request was refused.
fn ask(socket: &zmq::Socket, request: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    socket.send(request, 0)?;
    let reply = socket.recv_bytes(0)?;
    match Reply::decode(&reply)? {
        Reply::Error(reason) => Err(reason.into()),
        _ => Ok(reply),
    }
}
