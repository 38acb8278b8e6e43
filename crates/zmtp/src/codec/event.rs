//! Decoded events and protocol errors.

use std::borrow::Cow;

/// An event that [`Decoder::decode`](crate::codec::Decoder::decode) or
/// [`ReplyDecoder::decode`](crate::codec::ReplyDecoder::decode) returns.
#[derive(Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event<'i> {
    /// The decoder needs more input.
    Incomplete,
    /// The decoded bytes require no action.
    Ignored,
    /// The caller must send these bytes as the next part of the handshake.
    Send(&'static [u8]),
    /// The handshake is complete.
    Ready,
    /// A PING command. The caller must answer with a PONG command that has the same context.
    /// [`push_pong`](crate::codec::push_pong) encodes it.
    Ping {
        /// The context of the PING command, at most 16 bytes.
        context: &'i [u8],
    },
    /// A complete request, or a complete reply from a
    /// [`ReplyDecoder`](crate::codec::ReplyDecoder). The encoded reply to a request must begin with
    /// the envelope that [`Decoder::envelope`](crate::codec::Decoder::envelope) returns.
    Message {
        /// The last frame of the body. In a long frame of a request, all bytes after the first
        /// [`max_kept_bytes`](crate::ServerConfig::max_kept_bytes) are replaced with zeros.
        last: Cow<'i, [u8]>,
        /// The number of frames in the body.
        frames: usize,
    },
    /// A request with a frame longer than
    /// [`max_request_bytes`](crate::ServerConfig::max_request_bytes). The caller must send an error reply immediately; the decoder skips the rest of the request.
    Oversized(ProtocolError),
}

/// An error caused by a peer: a violation of the protocol or an exceeded limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ProtocolError {
    /// The first bytes are not the greeting of a ZeroMQ peer.
    #[error("expected a ZMTP greeting, found other bytes")]
    Greeting,
    /// The security mechanism is not NULL.
    #[error("expected the security mechanism NULL, found another mechanism")]
    Mechanism,
    /// The greeting is not followed by a valid READY command.
    #[error("expected a READY command, found other bytes")]
    Ready,
    /// The server supports only ZMTP 2.0, and the client only ZMTP 3.
    #[error("expected ZMTP 3 (ZeroMQ 4), found ZMTP 2 (ZeroMQ 3)")]
    Version,
    /// The client is neither a REQ nor a DEALER socket.
    #[error("expected a REQ or DEALER socket, found another socket type")]
    SocketType,
    /// The server is neither a REP nor a ROUTER socket.
    #[error("expected a REP or ROUTER socket, found another socket type")]
    ServerSocketType,
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
    #[error("expected an envelope of at most {max} bytes, found more")]
    EnvelopeTooLong {
        /// The limit in bytes.
        max: usize,
    },
    /// A reply does not begin with the empty delimiter frame, or has no other frame.
    #[error("expected a reply after an empty frame, found another message")]
    Delimiter,
    /// A reply is longer than the limit.
    #[error("expected a reply of at most {max} bytes, found more")]
    ReplyTooLong {
        /// The limit in bytes.
        max: usize,
    },
    /// A command is malformed.
    #[error("expected a well-formed command, found a malformed one")]
    Command,
    /// The peer has sent an ERROR command.
    #[error("the peer has sent an ERROR command")]
    Error,
}
