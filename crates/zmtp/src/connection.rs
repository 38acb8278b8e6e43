//! A single connection with its input and output buffers.

use std::io::{self, ErrorKind, Read, Write};

use crate::codec::{Decoder, Event, Phase, ProtocolError, SIGNATURE, push_last_frame, push_pong};
use crate::limits::MAX_WAITING_REPLY_BYTES;
use crate::service::{ClientId, Service};

/// The maximum number of bytes in one read from a stream.
const READ_BYTES: usize = 4 * 1024;

/// The maximum number of decoded events that one call of [`Connection::turn`] handles.
const MAX_EVENTS: usize = 64;

/// A server connection over a non-blocking stream. The connection performs the handshake and
/// answers requests.
///
/// The methods of a connection never wait for the stream. When the stream becomes readable or
/// writable, call [`set_ready`](Self::set_ready) and then [`turn`](Self::turn).
#[derive(Debug)]
pub struct Connection<S> {
    client: ClientId,
    stream: S,
    decoder: Decoder,
    /// Received bytes, of which the first `consumed` have been decoded.
    input: Vec<u8>,
    consumed: usize,
    /// Bytes to send.
    output: Vec<u8>,
    /// True if the stream may have bytes to read.
    is_readable: bool,
    /// True if the stream may accept more bytes.
    is_writable: bool,
}

/// The result of [`Connection::turn`].
#[must_use]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Turn {
    /// True if `turn` must be called again, because the connection has more work to do.
    pub has_more: bool,
    /// True if [`Service::answer`] counted at least one request as activity.
    pub has_activity: bool,
}

/// The reason why a connection has ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DisconnectReason {
    /// The peer has closed the connection.
    #[error("closed by the peer")]
    Closed,
    /// The peer has violated the protocol.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// The stream has failed.
    #[error(transparent)]
    Stream(#[from] io::Error),
}

impl<S: Read + Write> Connection<S> {
    /// Creates a connection over a newly connected stream. The first turn sends the greeting.
    pub fn new(stream: S) -> Self {
        Self {
            client: ClientId::unique(),
            stream,
            decoder: Decoder::default(),
            input: Vec::new(),
            consumed: 0,
            output: SIGNATURE.to_vec(),
            is_readable: true,
            is_writable: true,
        }
    }

    /// Returns the identifier of the connection.
    pub const fn client(&self) -> ClientId {
        self.client
    }

    /// Returns the stream.
    pub fn into_stream(self) -> S {
        self.stream
    }

    /// Records that the stream may be readable or writable again.
    pub const fn set_ready(&mut self, is_readable: bool, is_writable: bool) {
        self.is_readable |= is_readable;
        self.is_writable |= is_writable;
    }

    /// Returns the phase of the connection.
    pub const fn phase(&self) -> Phase {
        self.decoder.phase()
    }

    /// Returns true if bytes are waiting to be sent.
    pub const fn has_output(&self) -> bool {
        !self.output.is_empty()
    }

    /// Takes a turn: receives bytes, answers at most `max_requests` requests, and sends the
    /// replies.
    ///
    /// # Errors
    /// Returns an error if the connection has ended. Before `turn` returns the error, it answers
    /// valid requests that have already arrived.
    pub fn turn(
        &mut self,
        max_requests: usize,
        service: &mut impl Service,
    ) -> Result<Turn, DisconnectReason> {
        let turn = self.process(max_requests, service);
        self.send().and(turn)
    }

    /// Receives bytes and answers requests. The caller must send the replies that remain in the
    /// output buffer.
    fn process(
        &mut self,
        mut requests_left: usize,
        service: &mut impl Service,
    ) -> Result<Turn, DisconnectReason> {
        let (mut turn, mut reply) = (Turn::default(), Vec::new());
        for _ in 0..MAX_EVENTS {
            if self.output.len() >= MAX_WAITING_REPLY_BYTES {
                self.send()?;
                if !self.is_writable {
                    return Ok(turn);
                }
            }
            let (consumed, event) = self.decoder.decode(&self.input[self.consumed..])?;
            match event {
                Event::Incomplete => {
                    // Replies are sent before more input is read.
                    self.send()?;
                    if !self.receive()? {
                        return Ok(turn);
                    }
                }
                Event::Ignored | Event::Ready => {}
                Event::Send(bytes) => self.output.extend_from_slice(bytes),
                Event::Ping { context } => push_pong(&mut self.output, context),
                Event::Request { last, frames } => {
                    turn.has_activity |= service.answer(self.client, &last, frames, &mut reply);
                    self.push_reply(&reply);
                    requests_left = requests_left.saturating_sub(1);
                }
                Event::Oversized(error) => {
                    service.refuse(&error, &mut reply);
                    self.push_reply(&reply);
                }
            }
            self.consumed += consumed;
            if requests_left == 0 {
                self.send()?;
                turn.has_more = self.consumed < self.input.len() || self.receive()?;
                return Ok(turn);
            }
        }
        turn.has_more = true;
        Ok(turn)
    }

    fn push_reply(&mut self, reply: &[u8]) {
        self.output.extend_from_slice(self.decoder.envelope());
        push_last_frame(&mut self.output, reply);
    }

    /// Reads available bytes from the stream. Returns false if the stream has no bytes to read.
    fn receive(&mut self) -> Result<bool, DisconnectReason> {
        if !self.is_readable {
            return Ok(false);
        }
        self.input.drain(..self.consumed);
        self.consumed = 0;
        let start = self.input.len();
        self.input.resize(start + READ_BYTES, 0);
        let result = self.stream.read(&mut self.input[start..]);
        self.input.truncate(start + result.as_ref().map_or(0, |&count| count));
        match result {
            Ok(0) => Err(DisconnectReason::Closed),
            Ok(_) => Ok(true),
            Err(error) if error.kind() == ErrorKind::Interrupted => Ok(true),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                self.is_readable = false;
                // An idle connection needs only a small buffer.
                self.input.shrink_to(READ_BYTES);
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Sends as much output as the stream accepts now.
    ///
    /// # Errors
    /// Returns an error if the connection has ended.
    pub fn send(&mut self) -> Result<(), DisconnectReason> {
        while self.is_writable && self.has_output() {
            match self.stream.write(&self.output) {
                Ok(0) => return Err(DisconnectReason::Closed),
                Ok(count) => drop(self.output.drain(..count)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => self.is_writable = false,
                Err(error) => return Err(error.into()),
            }
        }
        if !self.has_output() {
            self.output.shrink_to(READ_BYTES);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::handshake::{GREETING, READY};
    use crate::limits::MAX_REQUEST_BYTES;
    use crate::testing::{Echo, Wire};

    /// Returns a new connection and its stream, which supplies a handshake and then `incoming`.
    fn connect(incoming: &[u8]) -> (Connection<Wire>, Wire) {
        let wire = Wire::new(incoming);
        (Connection::new(wire.clone()), wire)
    }

    /// Calls `turn` until the connection has no more work to do.
    fn run_until_idle(connection: &mut Connection<Wire>) -> Result<(), DisconnectReason> {
        while connection.turn(8, &mut Echo::default())?.has_more {}
        Ok(())
    }

    fn replies(wire: &Wire) -> Vec<u8> {
        let handshake = [&GREETING[..], READY].concat();
        wire.sent().strip_prefix(&handshake[..]).unwrap().to_vec()
    }

    /// Returns encoded requests, each with a body of one byte. The encoded replies of [`Echo`] are
    /// identical to the requests.
    fn requests(range: std::ops::Range<u8>) -> Vec<u8> {
        range.flat_map(|n| [1, 0, 0, 1, n]).collect()
    }

    #[test]
    fn requests_are_answered_in_order_and_limited_in_each_turn() {
        let (mut connection, wire) = connect(&requests(0..100));
        let turn = connection.turn(8, &mut Echo::default()).unwrap();
        assert_eq!(turn, Turn { has_more: true, has_activity: true });
        assert_eq!(replies(&wire), requests(0..8));
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire), requests(0..100));
        assert_eq!(connection.phase(), Phase::Ready);
        assert!(!connection.has_output() && !connection.is_readable);
        wire.push(&requests(100..101));
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire), requests(0..100), "the stream is not reported as readable");
        connection.set_ready(true, false);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire), requests(0..101));
    }

    #[test]
    fn version_is_sent_as_soon_as_the_signature_arrives() {
        let wire = Wire::silent();
        let mut connection = Connection::new(wire.clone());
        for (byte, sent) in GREETING[..10].iter().zip([10, 10, 10, 10, 10, 10, 10, 10, 10, 11]) {
            wire.push(&[*byte]);
            connection.set_ready(true, true);
            run_until_idle(&mut connection).unwrap();
            assert_eq!(wire.sent(), GREETING[..sent]);
        }
    }

    #[test]
    fn turn_with_nothing_left_has_no_more() {
        let (mut connection, wire) = connect(&requests(0..8));
        let turn = connection.turn(8, &mut Echo::default()).unwrap();
        assert_eq!(turn, Turn { has_more: false, has_activity: true });
        assert_eq!(replies(&wire), requests(0..8));
        // Messages without an envelope get no reply, but count towards the event limit of a turn.
        wire.push(&b"\0\0".repeat(2 * MAX_EVENTS));
        connection.set_ready(true, false);
        let turn = connection.turn(8, &mut Echo::default()).unwrap();
        assert_eq!(turn, Turn { has_more: true, has_activity: false });
        assert!(connection.consumed <= 2 * MAX_EVENTS);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.input.is_empty());
    }

    #[test]
    fn interrupted_calls_are_repeated_and_other_errors_end_the_connection() {
        let (mut connection, wire) = connect(&requests(0..1));
        // The first interrupted call is a write. After the second request, it is a read.
        wire.fail([ErrorKind::Interrupted; 2]);
        run_until_idle(&mut connection).unwrap();
        wire.push(&requests(1..2));
        wire.fail([ErrorKind::Interrupted; 2]);
        connection.set_ready(true, false);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire), requests(0..2));
        wire.fail([ErrorKind::ConnectionReset]);
        connection.set_ready(true, false);
        let error = run_until_idle(&mut connection).unwrap_err();
        assert!(matches!(error, DisconnectReason::Stream(_)));
        wire.set_capacity(0);
        wire.push(&requests(2..3));
        connection.set_ready(true, true);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.has_output() && !connection.is_writable);
        connection.set_ready(false, true);
        wire.fail([ErrorKind::BrokenPipe, ErrorKind::WriteZero]);
        assert!(matches!(connection.send(), Err(DisconnectReason::Stream(_))));
        assert!(matches!(connection.send(), Err(DisconnectReason::Closed)));
        assert_eq!(DisconnectReason::Closed.to_string(), "closed by the peer");
        assert_eq!(connection.into_stream().sent(), wire.sent());
    }

    #[test]
    fn service_decides_what_counts_as_activity() {
        let (mut connection, wire) = connect(b"\x01\0\0\x04ping");
        let mut turn = || connection.turn(8, &mut Echo::default()).unwrap();
        assert_eq!(turn(), Turn::default());
        wire.push(b"\x01\0\0\x01a\x01\0\0\x04ping");
        connection.set_ready(true, true);
        let turn = connection.turn(8, &mut Echo::default()).unwrap();
        assert!(turn.has_activity && !turn.has_more);
    }

    #[test]
    fn peer_that_does_not_read_replies_is_not_read() {
        let request = [&b"\x01\0\x02\0\0\0\0\0\0\x04\0"[..], &[7; 1024]].concat();
        let (mut connection, wire) = connect(&request.repeat(1000));
        wire.set_capacity(200);
        run_until_idle(&mut connection).unwrap();
        assert!(wire.has_incoming() && !connection.is_writable);
        let waiting = connection.output.len();
        let limit = MAX_WAITING_REPLY_BYTES;
        assert!((limit..limit + 2 * request.len()).contains(&waiting), "{waiting}");
        // Nothing is lost: when the peer reads, it gets all replies.
        while !connection.is_writable {
            wire.set_capacity(5000);
            connection.set_ready(false, true);
            run_until_idle(&mut connection).unwrap();
        }
        assert_eq!(replies(&wire), request.repeat(1000));
    }

    #[test]
    fn memory_is_bounded_and_released() {
        let frame = [&b"\x01\0\x02\0\0\0\0\0\x01\0\0"[..], &vec![7; MAX_REQUEST_BYTES]].concat();
        let (mut connection, wire) = connect(&frame[..frame.len() - 1]);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.input.capacity() <= 4 * READ_BYTES, "a long frame is not kept");
        wire.push(&[7]);
        connection.set_ready(true, false);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire).len(), frame.len());
        assert!(connection.input.capacity() <= READ_BYTES);
        assert!(connection.output.capacity() <= READ_BYTES);
    }

    #[test]
    fn oversized_frame_is_refused_and_the_next_request_answered() {
        let frame =
            [&b"\x01\0\x02\0\0\0\0\0\x01\0\x01"[..], &vec![7; MAX_REQUEST_BYTES + 1]].concat();
        let (mut connection, wire) = connect(&frame);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(connection.phase(), Phase::Oversized);
        let error = b"error: expected a frame of at most 65536 bytes, found 65537";
        let refused = [b"\x01\0\0\x3b", &error[..]].concat();
        assert_eq!(replies(&wire), refused);
        wire.push(b"\x01\0\0\x01a");
        connection.set_ready(true, false);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(connection.phase(), Phase::Ready);
        assert_eq!(replies(&wire), [&refused[..], b"\x01\0\0\x01a"].concat());
    }

    #[test]
    fn requests_before_a_violation_are_answered() {
        let (mut connection, wire) = connect(b"\x01\0\0\x01a\xff");
        let error = run_until_idle(&mut connection).unwrap_err();
        assert!(matches!(error, DisconnectReason::Protocol(ProtocolError::Flags(0xff))));
        assert_eq!(replies(&wire), b"\x01\0\0\x01a");
    }

    #[test]
    fn requests_before_a_close_are_answered() {
        let (mut connection, wire) = connect(b"\x01\0\0\x01a");
        wire.close();
        assert!(matches!(run_until_idle(&mut connection), Err(DisconnectReason::Closed)));
        assert_eq!(replies(&wire), b"\x01\0\0\x01a");
    }
}
