//! The wire protocol between a search client and a micromouse maze simulator.
//!
//! A client sends requests over one ZeroMQ REQ socket and receives exactly one reply to each:
//!
//! | request | bytes | reply |
//! |---|---|---|
//! | ping | `ping` | `pong` |
//! | reset | `reset` | `ok`; all states are deleted |
//! | walls | `W` x y heading | three bytes, 0 or 1: walls to the left, in front, to the right |
//! | state | `S` x y heading order weights order walls | `ok`; the state is stored |
//! | info (this project's server only) | `info` | JSON: the maze's name, size, start and goals |
//! | annotations (if `info` lists them) | `A` annotations | `ok`; they belong to the next state |
//!
//! If the simulator cannot serve a request, the reply begins with `error:` and gives the reason.
//!
//! Decoding never panics: any bytes result in a value or an error. The crate allocates no memory:
//! `decode` borrows from the caller's bytes, and `encode` writes into the caller's buffer.
//! [`StateMessage`] decodes each field of a state only on demand. The crate is `no_std`, so it also
//! runs in a mouse's firmware. The crate works with any ZeroMQ library.
//!
//! # A complete client
//!
//! This wall follower uses the `zmq` crate and works with any simulator that listens on port 6574,
//! such as `mmsim`.
//!
//! ```no_run
//! use mmsim_protocol::{
//!     Cell, Heading, KnownMaze, MapState, MazeSize, Order, Pose, Reply, Request, Step,
//! };
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
//!         let length = MapState::new(pose, &map, visited, Order::C).encode(&mut buffer)?;
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
// Marks the items of optional features on docs.rs.
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "info")]
extern crate alloc;

mod annotation_writer;
mod annotations;
mod error;
#[cfg(feature = "info")]
mod info;
mod layout;
mod matrix;
mod message;
mod reply;
mod request;
mod state;

pub use mmsim_maze::{
    Cell, CellSet, Colour, Contradiction, Excerpt, Heading, KnownMaze, MazeSize, Pose, SizeError,
    Step, TextPicture, Unknown, WallState, WallsAround,
};

pub use annotation_writer::{AnnotationError, AnnotationWriter};
pub use annotations::{
    Annotation, Annotations, MAX_LOG_BYTES, MAX_NAME_BYTES, MAX_TEXT_BYTES, MAX_TEXT_CHARS,
    colour_from_letter, colour_letter, wall_from_letter, wall_letter,
};
pub use error::RequestError;
#[cfg(feature = "info")]
pub use info::{ANNOTATIONS, Info};
pub use layout::{BufferTooSmall, MAX_ANNOTATIONS_BYTES, MAX_STATE_BYTES, state_bytes};
pub use matrix::{CellWalls, Matrix, Order};
pub use message::StateMessage;
pub use reply::{CRASH_PREFIX, ERROR_PREFIX, Reply, UnknownReply};
pub use request::{DEFAULT_PORT, PROTOCOL_VERSION, Request};
pub use state::{MapState, State};

/// Compiles and runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
