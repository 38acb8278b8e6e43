//! Limits for clients of the page. The limits prevent a client from holding a connection forever.

use std::time::Duration;

/// The maximum number of connections. A browser opens up to six connections. The other file
/// descriptors of the process are reserved for mice.
pub const MAX_VIEWER_CONNECTIONS: usize = 64;

/// The maximum number of event streams. Each page has one event stream; the other connections are
/// for requests.
pub(crate) const MAX_EVENT_STREAMS: usize = MAX_VIEWER_CONNECTIONS / 2;

/// The maximum size of a request body other than a recording, in bytes.
pub(crate) const MAX_BODY_BYTES: usize = 64 * 1024;

/// The maximum size of an uploaded recording, in bytes: two million uncompressed states.
pub(crate) const MAX_RECORDING_BYTES: usize = 1 << 30;

/// The maximum number of uploads at the same time. Further uploads wait.
pub(crate) const MAX_UPLOADS: usize = 2;

/// The maximum number of recordings that are read or written at the same time. Further jobs wait.
pub(crate) const MAX_RECORDING_JOBS: usize = 2;

/// The minimum rate of an upload or a download, in bytes per second, which is half the rate of a
/// slow DSL line.
pub(crate) const MIN_RATE: u32 = 64 * 1024;

/// The limits of a [`Viewer`](crate::Viewer) that tests can lower.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The maximum number of connections.
    pub connections: usize,
    /// The maximum time to receive the header of a request, counted from the end of the previous
    /// response.
    pub header_time: Duration,
    /// The maximum time to receive the body of a request.
    pub body_time: Duration,
    /// The maximum time that an upload or a download may lag behind a rate of 64 KiB/s.
    pub max_lag: Duration,
    /// The maximum time that an upload, a picture or a recording waits in a queue.
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
