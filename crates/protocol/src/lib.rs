//! The wire protocol between a search client and a micromouse maze simulator: bytes to values and
//! back.
//!
//! A client asks over one ZeroMQ REQ socket and gets exactly one reply to each request:
//!
//! | request | bytes | reply |
//! |---|---|---|
//! | ping | `ping` | `pong` |
//! | reset | `reset` | `ok`; all states are forgotten |
//! | walls | `W` x y heading | three bytes, 0 or 1: a wall to the left, in front, to the right |
//! | state | `S` x y heading order weights order walls | `ok`; the state is kept |
//! | info (this project's server only) | `info` | JSON: the maze's name, size, start and goals |
//!
//! Anything else is answered with `error: `, what was expected and what was found.
//!
//! Decoding is total: any bytes give a value or an error that says what was expected. Nothing is
//! copied or allocated: [`Request::decode`] and [`Reply::decode`] borrow from the caller's bytes,
//! `encode` writes into the caller's buffer. The crate is `no_std`, so it fits into a mouse's
//! firmware. It knows no socket; any that speaks ZeroMQ will do.
//!
//! # A whole client
//! A wall follower, with the crate `zmq` for the socket. It runs against any simulator that
//! listens on port 6574, such as `mmsim`.
//!
//! ```no_run
//! use mmsim_protocol::{Cell, Heading, KnownMaze, MazeSize, Order, Pose, Reply, Request, Step};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let socket = zmq::Context::new().socket(zmq::REQ)?;
//!     socket.connect("tcp://127.0.0.1:6574")?;
//!     let ask = |request: &[u8]| socket.send(request, 0).and_then(|()| socket.recv_bytes(0));
//!     let (size, mut buffer) = (MazeSize::CLASSIC, [0; mmsim_protocol::MAX_STATE_BYTES]);
//!     let mut pose = Pose::new(Cell::new(0, 0), Heading::North);
//!     let mut map = KnownMaze::new(size, pose.cell, size.central_cells());
//!     ask(b"reset")?;
//!     loop {
//!         let length = Request::Walls(pose).encode(&mut buffer)?;
//!         let reply = ask(&buffer[..length])?;
//!         let Reply::Walls(around) = Reply::decode(&reply)? else { return Err("no walls".into()) };
//!         map.observe(pose, around)?;
//!         let visited = |cell| u16::from(map.visited().contains(cell));
//!         let length = mmsim_protocol::encode_state(&mut buffer, pose, &map, visited, Order::C)?;
//!         ask(&buffer[..length])?;
//!         if map.goals().contains(pose.cell) { return Ok(()) }
//!         let walls = [(Step::Left, around.left), (Step::Front, around.front), (Step::Right, around.right)];
//!         let open = walls.iter().find(|(_, wall)| !wall).map_or(Step::Back, |(step, _)| *step);
//!         pose = pose.after(open).ok_or("off the map")?;
//!     }
//! }
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(any(test, feature = "std")), no_std)]

#[cfg(feature = "info")]
extern crate alloc;

mod belief;
#[cfg(feature = "info")]
mod info;
mod reply;
mod request;
mod state;

pub use mmsim_maze::{
    Cell, CellSet, Contradiction, Heading, KnownMaze, MazeSize, Pose, SizeError, Step, TextPicture,
    Unknown, WallState, WallsAround,
};

#[cfg(feature = "info")]
pub use info::Info;
pub use reply::{ERROR_PREFIX, Reply, UnknownReply};
pub use request::{Excerpt, Request, RequestError};
pub use state::{CellWalls, MAX_STATE_BYTES, Matrix, Order, State, encode_state, state_bytes};

/// The version of the protocol, as `info` tells it.
pub const PROTOCOL_VERSION: u32 = 1;

/// The port on which simulators listen unless told otherwise.
pub const DEFAULT_PORT: u16 = 6574;

/// A caller's buffer that cannot hold a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a buffer of at least {expected} bytes, found {found}")]
pub struct BufferTooSmall {
    /// The length of the message in bytes.
    pub expected: usize,
    /// The length of the buffer in bytes.
    pub found: usize,
}

/// The first `length` bytes of the buffer.
fn front_of(buffer: &mut [u8], length: usize) -> Result<&mut [u8], BufferTooSmall> {
    let found = buffer.len();
    buffer.get_mut(..length).ok_or(BufferTooSmall { expected: length, found })
}

/// Writes a message of fixed bytes; gives its length.
fn write_bytes(buffer: &mut [u8], message: &[u8]) -> Result<usize, BufferTooSmall> {
    front_of(buffer, message.len())?.copy_from_slice(message);
    Ok(message.len())
}

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
