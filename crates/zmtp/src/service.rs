//! What a server asks of its user.

use crate::codec::event::ProtocolError;

/// Answers the requests of all clients of a [`RepServer`](crate::RepServer).
pub trait Service {
    /// Answers a request: replaces the earlier reply in `reply`.
    ///
    /// `request` is the last frame of the body, and `frames` the number of its frames; the server
    /// keeps only the last. Of a frame longer than
    /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES) the beginning is followed by zeros.
    ///
    /// Returns whether the request counts as activity. A connection without activity is the first
    /// to be closed when every place is taken, so requests that anybody can send for ever, such as
    /// malformed ones, should not count.
    fn answer(&mut self, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool;

    /// Answers a request with a frame over the limit: writes an error into `reply`, which holds an
    /// earlier reply.
    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>);

    /// Does other work of the server's thread. [`RepServer::run`](crate::RepServer::run) calls it
    /// whenever each client has had a turn, and after a [`Waker`](crate::Waker) was used.
    fn after_round(&mut self) {}
}
