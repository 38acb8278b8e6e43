//! Transfers from and to clients, which keep a minimum rate: a client that stops sending or reading
//! would hold its connection for ever.

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

use crate::api_error::ApiError;
use crate::limits::{Limits, MAX_BODY_BYTES, MIN_RATE};
use crate::state::AppState;

/// The progress of a transfer, measured against [`MIN_RATE`].
struct Pace {
    max_lag: Duration,
    /// When the transfer fails unless more bytes have come by then.
    deadline: Instant,
    paused: Option<Instant>,
}

impl Pace {
    fn new(Limits { max_lag, .. }: Limits) -> Self {
        Self { max_lag, deadline: Instant::now() + max_lag, paused: None }
    }

    /// Moves the deadline by the time that these bytes may take. Those that come sooner earn no
    /// longer lag later.
    fn advance(&mut self, bytes: usize) {
        let earned = Duration::from_secs(bytes as u64) / MIN_RATE;
        self.deadline = (self.deadline + earned).min(Instant::now() + self.max_lag);
    }

    /// Stops the clock while there is nothing to transfer.
    fn pause(&mut self) {
        self.paused.get_or_insert_with(Instant::now);
    }

    fn resume(&mut self) {
        self.deadline += self.paused.take().map_or(Duration::ZERO, |since| since.elapsed());
    }
}

/// Receives a body and hands over each piece of it.
pub(crate) async fn receive(
    body: Body,
    max_bytes: usize,
    limits: Limits,
    mut take: impl FnMut(Bytes) -> io::Result<()>,
) -> Result<(), ApiError> {
    let (mut pieces, mut pace, mut length) = (body.into_data_stream(), Pace::new(limits), 0);
    let (last, seconds) = (Instant::now() + limits.body_time, limits.body_time.as_secs());
    let too_slow = |_| {
        let text = format!(
            "the request arrived too slowly: expected at least {MIN_RATE} bytes per second, and all \
             of it within {seconds} s"
        );
        ApiError::new(StatusCode::REQUEST_TIMEOUT, text)
    };
    while let Some(piece) =
        timeout_at(pace.deadline.min(last), pieces.next()).await.map_err(too_slow)?
    {
        let piece = piece.map_err(ApiError::bad)?;
        pace.advance(piece.len());
        length += piece.len();
        if length > max_bytes {
            let text = format!("the request is too long: expected at most {max_bytes} bytes");
            return Err(ApiError::new(StatusCode::PAYLOAD_TOO_LARGE, text));
        }
        take(piece).map_err(ApiError::failed)?;
    }
    Ok(())
}

/// Receives the body of a request before it is served.
pub(crate) async fn receive_first(
    State(state): State<Arc<AppState>>,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let (parts, body) = request.into_parts();
    let mut whole = Vec::new();
    receive(body, MAX_BODY_BYTES, state.limits, |piece| {
        whole.extend_from_slice(&piece);
        Ok(())
    })
    .await?;
    Ok(next.run(Request::from_parts(parts, whole.into())).await)
}

/// A connection that ends once its client reads too slowly.
pub(crate) struct Connection {
    stream: TcpStream,
    sent: Pace,
    /// Wakes at the deadline while the system takes no more bytes.
    timer: Pin<Box<Sleep>>,
}

impl Connection {
    pub(crate) fn new(stream: TcpStream, limits: Limits) -> Self {
        let sent = Pace::new(limits);
        let timer = Box::pin(sleep_until(sent.deadline));
        Self { stream, sent, timer }
    }

    /// Writes, and fails if the system takes too few bytes for too long.
    fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        write: impl FnOnce(Pin<&mut TcpStream>, &mut Context<'_>) -> Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        self.sent.resume();
        let written = write(Pin::new(&mut self.stream), cx);
        match written {
            Poll::Ready(Ok(bytes)) => self.sent.advance(bytes),
            Poll::Ready(Err(_)) => {}
            Poll::Pending => {
                self.timer.as_mut().reset(self.sent.deadline);
                ready!(self.timer.as_mut().poll(cx));
                let text = format!("the client reads less than {MIN_RATE} bytes per second");
                return Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, text)));
            }
        }
        written
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(cx, buffer)
    }
}

impl AsyncWrite for Connection {
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
        pieces: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.poll_send(cx, |stream, cx| stream.poll_write_vectored(cx, pieces))
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    /// Called once the system has taken all there was to send.
    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.sent.pause();
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_move_the_deadline_and_a_burst_does_not_allow_a_longer_lag() {
        let (second, limits) = (Duration::from_secs(1), Limits::default());
        let mut pace = Pace::new(limits);
        pace.deadline -= 5 * second;
        let before = pace.deadline;
        pace.advance(2 * MIN_RATE as usize);
        assert_eq!(pace.deadline - before, 2 * second);
        pace.advance(1000 * MIN_RATE as usize);
        assert!(pace.deadline <= Instant::now() + limits.max_lag);
        assert!(pace.deadline > before + 2 * second);
    }

    #[test]
    fn time_without_anything_to_transfer_does_not_count() {
        let (second, mut pace) = (Duration::from_secs(1), Pace::new(Limits::default()));
        let before = pace.deadline;
        pace.paused = Instant::now().checked_sub(second);
        pace.pause();
        pace.resume();
        assert!(pace.deadline >= before + second);
        let after = pace.deadline;
        pace.resume();
        assert_eq!(pace.deadline, after);
    }
}
