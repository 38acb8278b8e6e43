//! Limits on the connections and requests of clients, and the minimum transfer rate. They prevent a
//! client that stops sending or reading from holding a connection forever.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::Response;
use futures_util::StreamExt;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Instant, Sleep, sleep_until, timeout_at};

use crate::http::jobs::{ApiError, ApiResult};
use crate::http::shares::Connection;

/// The maximum number of connections. A browser opens up to six connections to a server. The limit
/// keeps file descriptors available for mice.
pub const MAX_VIEWER_CONNECTIONS: usize = 64;

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
    /// The maximum number of event streams. Each browser has one, and needs further connections for
    /// requests.
    pub streams: usize,
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
            streams: MAX_VIEWER_CONNECTIONS / 2,
            header_time: Duration::from_secs(30),
            body_time: Duration::from_secs(600),
            max_lag: Duration::from_secs(30),
            queue_time: Duration::from_secs(60),
            stop_time: Duration::from_secs(10),
        }
    }
}

/// The deadline of a transfer that must not be slower than [`MIN_RATE`].
struct RateDeadline {
    max_lag: Duration,
    /// The time at which the transfer fails if no more bytes have been transferred by then.
    expires_at: Instant,
    paused_at: Option<Instant>,
}

impl RateDeadline {
    fn new(Limits { max_lag, .. }: Limits, now: Instant) -> Self {
        Self { max_lag, expires_at: now + max_lag, paused_at: None }
    }

    /// Extends the deadline by the time that `bytes` bytes take at [`MIN_RATE`]. The new deadline
    /// is at most `max_lag` from now.
    fn extend(&mut self, bytes: usize, now: Instant) {
        let allowed = Duration::from_secs(bytes as u64) / MIN_RATE;
        self.expires_at = (self.expires_at + allowed).min(now + self.max_lag);
    }

    /// Pauses the deadline while there is nothing to transfer.
    fn pause(&mut self, now: Instant) {
        self.paused_at.get_or_insert(now);
    }

    fn resume(&mut self, now: Instant) {
        self.expires_at += self.paused_at.take().map_or(Duration::ZERO, |since| now - since);
    }
}

/// Receives a request body and passes each chunk to `write`.
pub(crate) async fn receive_body(
    body: Body,
    max_bytes: usize,
    limits: Limits,
    mut write: impl FnMut(Bytes) -> io::Result<()>,
) -> ApiResult<()> {
    let (mut chunks, mut length) = (body.into_data_stream(), 0);
    let start = Instant::now();
    let mut deadline = RateDeadline::new(limits, start);
    let (latest, seconds) = (start + limits.body_time, limits.body_time.as_secs());
    let too_slow = |_| {
        let text = format!(
            "the request body arrived too slowly (minimum {MIN_RATE} bytes per second, maximum \
             {seconds} s)"
        );
        ApiError::new(StatusCode::REQUEST_TIMEOUT, text)
    };
    while let Some(chunk) =
        timeout_at(deadline.expires_at.min(latest), chunks.next()).await.map_err(too_slow)?
    {
        let chunk = chunk.map_err(ApiError::bad_request)?;
        deadline.extend(chunk.len(), Instant::now());
        length += chunk.len();
        if length > max_bytes {
            let text = format!("the request body is too large (maximum {max_bytes} bytes)");
            return Err(ApiError::new(StatusCode::PAYLOAD_TOO_LARGE, text));
        }
        write(chunk).map_err(ApiError::internal)?;
    }
    Ok(())
}

/// Receives the whole request body before the handler runs.
pub(crate) async fn buffer_body(
    State(limits): State<Limits>,
    request: Request,
    next: Next,
) -> ApiResult<Response> {
    let (parts, body) = request.into_parts();
    let mut whole = Vec::new();
    receive_body(body, MAX_BODY_BYTES, limits, |chunk| {
        whole.extend_from_slice(&chunk);
        Ok(())
    })
    .await?;
    Ok(next.run(Request::from_parts(parts, whole.into())).await)
}

/// A connection that fails if its client reads too slowly.
pub(crate) struct TimedConnection {
    stream: TcpStream,
    connection: Arc<Connection>,
    send_deadline: RateDeadline,
    /// The timer that wakes the task at the deadline while the send buffer is full.
    timer: Pin<Box<Sleep>>,
}

impl TimedConnection {
    pub(crate) fn new(stream: TcpStream, connection: Arc<Connection>, limits: Limits) -> Self {
        let send_deadline = RateDeadline::new(limits, Instant::now());
        let timer = Box::pin(sleep_until(send_deadline.expires_at));
        Self { stream, connection, send_deadline, timer }
    }

    /// Writes to the stream, or returns an error after the deadline.
    fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        write: impl FnOnce(Pin<&mut TcpStream>, &mut Context<'_>) -> Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        let now = Instant::now();
        self.send_deadline.resume(now);
        let written = write(Pin::new(&mut self.stream), cx);
        match written {
            Poll::Ready(Ok(bytes)) => {
                self.connection.record_transfer();
                self.send_deadline.extend(bytes, now);
            }
            Poll::Ready(Err(_)) => {}
            Poll::Pending => {
                self.timer.as_mut().reset(self.send_deadline.expires_at);
                ready!(self.timer.as_mut().poll(cx));
                let text = format!("the client reads less than {MIN_RATE} bytes per second");
                return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, text)));
            }
        }
        written
    }
}

impl AsyncRead for TimedConnection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let read = Pin::new(&mut self.stream).poll_read(cx, buffer);
        if read.is_ready() {
            self.connection.record_transfer();
        }
        read
    }
}

impl AsyncWrite for TimedConnection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.poll_send(cx, |stream, cx| stream.poll_write(cx, bytes))
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffers: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.poll_send(cx, |stream, cx| stream.poll_write_vectored(cx, buffers))
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    /// Pauses the deadline until the next write, since all data has been written.
    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.send_deadline.pause(Instant::now());
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn bytes_extend_the_deadline_up_to_the_maximum_lag() {
        let (start, max_lag) = (Instant::now(), 10 * SECOND);
        let mut deadline = RateDeadline::new(Limits { max_lag, ..Limits::default() }, start);
        assert_eq!(deadline.expires_at, start + max_lag);
        deadline.extend(2 * MIN_RATE as usize, start + 5 * SECOND);
        assert_eq!(deadline.expires_at, start + 12 * SECOND);
        deadline.extend(1000 * MIN_RATE as usize, start + 6 * SECOND);
        assert_eq!(deadline.expires_at, start + 16 * SECOND);
    }

    #[test]
    fn pauses_extend_the_deadline() {
        let (start, max_lag) = (Instant::now(), 10 * SECOND);
        let mut deadline = RateDeadline::new(Limits { max_lag, ..Limits::default() }, start);
        deadline.pause(start + SECOND);
        deadline.pause(start + 2 * SECOND);
        deadline.resume(start + 4 * SECOND);
        deadline.resume(start + 5 * SECOND);
        assert_eq!(deadline.expires_at, start + 13 * SECOND);
    }
}
