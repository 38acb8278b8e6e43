//! A ZeroMQ REP server without libzmq: a sans-IO codec of ZMTP 3.1, and a server on one thread with
//! bounded memory.
//!
//! Implement [`Service`], then [`RepServer::run`] answers every REQ and DEALER client.
//!
//! ```
//! use mmsim_zmtp::codec::ProtocolError;
//! use mmsim_zmtp::{RepServer, Service, listen};
//!
//! struct Greeter;
//!
//! impl Service for Greeter {
//!     fn answer(&mut self, request: &[u8], _frames: usize, reply: &mut Vec<u8>) -> bool {
//!         *reply = [b"hello ", request].concat();
//!         true
//!     }
//!
//!     fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
//!         *reply = reason.to_string().into();
//!     }
//! }
//!
//! let mut server = RepServer::new(listen("127.0.0.1", 0)?)?;
//! println!("listening on {}", server.local_address()?);
//! let is_stopping = || true; // usually an atomic flag, set before `Waker::wake`
//! server.run(&mut Greeter, is_stopping)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//!
//! - Every request gets exactly one reply, in order, with its envelope. A frame over the limit gets one
//!   error from [`Service::refuse`].
//! - No input panics or stops the server. A client that violates the protocol is disconnected.
//! - Memory is bounded: a connection holds less than 100 KiB and there are at most
//!   [`MAX_CONNECTIONS`](limits::MAX_CONNECTIONS), if replies are short. The server stops reading a
//!   client that does not read its replies.
//! - Clients take turns. At the maximum number of connections, those without activity make room for
//!   newcomers; one network cannot keep all places.
//! - Nothing is lost on a regular stop: requests that are on their way are answered.
//!
//! # Structure
//!
//! - [`codec`] turns bytes into events and back without I/O.
//! - [`connection`] adds buffers around a non-blocking stream of any kind.
//! - The connections of a server, with their turns, deadlines and evictions, get the time as an
//!   argument, so that unit tests use made-up times.
//! - [`RepServer`] adds sockets and the clock.
//!
//! # Scope
//!
//! The crate has one socket type, REP, and one transport, TCP. It accepts REQ and DEALER clients of
//! ZMTP 3.0 and 3.1 (`ZeroMQ` 4), and of ZMTP 2.0. It has no security mechanism: neither passwords
//! (PLAIN) nor encryption (CURVE). It does not initiate connections or send heartbeats, but answers
//! PING. Requests are short: [`limits`] has all limits, which are constants.
//!
//! # Why not libzmq
//!
//! As of libzmq 4.3.4 any remote client can terminate a process that listens with it. Filling the
//! receive queue with requests, then sending a PING and resetting the connection (about 8 KB in all),
//! triggers an assertion (`stream_engine_base.cpp`, `!_io_error`). An unlimited queue avoids the
//! assertion, but then nothing limits memory. Three more faults cannot be avoided by its users:
//!
//! - A REP socket loses the reply to a good client after a request without an empty frame from a peer
//!   that has gone.
//! - A client can take the routing identity of another, and with it the replies.
//! - Messages of many frames are kept whole.
//!
//! For clients libzmq is a fine choice: they choose whom to trust.
#![forbid(unsafe_code)]

mod bind;
pub mod codec;
pub mod connection;
mod connections;
mod eviction;
pub mod limits;
mod server;
mod service;
#[cfg(test)]
mod testing;
mod timers;

pub use bind::{BindError, listen};
pub use server::{RepServer, Waker};
pub use service::Service;

/// Compiles the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
