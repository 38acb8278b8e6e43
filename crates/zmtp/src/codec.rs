//! A codec for REP and REQ sockets. The codec implements ZMTP 3.1
//! (<https://rfc.zeromq.org/spec/37/>) without performing I/O: it decodes received bytes into
//! events, and encodes requests and replies. A server uses [`Decoder`], and a client uses
//! [`ReplyDecoder`].
//!
//! ```text
//! greeting   FF, 8 bytes, 7F, version 3 1, mechanism in 20 bytes, 32 bytes: 64 bytes each way
//! READY      a command each way with the socket type
//! frame      flags, length of 1 or 8 bytes, body
//! request    the frames of the envelope, an empty frame, the frames of the body
//! reply      the envelope of the request, an empty frame, the frames of the body
//! ```

pub(crate) mod decoder;
pub(crate) mod event;
pub(crate) mod frame;
pub(crate) mod handshake;
pub(crate) mod reply;

pub use decoder::{Decoder, Phase};
pub use event::{Event, ProtocolError};
pub use frame::{push_last_frame, push_pong, push_request};
pub use handshake::{GREETING, READY, REQ_READY, SIGNATURE};
pub use reply::ReplyDecoder;
