//! Decoded events and protocol errors.

use std::borrow::Cow;

use crate::limits::MAX_ENVELOPE_BYTES;

/// An event decoded from the beginning of the input.
#[derive(Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event<'i> {
    /// The input is incomplete: more bytes are needed.
    Incomplete,
    /// The decoded bytes need no answer.
    Ignored,
    /// The next bytes of the handshake to send to the peer.
    Send(&'static [u8]),
    /// The handshake is complete.
    Ready,
    /// A PING command, to be answered with [`push_pong`](crate::codec::push_pong) and the same
    /// context.
    Ping {
        /// The context of the PING command, at most 16 bytes.
        context: &'i [u8],
    },
    /// A complete request. [`Decoder::envelope`](crate::codec::Decoder::envelope) returns the
    /// envelope for the reply.
    Request {
        /// The last frame of the body. Zeros replace the bytes after the first
        /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES).
        last: Cow<'i, [u8]>,
        /// The number of frames in the body.
        frames: usize,
    },
    /// A request that contains an oversized frame. Answer the request immediately; the decoder
    /// skips its remaining bytes.
    Oversized(ProtocolError),
}

/// A peer's violation of the ZMTP protocol or of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProtocolError {
    /// The first bytes are not a ZMTP 2 or 3 greeting.
    #[error("expected a ZMTP 2 or 3 greeting, found other bytes")]
    Greeting,
    /// The security mechanism is not NULL.
    #[error("expected the security mechanism NULL, found another mechanism")]
    Mechanism,
    /// The greeting is not followed by a valid READY command.
    #[error("expected the command READY, found other bytes")]
    Ready,
    /// The peer is neither a REQ nor a DEALER socket.
    #[error("expected a REQ or DEALER socket, found another socket type")]
    SocketType,
    /// The flags byte of a frame is invalid.
    #[error("expected frame flags 0, 1, 2, 3, 4 or 6, found {0:#04x}")]
    Flags(u8),
    /// A frame is longer than the limit.
    #[error("expected a frame of at most {max} bytes, found {found}")]
    FrameTooLong {
        /// The limit in bytes.
        max: usize,
        /// The length of the frame in bytes.
        found: u64,
    },
    /// The address envelope of a request is longer than the limit.
    #[error("expected an envelope of at most {MAX_ENVELOPE_BYTES} bytes, found more")]
    EnvelopeTooLong,
    /// A command is malformed.
    #[error("expected a well-formed command, found a malformed one")]
    Command,
    /// The peer has sent the command ERROR.
    #[error("the peer has sent the command ERROR")]
    Error,
}
