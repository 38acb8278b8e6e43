//! A connection of the client, with its input and output buffers.

use std::io::{Read, Write};

use crate::codec::{Event, ReplyDecoder, SIGNATURE, push_pong};
use crate::config::ClientConfig;
use crate::connection::{BufferedStream, DisconnectReason};

/// The maximum number of reads in one call of [`ReqConnection::turn`].
const MAX_READS: usize = 16;

/// A client connection over a non-blocking stream. The connection performs the handshake, sends
/// requests and receives replies.
///
/// The methods of a connection never wait for the stream. When the stream becomes readable or
/// writable, call [`set_ready`](Self::set_ready) and then [`turn`](Self::turn).
pub(crate) struct ReqConnection<S> {
    decoder: ReplyDecoder,
    buffered: BufferedStream<S>,
}

impl<S: Read + Write> ReqConnection<S> {
    /// Creates a connection over a newly connected stream. The first turn sends the greeting.
    pub(crate) fn new(stream: S, config: &ClientConfig) -> Self {
        let buffered = BufferedStream::new(stream, SIGNATURE);
        Self { decoder: ReplyDecoder::new(config), buffered }
    }

    /// Records that the stream may be readable or writable again.
    pub(crate) const fn set_ready(&mut self, is_readable: bool, is_writable: bool) {
        self.buffered.set_ready(is_readable, is_writable);
    }

    /// Returns true if `turn` can continue without waiting for the stream.
    pub(crate) const fn has_more(&self) -> bool {
        self.buffered.is_readable
    }

    /// Returns true if the handshake is complete.
    pub(crate) fn is_ready(&self) -> bool {
        self.decoder.is_ready()
    }

    /// Returns true if a request may be sent: the server has neither closed the connection nor sent
    /// anything to which no request belongs.
    pub(crate) fn is_idle(&mut self) -> bool {
        self.buffered.is_readable = true;
        let turn = self.turn(&mut Vec::new());
        matches!(turn, Ok(None)) && self.decoder.is_idle() && !self.buffered.has_input()
    }

    /// Queues an encoded request. The next turn sends it.
    pub(crate) fn push(&mut self, request: &[u8]) {
        self.buffered.output.extend_from_slice(request);
    }

    /// Sends output, receives bytes, and handles them up to the end of the next reply. Replaces the
    /// contents of `reply` with the last frame of the reply, and returns the number of its frames.
    /// Returns `None` if the reply is incomplete.
    ///
    /// # Errors
    /// Returns an error if the connection has ended.
    pub(crate) fn turn(&mut self, reply: &mut Vec<u8>) -> Result<Option<usize>, DisconnectReason> {
        for _ in 0..MAX_READS {
            let is_complete = self.handle_input(reply)?;
            self.buffered.send()?;
            if is_complete.is_some() || !self.buffered.receive()? {
                return Ok(is_complete);
            }
        }
        Ok(None)
    }

    /// Handles the received bytes up to the end of the next reply.
    fn handle_input(&mut self, reply: &mut Vec<u8>) -> Result<Option<usize>, DisconnectReason> {
        loop {
            let unread = &self.buffered.input[self.buffered.consumed..];
            let (consumed, event) = self.decoder.decode(unread)?;
            let mut complete = None;
            match event {
                Event::Incomplete => return Ok(None),
                Event::Send(bytes) => self.buffered.output.extend_from_slice(bytes),
                // A server that does not read gets no further PONG, so the output stays small.
                Event::Ping { context } if self.buffered.output.is_empty() => {
                    push_pong(&mut self.buffered.output, context);
                }
                Event::Message { last, frames } => {
                    reply.clear();
                    reply.extend_from_slice(&last);
                    complete = Some(frames);
                }
                Event::Ping { .. } | Event::Ignored | Event::Ready | Event::Oversized(_) => {}
            }
            self.buffered.consumed += consumed;
            if complete.is_some() {
                return Ok(complete);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use super::*;
    use crate::codec::{GREETING, READY, REQ_READY};
    use crate::connection::{READ_BYTES, Wire};

    const MAX_REPLY_BYTES: usize = 200_000;
    const CONFIG: ClientConfig =
        ClientConfig { max_reply_bytes: MAX_REPLY_BYTES, ..ClientConfig::DEFAULT };

    /// Returns a connection after its handshake, and its stream.
    fn connect() -> (ReqConnection<Wire>, Wire) {
        let wire = Wire::silent();
        wire.push(&[&GREETING[..], READY].concat());
        let mut connection = ReqConnection::new(wire.clone(), &CONFIG);
        assert!(!connection.is_ready());
        assert_eq!(turn(&mut connection).unwrap(), None);
        assert!(connection.is_ready() && connection.is_idle());
        assert_eq!(wire.sent(), [&GREETING[..], REQ_READY].concat());
        (connection, wire)
    }

    /// Marks the stream as ready, and returns the reply and the number of its frames.
    fn turn(
        connection: &mut ReqConnection<Wire>,
    ) -> Result<Option<(Vec<u8>, usize)>, DisconnectReason> {
        let mut reply = b"old".to_vec();
        connection.set_ready(true, true);
        let frames = connection.turn(&mut reply)?;
        assert!(frames.is_some() || !connection.has_more());
        Ok(frames.map(|frames| (reply, frames)))
    }

    /// Returns the bytes that were sent after the handshake.
    fn sent(wire: &Wire) -> Vec<u8> {
        wire.sent().split_off(GREETING.len() + REQ_READY.len())
    }

    #[test]
    fn request_gets_its_reply_in_single_bytes() {
        let (mut connection, wire) = connect();
        connection.push(b"\x01\0\0\x04ping");
        assert_eq!(turn(&mut connection).unwrap(), None);
        assert_eq!(sent(&wire), b"\x01\0\0\x04ping");
        for byte in b"\x01\0\x01\x01a\0\x02o" {
            wire.push(&[*byte]);
            assert_eq!(turn(&mut connection).unwrap(), None);
            assert!(!connection.is_idle());
        }
        wire.push(b"k");
        assert_eq!(turn(&mut connection).unwrap(), Some((b"ok".to_vec(), 2)));
        assert!(connection.is_idle());
    }

    #[test]
    fn connection_with_unexpected_input_is_not_idle() {
        for input in [&b"\x01"[..], b"\x01\0", b"\x01\0\0\x02ok", b"\0\x02ok"] {
            let (mut connection, wire) = connect();
            wire.push(input);
            assert!(!connection.is_idle(), "{input:?}");
        }
        let (mut connection, wire) = connect();
        wire.close();
        assert!(!connection.is_idle());
        assert!(matches!(turn(&mut connection), Err(DisconnectReason::Closed)));
        let (mut connection, wire) = connect();
        wire.fail([ErrorKind::ConnectionReset]);
        assert!(!connection.is_idle());
        // Interrupted calls are repeated.
        let (mut connection, wire) = connect();
        wire.fail([ErrorKind::Interrupted]);
        assert!(connection.is_idle());
    }

    #[test]
    fn pings_are_answered_in_bounded_memory() {
        let ping = b"\x04\x08\x04PING\0\x01c";
        let (mut connection, wire) = connect();
        wire.push(ping);
        assert!(connection.is_idle());
        assert_eq!(sent(&wire), b"\x04\x06\x04PONGc");
        // The server does not read.
        wire.set_capacity(0);
        wire.push(&ping.repeat(10_000));
        while turn_is_incomplete(&mut connection) {}
        assert!(!wire.has_incoming() && connection.buffered.output.len() < 100);
    }

    /// Takes a turn, and returns true if more turns are necessary.
    fn turn_is_incomplete(connection: &mut ReqConnection<Wire>) -> bool {
        connection.set_ready(true, false);
        assert_eq!(connection.turn(&mut Vec::new()).unwrap(), None);
        connection.has_more()
    }

    #[test]
    fn long_reply_needs_bounded_memory_and_several_turns() {
        let (mut connection, wire) = connect();
        let body = vec![7; MAX_REPLY_BYTES - 11];
        wire.push(&[b"\x01\0\x02", &(body.len() as u64).to_be_bytes()[..], &body].concat());
        let (mut reply, mut turns) = (Vec::new(), 1);
        while connection.turn(&mut reply).unwrap().is_none() {
            connection.set_ready(true, true);
            turns += 1;
        }
        assert!(reply == body);
        assert!(turns >= MAX_REPLY_BYTES.div_ceil(MAX_READS * READ_BYTES), "{turns}");
        assert!(connection.is_idle());
        assert!(connection.buffered.input.capacity() <= READ_BYTES);
        wire.push(b"\x01\0\x02\x7f\xff\xff\xff\xff\xff\xff\xff");
        assert!(matches!(turn(&mut connection), Err(DisconnectReason::Protocol(_))));
    }
}
