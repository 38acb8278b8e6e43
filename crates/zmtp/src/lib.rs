//! A ZeroMQ REP server without libzmq. The crate consists of a ZMTP 3.1 codec that performs no I/O,
//! and a single-threaded server with limited memory use.
//!
//! Implement [`Service`] and pass your implementation to [`RepServer::run`], which answers all REQ
//! and DEALER clients.
//!
//! ```
//! use mmsim_zmtp::codec::ProtocolError;
//! use mmsim_zmtp::{ClientId, RepServer, Service, listen};
//!
//! struct Greeter;
//!
//! impl Service for Greeter {
//!     fn answer(
//!         &mut self,
//!         _client: ClientId,
//!         request: &[u8],
//!         _frames: usize,
//!         reply: &mut Vec<u8>,
//!     ) -> bool {
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
//! - Every request gets exactly one reply, which begins with the envelope of the request. A client
//!   receives its replies in the order of its requests. A request with an oversized frame gets one
//!   error reply from [`Service::refuse`].
//! - No input makes the server panic or stop. A client that violates the protocol is disconnected.
//! - Memory is bounded. There are at most [`MAX_CONNECTIONS`](limits::MAX_CONNECTIONS) connections,
//!   and each uses less than 100 KiB if replies are short. The server stops reading from a client
//!   that does not read its replies.
//! - Clients take turns. When the server is full, inactive connections are closed to make room for
//!   new clients. The clients of one network cannot prevent clients of other networks from
//!   connecting.
//! - Before the server stops, it answers requests that clients have already sent, within the time
//!   limits of [`RepServer::run`].
//!
//! # Structure
//!
//! - [`codec`] decodes bytes into events and encodes replies, without I/O.
//! - [`connection`] adds buffers to a non-blocking stream of any kind.
//! - The private module `connections` decides the order in which connections are served and when
//!   they are closed. Its functions take the current time as an argument, so unit tests need no
//!   clock.
//! - [`RepServer`] handles the sockets and reads the clock.
//!
//! # Scope
//!
//! The crate implements one socket type, REP, and one transport, TCP. The server accepts REQ and
//! DEALER clients that use ZMTP 3.0 or 3.1 (`ZeroMQ` 4), or ZMTP 2.0. The server supports neither
//! passwords (PLAIN) nor encryption (CURVE). The server does not initiate connections or send
//! heartbeats, but it answers PING commands. The server is meant for short requests; all limits are
//! constants in [`limits`].
//!
//! # Why not libzmq
//!
//! Any remote client can crash a process that listens with libzmq 4.3.4. About 8 KB is enough: the
//! client fills the receive queue with requests, sends a PING, and resets the connection. An
//! assertion then fails (`!_io_error` in `stream_engine_base.cpp`). An unlimited receive queue
//! avoids the crash, but does not limit memory use. Besides this crash, libzmq has three faults
//! that its users cannot avoid:
//!
//! - If a client sends a request without the empty delimiter frame and disconnects, a libzmq REP
//!   socket loses the reply to another, well-behaved client.
//! - A client can take over the routing identity of another client and then receive the replies to
//!   that client.
//! - libzmq keeps all frames of a message in memory, no matter how many there are.
//!
//! libzmq is still a good choice for clients, because a client chooses which server to trust.
#![forbid(unsafe_code)]

mod bind;
mod buffered;
mod client;
pub mod codec;
pub mod connection;
mod connections;
mod endpoint;
mod eviction;
pub mod limits;
mod req_connection;
mod server;
mod service;
#[cfg(test)]
mod testing;
mod timers;

pub use bind::{BindError, listen};
pub use client::ReqClient;
pub use endpoint::{Endpoint, EndpointError};
pub use server::{RepServer, Waker};
pub use service::{ClientId, Service};

/// Runs the examples in the README as doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
