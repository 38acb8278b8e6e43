//! The [`Service`] trait, which users of the crate implement.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

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

impl From<ClientId> for u64 {
    fn from(client: ClientId) -> Self {
        client.0
    }
}

/// What a service does with a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The reply is ready.
    Reply {
        /// True if the request counts as activity. For requests without effect, such as malformed
        /// requests, this should be false: when a new client connects to a full server, the server
        /// first closes connections without activity.
        is_activity: bool,
    },
    /// The reply is due later, and [`Service::due_reply`] will return it. The request counts as
    /// activity, and the server does not close the connection to make room for another client. Until
    /// then, the server answers PING commands of the client and all requests of other clients, but
    /// holds further requests of this client. It reads up to 32 KiB of them.
    Later,
}

/// A service that answers the requests of all clients of a [`RepServer`](crate::RepServer).
pub trait Service {
    /// Answers a request. The implementation must overwrite `reply`, which may hold an earlier
    /// reply, unless the reply is due later.
    ///
    /// `client` is the connection, `request` is the last frame of the body, and `frames` is the
    /// number of frames in the body. The server discards all body frames except the last. If the
    /// last frame is longer than [`max_kept_bytes`](crate::ServerConfig::max_kept_bytes), the bytes
    /// beyond that length are replaced with zeros.
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer;

    /// Refuses a request with an oversized frame. The implementation must overwrite `reply` with an
    /// error message; `reply` may hold an earlier reply.
    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>);

    /// Returns a client whose reply was due later and is due now, and writes its reply into `reply`.
    /// The server calls this function after each [`Waker::wake`](crate::Waker::wake), at the time
    /// that [`next_due`](Self::next_due) returns, and each time it has handled events.
    fn due_reply(&mut self, _now: Instant, _reply: &mut Vec<u8>) -> Option<ClientId> {
        None
    }

    /// Returns the time at which the server must call [`due_reply`](Self::due_reply) again, or `None`
    /// if a [`Waker`](crate::Waker) will announce the next reply. The time must lie after the latest
    /// call of `due_reply`.
    fn next_due(&self) -> Option<Instant> {
        None
    }

    /// Runs when the connection of a client has ended. A reply that was due later is dropped.
    fn disconnected(&mut self, _client: ClientId) {}

    /// Runs on the server's thread each time [`RepServer::run`](crate::RepServer::run) has handled
    /// events, and each time a [`Waker`](crate::Waker) has woken the server.
    fn after_round(&mut self) {}
}
