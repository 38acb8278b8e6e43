//! Limits of what a client of the page can use. None of them holds a connection for ever.

use std::time::Duration;

/// The maximum number of connections. A browser opens up to six; the files that a process may open
/// are there for mice first.
pub const MAX_VIEWER_CONNECTIONS: usize = 64;

/// The maximum number of pages that listen for events: connections have to be left for what they
/// ask.
pub(crate) const MAX_LISTENERS: usize = MAX_VIEWER_CONNECTIONS / 2;

/// The maximum body of a request that is not a recording, in bytes.
pub(crate) const MAX_BODY_BYTES: usize = 64 * 1024;

/// The maximum size of an uploaded recording, in bytes: two million states, not packed.
pub(crate) const MAX_RECORDING_BYTES: usize = 1 << 30;

/// The maximum number of uploads at the same time; further ones wait.
pub(crate) const MAX_UPLOADS: usize = 2;

/// The maximum number of recordings that are read or written at the same time; further ones wait.
pub(crate) const MAX_RECORDING_JOBS: usize = 2;

/// The minimum rate of an upload or a download, in bytes per second: half of a slow DSL line.
pub(crate) const MIN_RATE: u32 = 64 * 1024;

/// The limits of a [`Viewer`](crate::Viewer) that a test reaches sooner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The maximum number of connections.
    pub connections: usize,
    /// The maximum time until the header of a request is complete, counted from the end of the
    /// previous reply.
    pub header_time: Duration,
    /// The maximum time until the body of a request is complete.
    pub body_time: Duration,
    /// The maximum time by which an upload or a download may lag behind 64 KiB/s.
    pub max_lag: Duration,
    /// The maximum time that an upload, a picture or a recording waits for its turn.
    pub queue_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: MAX_VIEWER_CONNECTIONS,
            header_time: Duration::from_secs(30),
            body_time: Duration::from_secs(600),
            max_lag: Duration::from_secs(30),
            queue_time: Duration::from_secs(60),
        }
    }
}
