//! The sans-IO codec: bytes to events and back, as a REP socket speaks ZMTP 3.1
//! (<https://rfc.zeromq.org/spec/37/>).
//!
//! ```text
//! greeting   FF, 8 bytes, 7F, version 3 1, mechanism in 20 bytes, 32 bytes: 64 bytes each way
//! READY      a command each way with the socket type
//! frame      flags, length of 1 or 8 bytes, body
//! request    the frames of the envelope, an empty frame, the frames of the body
//! ```

mod command;
mod decoder;
mod error;
mod event;
mod frame;
mod handshake;

pub use command::push_pong;
pub use decoder::Decoder;
pub use error::ProtocolError;
pub use event::Event;
pub use frame::push_last_frame;
pub use handshake::{GREETING, READY, SIGNATURE};
