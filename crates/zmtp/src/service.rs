//! The [`Service`] trait, which users of the crate implement.

use crate::codec::event::ProtocolError;

/// A service that answers the requests of all clients of a [`RepServer`](crate::RepServer).
pub trait Service {
    /// Answers a request. The implementation must overwrite `reply`, which may hold an earlier
    /// reply.
    ///
    /// `request` is the last frame of the body, and `frames` is the number of frames in the body.
    /// The server discards all body frames except the last. If the last frame is longer than
    /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES), the bytes beyond that length are replaced
    /// with zeros.
    ///
    /// Returns true if the request counts as activity. For requests without effect, such as
    /// malformed requests, implementations should return false: when a new client connects to a
    /// full server, the server first closes connections without activity.
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool;

    /// Refuses a request with an oversized frame. The implementation must overwrite `reply` with an
    /// error message; `reply` may hold an earlier reply.
    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>);

    /// Runs on the server's thread each time [`RepServer::run`](crate::RepServer::run) has handled
    /// events, and each time a [`Waker`](crate::Waker) has woken the server.
    fn after_round(&mut self) {}
}
