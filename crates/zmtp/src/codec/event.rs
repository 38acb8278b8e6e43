//! Decoded events.

use crate::codec::error::ProtocolError;

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
        /// The last frame of the body.
        last: &'i [u8],
        /// The number of frames in the body.
        frames: usize,
    },
    /// A complete request whose last frame is longer than
    /// [`MAX_KEPT_BYTES`](crate::limits::MAX_KEPT_BYTES).
    LongRequest {
        /// The last frame of the body; zeros replace the bytes that were not kept.
        last: Vec<u8>,
        /// The number of frames in the body.
        frames: usize,
    },
    /// A request with a frame over the limit. Answer it now; the decoder skips the rest of it.
    Oversized(ProtocolError),
}
