//! Limits on the connections and requests of clients. The limits prevent a client from holding a
//! connection forever.

use std::time::Duration;

/// The maximum number of connections. A browser opens up to six connections to a server. The limit
/// keeps file descriptors available for mice.
pub const MAX_VIEWER_CONNECTIONS: usize = 64;

/// The maximum number of event streams. Each page has one event stream and needs further
/// connections for requests.
pub(crate) const MAX_EVENT_STREAMS: usize = MAX_VIEWER_CONNECTIONS / 2;

/// The maximum size of a request body other than a recording, in bytes.
pub(crate) const MAX_BODY_BYTES: usize = 64 * 1024;

/// The maximum size of an uploaded recording, in bytes. A file of this size can contain almost two
/// million uncompressed states of a 16x16 maze.
pub(crate) const MAX_RECORDING_BYTES: usize = 1 << 30;

/// The maximum number of simultaneous uploads. Further uploads wait.
pub(crate) const MAX_UPLOADS: usize = 2;

/// The maximum number of simultaneous jobs that wait for a mouse to stop. Further jobs wait.
pub(crate) const MAX_MOUSE_JOBS: usize = 16;

/// The maximum number of simultaneous jobs that may read all states of a run. Further jobs wait.
pub(crate) const MAX_RUN_JOBS: usize = 2;

/// The maximum number of simultaneous jobs that read or write recordings. Further jobs wait.
pub(crate) const MAX_RECORDING_JOBS: usize = 2;

/// The minimum rate of an upload or a download, in bytes per second. The rate is about half of 1
/// Mbit/s, the speed of a slow DSL line.
pub(crate) const MIN_RATE: u32 = 64 * 1024;

/// The limits of a [`Viewer`](crate::Viewer). Tests can lower these limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The maximum number of connections.
    pub connections: usize,
    /// The maximum time to receive the header of a request, counted from the end of the previous
    /// response.
    pub header_time: Duration,
    /// The maximum time to receive the body of a request.
    pub body_time: Duration,
    /// The time by which an upload or download may lag behind a transfer at 64 KiB/s.
    pub max_lag: Duration,
    /// The maximum time that a job, such as an upload or a picture, waits in a queue.
    pub queue_time: Duration,
    /// The maximum time that a request waits until a mouse has stopped.
    pub stop_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: MAX_VIEWER_CONNECTIONS,
            header_time: Duration::from_secs(30),
            body_time: Duration::from_secs(600),
            max_lag: Duration::from_secs(30),
            queue_time: Duration::from_secs(60),
            stop_time: Duration::from_secs(10),
        }
    }
}
