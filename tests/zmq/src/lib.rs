//! The crate `zmq` for tests.
//!
//! The sources of libzmq do not compile with `MinGW`. There, tests that only need a client use sockets
//! over `mmsim-zmtp` that have the same names.
#![forbid(unsafe_code)]

#[cfg(not(all(windows, target_env = "gnu")))]
pub use libzmq::*;

#[cfg(all(windows, target_env = "gnu"))]
mod sockets;
#[cfg(all(windows, target_env = "gnu"))]
pub use sockets::*;
