//! The [`Service`] trait, which users of the crate implement.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::codec::event::ProtocolError;

/// Identifies a connection among all connections of all servers in this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClientId(u64);

impl ClientId {
    /// Returns an identifier that no earlier call has returned.
    pub fn unique() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// A service that answers the requests of all clients of a [`RepServer`](crate::RepServer).
pub trait Service {
    /// Answers a request. The implementation must overwrite `reply`, which may hold an earlier
    /// reply.
    ///
    /// `client` is the connection, `request` is the last frame of the body, and `frames` is the
    /// number of frames in the body. The server discards all body frames except the last. If the
    /// last frame is longer than [`max_kept_bytes`](crate::ServerConfig::max_kept_bytes), the bytes
    /// beyond that length are replaced with zeros.
    ///
    /// Returns true if the request counts as activity. For requests without effect, such as
    /// malformed requests, implementations should return false: when a new client connects to a
    /// full server, the server first closes connections without activity.
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> bool;

    /// Refuses a request with an oversized frame. The implementation must overwrite `reply` with an
    /// error message; `reply` may hold an earlier reply.
    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>);

    /// Runs when the connection of a client has ended.
    fn disconnected(&mut self, _client: ClientId) {}

    /// Runs on the server's thread each time [`RepServer::run`](crate::RepServer::run) has handled
    /// events, and each time a [`Waker`](crate::Waker) has woken the server.
    fn after_round(&mut self) {}
}
