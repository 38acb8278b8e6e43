//! A ZeroMQ REP server and REQ client without libzmq. The crate consists of a ZMTP 3.1 codec that
//! performs no I/O, a single-threaded server with limited memory use, and a blocking client.
//!
//! For a server, implement [`Service`] and pass your implementation to [`RepServer::run`], which
//! answers all REQ and DEALER clients. For a client, see [`ReqClient`].
//!
//! ```
//! use mmsim_zmtp::codec::ProtocolError;
//! use mmsim_zmtp::{Answer, ClientId, RepServer, Service, listen};
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
//!     ) -> Answer {
//!         *reply = [b"hello ", request].concat();
//!         Answer::Reply { is_activity: true }
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
//! - A reply may be due later ([`Answer::Later`]). The client that waits for it neither delays other
//!   clients nor misses the answers to its heartbeats.
//! - No input makes the server panic or stop. A client that violates the protocol is disconnected.
//! - Memory is bounded. There are at most [`max_connections`](ServerConfig::max_connections)
//!   connections, and with the default limits each uses less than 100 KiB if replies are short. The
//!   server stops reading from a client that does not read its replies.
//! - Clients take turns. When the server is full, inactive connections are closed to make room for
//!   new clients. The clients of one network cannot prevent clients of other networks from
//!   connecting.
//! - Before the server stops, it answers requests that clients have already sent, within the time
//!   limits of [`RepServer::run`].
//! - The client sends each request at most once, and never returns a late reply to an earlier
//!   request. No server can make it panic, wait longer than its caller allows, or store more than
//!   one reply of [`max_reply_bytes`](ClientConfig::max_reply_bytes).
//!
//! # Structure
//!
//! - [`codec`] decodes bytes into events and encodes requests and replies, without I/O.
//! - [`connection`] adds buffers to a non-blocking stream of any kind.
//! - The private module `connections` decides the order in which connections are served and when
//!   they are closed. Its functions take the current time as an argument, so unit tests need no
//!   clock.
//! - [`RepServer`] handles the sockets and reads the clock.
//! - [`ReqClient`] connects to a server, and the private module `req_connection` sends its requests
//!   and receives their replies over a non-blocking stream.
//!
//! # Scope
//!
//! The crate implements two socket types, REP and REQ, and one transport, TCP. The server accepts
//! REQ and DEALER clients that use ZMTP 3.0 or 3.1 (`ZeroMQ` 4), or ZMTP 2.0. The client accepts REP
//! and ROUTER servers that use ZMTP 3.0 or 3.1. Both support neither passwords (PLAIN) nor
//! encryption (CURVE). They send no heartbeats, but answer PING commands. The server does not
//! initiate connections, and the client connects to one server. Both are meant for short messages;
//! [`ServerConfig`] and [`ClientConfig`] set their limits.
//!
//! The README of this crate compares the server with other ZeroMQ servers under attack.
#![forbid(unsafe_code)]

mod client;
pub mod codec;
mod config;
pub mod connection;
mod connections;
mod endpoint;
mod eviction;
mod req_connection;
mod server;
mod service;

pub use client::ReqClient;
pub use config::{ClientConfig, ConfigError, ServerConfig};
pub use endpoint::{BindError, Endpoint, EndpointError, listen};
pub use eviction::network;
pub use server::{RepServer, Waker};
pub use service::{Answer, ClientId, Service};

/// Runs the examples in the README as doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
