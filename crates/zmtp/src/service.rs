//! The trait that users of the server implement.

use crate::codec::event::ProtocolError;

/// A service that answers the requests of all clients of a [`RepServer`](crate::RepServer).
pub trait Service {
    /// Answers a request by replacing the contents of `reply`, which may hold an earlier reply.
    ///
    /// `request` is the last frame of the request's body, and `frames` is the number of frames in
    /// the body; the server keeps only the last frame. If this frame is longer than
    /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES), zeros replace the bytes beyond that
    /// length.
    ///
    /// Returns true if the request counts as activity. When the server is full, it closes
    /// connections without activity first. Requests that achieve nothing, such as malformed
    /// requests, should therefore not count.
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool;

    /// Refuses a request that has an oversized frame: replaces the contents of `reply`, which may
    /// hold an earlier reply, with an error message.
    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>);

    /// Does additional work on the server's thread. [`RepServer::run`](crate::RepServer::run) calls
    /// this function after each round of turns, and after each use of a [`Waker`](crate::Waker).
    fn after_round(&mut self) {}
}
