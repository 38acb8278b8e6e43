//! The replies that a simulator sends to a client.

use mmsim_maze::{Excerpt, WallsAround};

use crate::layout::{BufferTooSmall, front_of, write_bytes};

const PONG: &[u8] = b"pong";
const OK: &[u8] = b"ok";

/// The prefix of a reply that reports an error.
pub const ERROR_PREFIX: &str = "error: ";

/// The prefix of the reason of an error reply to a mouse that a wall has blocked.
pub const CRASH_PREFIX: &str = "crash: ";

/// A reply that borrows the bytes of its message. A reply can be decoded without knowing the
/// request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reply<'a> {
    /// The reply to `ping`.
    Pong,
    /// The reply to a successful `reset` or state request.
    Ok,
    /// The reply to a walls request.
    Walls(WallsAround),
    /// The reply to `info`: a JSON object that `Info` can decode (feature `info`).
    Info(&'a str),
    /// The reason why the request cannot be served. Nothing has changed.
    Error(&'a str),
}

/// The error for bytes that are not a valid reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected pong, ok, three bytes of walls, info or an error, found {0}")]
pub struct UnknownReply(pub Excerpt<16>);

impl<'a> Reply<'a> {
    /// Decodes a reply.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a valid reply.
    ///
    /// ```
    /// use mmsim_protocol::{Reply, WallsAround};
    /// let around = WallsAround { left: true, front: false, right: true };
    /// assert_eq!(Reply::decode(&[1, 0, 1]), Ok(Reply::Walls(around)));
    /// assert_eq!(Reply::decode(b"error: no"), Ok(Reply::Error("no")));
    /// assert!(Reply::decode(b"what?").is_err());
    /// ```
    pub fn decode(message: &'a [u8]) -> Result<Self, UnknownReply> {
        let reply = match message {
            PONG => Some(Self::Pong),
            OK => Some(Self::Ok),
            &[left @ 0..=1, front @ 0..=1, right @ 0..=1] => Some(Self::Walls(WallsAround {
                left: left == 1,
                front: front == 1,
                right: right == 1,
            })),
            _ => core::str::from_utf8(message).ok().and_then(|text| {
                let error = text.strip_prefix(ERROR_PREFIX).map(Self::Error);
                error.or_else(|| text.starts_with('{').then_some(Self::Info(text)))
            }),
        };
        reply.ok_or_else(|| UnknownReply(Excerpt::new(message)))
    }

    /// Returns true if the reply reports that a wall has blocked the mouse.
    ///
    /// ```
    /// use mmsim_protocol::Reply;
    /// assert!(Reply::Error("crash: there is a wall").is_crash());
    /// ```
    pub fn is_crash(&self) -> bool {
        matches!(self, Self::Error(reason) if reason.starts_with(CRASH_PREFIX))
    }

    /// Writes the reply to the start of `buffer` and returns the number of bytes written.
    ///
    /// # Errors
    /// Returns an error if the buffer is shorter than the reply.
    pub fn encode(&self, buffer: &mut [u8]) -> Result<usize, BufferTooSmall> {
        match *self {
            Self::Pong => write_bytes(buffer, PONG),
            Self::Ok => write_bytes(buffer, OK),
            Self::Walls(WallsAround { left, front, right }) => {
                write_bytes(buffer, &[left, front, right].map(u8::from))
            }
            Self::Info(json) => write_bytes(buffer, json.as_bytes()),
            Self::Error(reason) => {
                let message = front_of(buffer, self.len())?;
                let (prefix, rest) = message.split_at_mut(ERROR_PREFIX.len());
                prefix.copy_from_slice(ERROR_PREFIX.as_bytes());
                rest.copy_from_slice(reason.as_bytes());
                Ok(self.len())
            }
        }
    }

    /// Returns the length of the reply in bytes.
    #[allow(clippy::len_without_is_empty)] // no reply is empty
    pub const fn len(&self) -> usize {
        match self {
            Self::Pong => PONG.len(),
            Self::Ok => OK.len(),
            Self::Walls(_) => 3,
            Self::Info(json) => json.len(),
            Self::Error(reason) => ERROR_PREFIX.len() + reason.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn replies_are_encoded_and_decoded() {
        let around = WallsAround { left: false, front: true, right: true };
        let other = WallsAround { left: true, front: false, right: false };
        for (reply, bytes) in [
            (Reply::Pong, &b"pong"[..]),
            (Reply::Ok, b"ok"),
            (Reply::Walls(around), &[0, 1, 1]),
            (Reply::Walls(other), &[1, 0, 0]),
            (Reply::Info("{}"), b"{}"),
            (Reply::Error("expected a, found b"), b"error: expected a, found b"),
            (Reply::Error(""), b"error: "),
        ] {
            let mut buffer = [0xa5; 32];
            assert_eq!(reply.encode(&mut buffer), Ok(bytes.len()));
            assert_eq!(&buffer[..bytes.len()], bytes);
            assert!(buffer[bytes.len()..].iter().all(|&byte| byte == 0xa5));
            assert_eq!(reply.len(), bytes.len());
            assert_eq!(Reply::decode(bytes), Ok(reply));
            let too_small = BufferTooSmall { expected: bytes.len(), found: bytes.len() - 1 };
            assert_eq!(reply.encode(&mut buffer[..bytes.len() - 1]), Err(too_small));
        }
    }

    #[test]
    fn other_bytes_are_errors() {
        for message in [&b""[..], b"OK", b"pong ", b"error", b"error:", b"error: \xff", b" {}"] {
            assert!(Reply::decode(message).is_err(), "{message:?}");
        }
        for message in [&[0, 1][..], &[0, 1, 2], &[0, 2, 1], &[2, 1, 0], &[0, 1, 0, 1]] {
            assert!(Reply::decode(message).is_err(), "{message:?}");
        }
        insta::assert_snapshot!(Reply::decode(&[0, 1, 2]).unwrap_err(), @r#"expected pong, ok, three bytes of walls, info or an error, found "\x00\x01\x02""#);
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_reply_or_an_error(message in prop::collection::vec(any::<u8>(), 0..80)) {
            if let Ok(reply) = Reply::decode(&message) {
                let mut buffer = [0xa5; 80];
                let length = reply.encode(&mut buffer).unwrap();
                prop_assert_eq!(&buffer[..length], &message[..]);
            }
        }

        #[test]
        fn an_error_survives_a_round_trip(reason in ".*") {
            let mut buffer = vec![0xa5; reason.len() + 16];
            let length = Reply::Error(&reason).encode(&mut buffer).unwrap();
            prop_assert_eq!(Reply::decode(&buffer[..length]), Ok(Reply::Error(&reason)));
        }
    }
}
