//! A single connection with its input and output buffers.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::mem;

use crate::codec::{Decoder, Event, Phase, ProtocolError, SIGNATURE, push_last_frame, push_pong};
use crate::config::ServerConfig;
use crate::service::{Answer, ClientId, Service};

/// The maximum number of decoded events that one call of [`Connection::turn`] handles.
const MAX_EVENTS: usize = 64;

/// The maximum number of bytes of the requests that a connection holds while the reply to an earlier
/// request is due later. When this limit is reached, the connection does not read on.
const MAX_HELD_BYTES: usize = 32 * 1024;

/// The maximum number of bytes in one read from a stream.
pub(crate) const READ_BYTES: usize = 4 * 1024;

/// A server connection over a non-blocking stream. The connection performs the handshake and
/// answers requests.
///
/// The methods of a connection never wait for the stream. When the stream becomes readable or
/// writable, call [`set_ready`](Self::set_ready) and then [`turn`](Self::turn).
#[derive(Debug)]
pub struct Connection<S> {
    client: ClientId,
    decoder: Decoder,
    buffered: BufferedStream<S>,
    /// The envelope of the request whose reply is due later.
    waiting: Option<Vec<u8>>,
    /// The requests that have arrived since then.
    held: VecDeque<HeldRequest>,
}

/// A request that waits for the reply to an earlier request.
#[derive(Debug)]
struct HeldRequest {
    envelope: Vec<u8>,
    /// The last frame of the body and the number of frames, or the error of an oversized frame.
    body: Result<(Vec<u8>, usize), ProtocolError>,
}

impl HeldRequest {
    fn bytes(&self) -> usize {
        let frame = self.body.as_ref().map_or(0, |(last, _)| last.len());
        mem::size_of::<Self>() + self.envelope.len() + frame
    }
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
    pub fn new(stream: S, config: &ServerConfig) -> Self {
        Self {
            client: ClientId::unique(),
            decoder: Decoder::new(config),
            buffered: BufferedStream::new(stream, SIGNATURE),
            waiting: None,
            held: VecDeque::new(),
        }
    }

    /// Returns the identifier of the connection.
    pub const fn client(&self) -> ClientId {
        self.client
    }

    /// Returns the stream.
    pub fn into_stream(self) -> S {
        self.buffered.stream
    }

    /// Records that the stream may be readable or writable again.
    pub const fn set_ready(&mut self, is_readable: bool, is_writable: bool) {
        self.buffered.set_ready(is_readable, is_writable);
    }

    /// Records that the peer has closed the connection. The next turns read what it has sent before.
    pub const fn set_closed(&mut self) {
        self.buffered.is_closed = true;
        self.set_ready(true, true);
    }

    /// Returns the phase of the connection.
    pub const fn phase(&self) -> Phase {
        self.decoder.phase()
    }

    /// Returns true if bytes are waiting to be sent.
    pub const fn has_output(&self) -> bool {
        self.buffered.has_output()
    }

    /// Returns true if the reply to a request is due later.
    pub const fn is_waiting(&self) -> bool {
        self.waiting.is_some()
    }

    /// Adds a reply that was due later to the output. The caller must then call
    /// [`turn`](Self::turn). Does nothing if the connection is not waiting for a reply.
    pub fn reply(&mut self, reply: &[u8]) {
        if let Some(envelope) = self.waiting.take() {
            push_reply(&mut self.buffered.output, &envelope, reply);
        }
    }

    /// Takes a turn: receives bytes, answers at most `max_requests` requests, and sends the
    /// replies.
    ///
    /// # Errors
    /// Returns an error if the connection has ended. Before `turn` returns the error, it answers
    /// valid requests that have already arrived, except those behind a reply that is due later.
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
            if self.buffered.output.len() >= self.decoder.config().max_waiting_reply_bytes {
                self.send()?;
                if !self.buffered.is_writable {
                    return Ok(turn);
                }
            }
            if self.waiting.is_none()
                && let Some(HeldRequest { envelope, body }) = self.held.pop_front()
            {
                let answer = match &body {
                    Ok((last, frames)) => service.answer(self.client, last, *frames, &mut reply),
                    Err(error) => refuse(error, service, &mut reply),
                };
                turn.has_activity |= self.settle(answer, Some(&envelope), &reply);
                requests_left = requests_left.saturating_sub(1);
            } else if self.holds_enough() {
                let is_closed = self.buffered.is_closed;
                return if is_closed { Err(DisconnectReason::Closed) } else { Ok(turn) };
            } else {
                let unread = &self.buffered.input[self.buffered.consumed..];
                let (consumed, event) = self.decoder.decode(unread)?;
                match event {
                    Event::Incomplete => {
                        // Replies are sent before more input is read.
                        self.send()?;
                        if !self.buffered.receive()? {
                            return Ok(turn);
                        }
                    }
                    Event::Ignored | Event::Ready => {}
                    Event::Send(bytes) => self.buffered.output.extend_from_slice(bytes),
                    Event::Ping { context } => push_pong(&mut self.buffered.output, context),
                    Event::Message { last, frames } if self.waiting.is_some() => {
                        let body = Ok((last.into_owned(), frames));
                        self.hold(body);
                    }
                    Event::Message { last, frames } => {
                        let answer = service.answer(self.client, &last, frames, &mut reply);
                        turn.has_activity |= self.settle(answer, None, &reply);
                        requests_left = requests_left.saturating_sub(1);
                    }
                    Event::Oversized(error) if self.waiting.is_some() => self.hold(Err(error)),
                    Event::Oversized(error) => {
                        let answer = refuse(&error, service, &mut reply);
                        self.settle(answer, None, &reply);
                    }
                }
                self.buffered.consumed += consumed;
            }
            if requests_left == 0 {
                self.send()?;
                turn.has_more = self.waiting.is_none() && !self.held.is_empty()
                    || self.buffered.has_input()
                    || self.buffered.receive()?;
                return Ok(turn);
            }
        }
        turn.has_more = true;
        Ok(turn)
    }

    /// Adds a reply that is ready to the output, or waits for it. The envelope is that of the latest
    /// decoded request, unless `held` is another one. Returns true if the request counts as activity.
    fn settle(&mut self, answer: Answer, held: Option<&[u8]>, reply: &[u8]) -> bool {
        let envelope = held.unwrap_or_else(|| self.decoder.envelope());
        match answer {
            Answer::Reply { is_activity } => {
                push_reply(&mut self.buffered.output, envelope, reply);
                is_activity
            }
            Answer::Later => {
                self.waiting = Some(envelope.to_vec());
                true
            }
        }
    }

    /// Holds the latest decoded request until the reply to an earlier one has been added.
    fn hold(&mut self, body: Result<(Vec<u8>, usize), ProtocolError>) {
        self.held.push_back(HeldRequest { envelope: self.decoder.envelope().to_vec(), body });
    }

    /// Returns true if the connection must not read further requests now.
    fn holds_enough(&self) -> bool {
        self.waiting.is_some()
            && self.held.iter().map(HeldRequest::bytes).sum::<usize>() >= MAX_HELD_BYTES
    }

    /// Sends as much output as the stream accepts now.
    ///
    /// # Errors
    /// Returns an error if the connection has ended.
    pub fn send(&mut self) -> Result<(), DisconnectReason> {
        self.buffered.send()
    }
}

fn push_reply(output: &mut Vec<u8>, envelope: &[u8], reply: &[u8]) {
    output.extend_from_slice(envelope);
    push_last_frame(output, reply);
}

/// Lets the service refuse an oversized request.
fn refuse(error: &ProtocolError, service: &mut impl Service, reply: &mut Vec<u8>) -> Answer {
    service.refuse(error, reply);
    Answer::Reply { is_activity: false }
}

/// A non-blocking stream and its buffers.
#[derive(Debug)]
pub(crate) struct BufferedStream<S> {
    pub(crate) stream: S,
    /// Received bytes, of which the first `consumed` have been decoded.
    pub(crate) input: Vec<u8>,
    pub(crate) consumed: usize,
    /// Bytes to send.
    pub(crate) output: Vec<u8>,
    /// True if the stream may have bytes to read.
    pub(crate) is_readable: bool,
    /// True if the stream may accept more bytes.
    pub(crate) is_writable: bool,
    /// True if the peer has closed the connection, although it may still have bytes to read.
    pub(crate) is_closed: bool,
}

impl<S: Read + Write> BufferedStream<S> {
    /// Creates the buffers for a newly connected stream. The first bytes to send are `output`.
    pub(crate) fn new(stream: S, output: &[u8]) -> Self {
        Self {
            stream,
            input: Vec::new(),
            consumed: 0,
            output: output.to_vec(),
            is_readable: true,
            is_writable: true,
            is_closed: false,
        }
    }

    /// Records that the stream may be readable or writable again.
    pub(crate) const fn set_ready(&mut self, is_readable: bool, is_writable: bool) {
        self.is_readable |= is_readable;
        self.is_writable |= is_writable;
    }

    /// Returns true if received bytes have not been decoded yet.
    pub(crate) const fn has_input(&self) -> bool {
        self.consumed < self.input.len()
    }

    /// Returns true if bytes are waiting to be sent.
    pub(crate) const fn has_output(&self) -> bool {
        !self.output.is_empty()
    }

    /// Reads available bytes from the stream. Returns false if the stream has no bytes to read.
    pub(crate) fn receive(&mut self) -> Result<bool, DisconnectReason> {
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
    pub(crate) fn send(&mut self) -> Result<(), DisconnectReason> {
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
pub(crate) use tests::{Echo, Wire};

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;
    use std::time::Instant;

    use super::*;
    use crate::codec::handshake::{GREETING, READY, REQ_READY};

    const CONFIG: ServerConfig = ServerConfig::DEFAULT;

    /// An in-memory stream that never blocks. The test provides the input and checks the output.
    #[derive(Clone, Default)]
    pub(crate) struct Wire(Rc<RefCell<Ends>>);

    #[derive(Default)]
    struct Ends {
        incoming: VecDeque<u8>,
        outgoing: Vec<u8>,
        /// The number of bytes that can be written before a write returns [`ErrorKind::WouldBlock`].
        capacity: usize,
        is_closed: bool,
        /// The errors for the next reads and writes, one for each call.
        errors: VecDeque<ErrorKind>,
    }

    impl Wire {
        /// Creates a stream from which a handshake and then `incoming` can be read.
        pub(crate) fn new(incoming: &[u8]) -> Self {
            let wire = Self::silent();
            wire.push_handshake();
            wire.push(incoming);
            wire
        }

        /// Creates a stream from which no bytes can be read yet.
        pub(crate) fn silent() -> Self {
            let wire = Self::default();
            wire.set_capacity(usize::MAX);
            wire
        }

        pub(crate) fn push_handshake(&self) {
            self.push(&[&GREETING[..], REQ_READY].concat());
        }

        pub(crate) fn push(&self, incoming: &[u8]) {
            self.0.borrow_mut().incoming.extend(incoming);
        }

        pub(crate) fn close(&self) {
            self.0.borrow_mut().is_closed = true;
        }

        /// Makes the next reads and writes fail with these errors, one for each call.
        pub(crate) fn fail(&self, errors: impl IntoIterator<Item = ErrorKind>) {
            self.0.borrow_mut().errors.extend(errors);
        }

        pub(crate) fn set_capacity(&self, bytes: usize) {
            self.0.borrow_mut().capacity = bytes;
        }

        pub(crate) fn has_incoming(&self) -> bool {
            !self.0.borrow().incoming.is_empty()
        }

        /// Returns all bytes that have been written to the stream.
        pub(crate) fn sent(&self) -> Vec<u8> {
            self.0.borrow().outgoing.clone()
        }
    }

    impl Read for Wire {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let mut ends = self.0.borrow_mut();
            if let Some(error) = ends.errors.pop_front() {
                return Err(error.into());
            }
            if ends.incoming.is_empty() && !ends.is_closed {
                return Err(ErrorKind::WouldBlock.into());
            }
            ends.incoming.read(buffer)
        }
    }

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut ends = self.0.borrow_mut();
            match ends.errors.pop_front() {
                Some(ErrorKind::WriteZero) => return Ok(0),
                Some(error) => return Err(error.into()),
                None => {}
            }
            let count = bytes.len().min(ends.capacity);
            if count == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            ends.capacity -= count;
            ends.outgoing.extend_from_slice(&bytes[..count]);
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// A service that replies with the bytes of the request. The request `ping` does not count as
    /// activity. The reply to `later` is due when `due` becomes its client.
    #[derive(Default)]
    pub(crate) struct Echo {
        /// The number of calls to `after_round`.
        pub(crate) rounds: usize,
        pub(crate) due: Option<ClientId>,
    }

    impl Service for Echo {
        fn answer(
            &mut self,
            _: ClientId,
            request: &[u8],
            _frames: usize,
            reply: &mut Vec<u8>,
        ) -> Answer {
            reply.clear();
            reply.extend_from_slice(request);
            match request {
                b"later" => Answer::Later,
                _ => Answer::Reply { is_activity: request != b"ping" },
            }
        }

        fn due_reply(&mut self, _: Instant, reply: &mut Vec<u8>) -> Option<ClientId> {
            *reply = b"later".to_vec();
            self.due.take()
        }

        fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
            *reply = format!("error: {reason}").into();
        }

        fn after_round(&mut self) {
            self.rounds += 1;
        }
    }

    /// Returns a new connection and its stream, which supplies a handshake and then `incoming`.
    fn connect(incoming: &[u8]) -> (Connection<Wire>, Wire) {
        let wire = Wire::new(incoming);
        (Connection::new(wire.clone(), &CONFIG), wire)
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
        assert!(!connection.has_output() && !connection.buffered.is_readable);
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
        let mut connection = Connection::new(wire.clone(), &CONFIG);
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
        assert!(connection.buffered.consumed <= 2 * MAX_EVENTS);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.buffered.input.is_empty());
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
        assert!(connection.has_output() && !connection.buffered.is_writable);
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
        assert!(wire.has_incoming() && !connection.buffered.is_writable);
        let waiting = connection.buffered.output.len();
        let limit = CONFIG.max_waiting_reply_bytes;
        assert!((limit..limit + 2 * request.len()).contains(&waiting), "{waiting}");
        // Nothing is lost: when the peer reads, it gets all replies.
        while !connection.buffered.is_writable {
            wire.set_capacity(5000);
            connection.set_ready(false, true);
            run_until_idle(&mut connection).unwrap();
        }
        assert_eq!(replies(&wire), request.repeat(1000));
    }

    #[test]
    fn memory_is_bounded_and_released() {
        let frame =
            [&b"\x01\0\x02\0\0\0\0\0\x01\0\0"[..], &vec![7; CONFIG.max_request_bytes]].concat();
        let (mut connection, wire) = connect(&frame[..frame.len() - 1]);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.buffered.input.capacity() <= 4 * READ_BYTES, "a long frame is not kept");
        wire.push(&[7]);
        connection.set_ready(true, false);
        run_until_idle(&mut connection).unwrap();
        assert_eq!(replies(&wire).len(), frame.len());
        assert!(connection.buffered.input.capacity() <= READ_BYTES);
        assert!(connection.buffered.output.capacity() <= READ_BYTES);
    }

    #[test]
    fn oversized_frame_is_refused_and_the_next_request_answered() {
        let frame =
            [&b"\x01\0\x02\0\0\0\0\0\x01\0\x01"[..], &vec![7; CONFIG.max_request_bytes + 1]]
                .concat();
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

    /// A request for which [`Echo`] has no reply yet, with an envelope of two frames.
    const LATER: &[u8] = b"\x01\x02id\x01\0\0\x05later";

    #[test]
    fn requests_wait_for_a_reply_that_is_due_later_but_pings_do_not() {
        let oversized = [b"\x01\0\x02".as_slice(), &70_000_u64.to_be_bytes()].concat();
        let (heartbeat, answer) = (b"\x04\x08\x04PING\0\x01c", b"\x04\x06\x04PONGc");
        let held = [&requests(0..3), LATER, &requests(3..5)].concat();
        let (mut connection, wire) =
            connect(&[LATER, heartbeat, &held, heartbeat, &oversized].concat());
        wire.push(&vec![0; 70_000]);
        run_until_idle(&mut connection).unwrap();
        assert!(connection.is_waiting() && !wire.has_incoming());
        assert_eq!(replies(&wire), answer.repeat(2));
        connection.reply(b"first");
        run_until_idle(&mut connection).unwrap();
        let first = [b"\x01\x02id\x01\0\0\x05first", &requests(0..3)[..]].concat();
        assert_eq!(replies(&wire), [&answer.repeat(2), &first[..]].concat());
        assert!(connection.is_waiting(), "the second request with a later reply");
        connection.reply(b"second");
        connection.reply(b"ignored");
        run_until_idle(&mut connection).unwrap();
        let second = [b"\x01\x02id\x01\0\0\x06second", &requests(3..5)[..]].concat();
        let (found, expected) = (replies(&wire), [&answer.repeat(2), &first[..], &second].concat());
        let error = found.strip_prefix(&expected[..]).unwrap();
        assert!(error.starts_with(b"\x01\0\0") && error[4..].starts_with(b"error: "));
        assert!(!connection.is_waiting());
    }

    #[test]
    fn held_requests_are_bounded_and_all_answered() {
        let many = requests(0..200).repeat(100);
        let (mut connection, wire) = connect(&[LATER, &many].concat());
        run_until_idle(&mut connection).unwrap();
        assert!(wire.has_incoming(), "the connection must not read on");
        assert!((100..1000).contains(&connection.held.len()), "{}", connection.held.len());
        let (mut closed, _) = connect(&[LATER, &many].concat());
        closed.set_closed();
        assert!(matches!(run_until_idle(&mut closed), Err(DisconnectReason::Closed)));
        connection.reply(b"later");
        run_until_idle(&mut connection).unwrap();
        assert!(replies(&wire) == [LATER, &many].concat());
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
