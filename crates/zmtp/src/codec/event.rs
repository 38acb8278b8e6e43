//! Decoded events and violations of the protocol.

use std::borrow::Cow;

use crate::limits::MAX_ENVELOPE_BYTES;

/// The meaning of the bytes at the front of the input.
#[derive(Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event<'i> {
    /// The input is incomplete: more bytes are needed.
    Incomplete,
    /// The bytes need no answer.
    Ignored,
    /// A part of the handshake: send these bytes.
    Send(&'static [u8]),
    /// The handshake is complete.
    Ready,
    /// A PING command: answer with [`push_pong`](crate::codec::push_pong) and this context.
    Ping {
        /// The context, at most 16 bytes.
        context: &'i [u8],
    },
    /// A complete request. [`Decoder::envelope`](crate::codec::Decoder::envelope) returns the
    /// envelope of its reply.
    Request {
        /// The last frame of the body. Zeros replace the bytes after the first
        /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES).
        last: Cow<'i, [u8]>,
        /// The number of frames in the body.
        frames: usize,
    },
    /// A request with a frame over the limit. Answer it now; the decoder skips the rest of it.
    Oversized(ProtocolError),
}

/// A violation of ZMTP, or of a limit, by the peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProtocolError {
    /// The first bytes are no greeting of ZMTP 2 or 3.
    #[error("expected a ZMTP 2 or 3 greeting, found other bytes")]
    Greeting,
    /// The security mechanism is not NULL.
    #[error("expected the mechanism NULL, found another mechanism")]
    Mechanism,
    /// The greeting is not followed by a valid READY command.
    #[error("expected the command READY, found other bytes")]
    Ready,
    /// The peer is neither a REQ nor a DEALER socket.
    #[error("expected a REQ or DEALER socket, found another socket type")]
    SocketType,
    /// The flags byte of a frame is invalid.
    #[error("expected flags from 0 to 7 and a command in a single frame, found flags {0:#04x}")]
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
    #[error("expected a command with a name, found a malformed command")]
    Command,
    /// The peer has sent the command ERROR.
    #[error("expected no command ERROR, found one")]
    Error,
}
