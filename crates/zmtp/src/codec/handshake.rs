//! The handshake, which consists of a greeting and a READY command.
//!
//! A peer that supports only ZMTP 2.0 (<https://rfc.zeromq.org/spec/15/>), such as `JeroMQ` 0.3,
//! sends version 1 in the eleventh byte of its greeting. After the eleventh byte, both sides of a
//! ZMTP 2.0 connection send their socket type in one byte and their identity in a frame. All later
//! frames have the format of ZMTP 3. The server waits for the peer's version before it sends the
//! rest of its own greeting, because the rest depends on that version. The client does not support
//! ZMTP 2.0.

use crate::codec::event::{Event, ProtocolError};
use crate::codec::frame::{Frame, socket_type};

/// The ZMTP 3.1 greeting for the security mechanism NULL. Both sides of a connection send this
/// greeting.
pub const GREETING: [u8; 64] =
    *b"\xff\0\0\0\0\0\0\0\x01\x7f\x03\x01NULL\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
    \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// The bytes of the greeting before the version.
pub const SIGNATURE: &[u8] = GREETING.split_at(VERSION).0;
/// The major version in the greeting (one byte).
const MAJOR_VERSION: &[u8] = GREETING.split_at(VERSION + 1).0.split_at(VERSION).1;
/// The bytes of the greeting after the major version.
const REST: &[u8] = GREETING.split_at(VERSION + 1).1;

/// The bytes that the server sends to a ZMTP 2.0 peer instead of [`REST`]: the socket type REP and
/// an empty identity.
const TYPE_AND_IDENTITY: &[u8] = b"\x04\0\0";

/// The READY command of a REP socket.
pub const READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REP";

/// The READY command of a REQ socket.
pub const REQ_READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REQ";

/// The position of the major version in the greeting.
const VERSION: usize = 10;
/// The position of the security mechanism in [`REST`].
const MECHANISM: std::ops::Range<usize> = 1..21;

/// The socket type of this side of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Rep,
    Req,
}

impl Role {
    /// Returns the READY command of this side.
    const fn ready(self) -> &'static [u8] {
        match self {
            Self::Rep => READY,
            Self::Req => REQ_READY,
        }
    }

    /// Checks the socket type of the peer.
    fn check_peer(self, socket_type: &[u8]) -> Result<(), ProtocolError> {
        match (self, socket_type) {
            (Self::Rep, b"REQ" | b"DEALER") | (Self::Req, b"REP" | b"ROUTER") => Ok(()),
            (Self::Rep, _) => Err(ProtocolError::SocketType),
            (Self::Req, _) => Err(ProtocolError::ServerSocketType),
        }
    }
}

/// The part of the handshake that the peer sends next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Handshake {
    #[default]
    Signature,
    Version,
    /// The bytes of the greeting after the major version.
    Greeting,
    /// The READY command.
    Ready,
    /// The socket type of a ZMTP 2.0 peer.
    SocketType,
    /// The identity of a ZMTP 2.0 peer.
    Identity,
    /// Nothing: the handshake is complete.
    Complete,
}

/// The number of bytes consumed, the next state of the handshake, and the event.
type HandshakeStep<'i> = (usize, Handshake, Event<'i>);

impl Handshake {
    /// Decodes the next part of the handshake from the beginning of `input`. `max_command` is the
    /// maximum length of a command, in bytes.
    pub(crate) fn decode<'i>(
        self,
        input: &[u8],
        role: Role,
        max_command: usize,
    ) -> Result<HandshakeStep<'i>, ProtocolError> {
        let incomplete = Ok((0, self, Event::Incomplete));
        match self {
            Self::Signature => {
                // Wrong bytes are refused without waiting for the complete signature.
                let is_wrong = |index, mask| input.get(index).is_some_and(|byte| !byte & mask != 0);
                if is_wrong(0, 0xff) || is_wrong(VERSION - 1, 1) {
                    return Err(ProtocolError::Greeting);
                }
                if input.len() < VERSION {
                    return incomplete;
                }
                Ok((VERSION, Self::Version, Event::Send(MAJOR_VERSION)))
            }
            Self::Version => match input.first() {
                None => incomplete,
                Some(1) if role == Role::Req => Err(ProtocolError::Version),
                Some(1) => Ok((1, Self::SocketType, Event::Send(TYPE_AND_IDENTITY))),
                Some(3..) => Ok((1, Self::Greeting, Event::Send(REST))),
                Some(_) => Err(ProtocolError::Greeting),
            },
            Self::Greeting => match input.get(..REST.len()) {
                None => incomplete,
                Some(rest) if rest[MECHANISM] != REST[MECHANISM] => Err(ProtocolError::Mechanism),
                Some(rest) => Ok((rest.len(), Self::Ready, Event::Send(role.ready()))),
            },
            Self::Ready => {
                let Some(frame) = Frame::read(input, max_command)? else { return incomplete };
                let properties = frame.body.strip_prefix(b"\x05READY");
                let properties = properties.filter(|_| frame.header.is_command());
                role.check_peer(socket_type(properties.ok_or(ProtocolError::Ready)?)?)?;
                Ok((frame.whole.len(), Self::Complete, Event::Ready))
            }
            Self::SocketType => match input.first() {
                None => incomplete,
                // The socket types REQ and DEALER.
                Some(3 | 5) => Ok((1, Self::Identity, Event::Ignored)),
                Some(_) => Err(ProtocolError::SocketType),
            },
            Self::Identity => match Frame::read(input, max_command)? {
                None => incomplete,
                Some(Frame { header, .. }) if header.has_more() || header.is_command() => {
                    Err(ProtocolError::Greeting)
                }
                Some(frame) => Ok((frame.whole.len(), Self::Complete, Event::Ready)),
            },
            Self::Complete => incomplete,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::decoder::{Decoder, Phase, events};

    #[test]
    fn handshake_sends_greeting_and_ready() {
        let mut decoder = Decoder::default();
        assert_eq!(decoder.phase(), Phase::Handshake);
        let sent = |bytes| format!("{:?}", Event::Send(bytes));
        let expected = [MAJOR_VERSION, REST, READY].map(sent);
        assert_eq!(events(&mut decoder, &GREETING), expected);
        assert_eq!([SIGNATURE, MAJOR_VERSION, REST].concat(), GREETING);
        assert_eq!(&GREETING[10..17], b"\x03\x01NULL\0");
        assert_eq!(usize::from(READY[1]), READY.len() - 2);
        assert_eq!(socket_type(READY.strip_prefix(b"\x04\x19\x05READY").unwrap()), Ok(&b"REP"[..]));
    }

    #[test]
    fn invalid_greeting_is_refused_at_its_first_wrong_byte() {
        for wrong in [&b"GET / HTTP/1.1"[..], b"\0", b"\x01\0", b"\xff\0\0\0\0\0\0\0\x01\0"] {
            let events = events(&mut Decoder::default(), wrong);
            assert_eq!(events.last(), Some(&ProtocolError::Greeting.to_string()));
        }
        for (index, byte, violation) in [
            (10, 2, ProtocolError::Greeting),
            (12, b'C', ProtocolError::Mechanism),
            (31, 1, ProtocolError::Mechanism),
        ] {
            let mut greeting = GREETING;
            greeting[index] = byte;
            let events = events(&mut Decoder::default(), &greeting);
            assert_eq!(events.last(), Some(&violation.to_string()));
        }
        let mut later = GREETING;
        (later[VERSION], later[VERSION + 1]) = (4, 7);
        assert_eq!(events(&mut Decoder::default(), &later).len(), 3);
        // Without a mechanism, the as-server flag and the reserved bytes have no meaning.
        (later[VERSION - 2], later[32]) = (7, 1);
        assert_eq!(events(&mut Decoder::default(), &later).len(), 3);
        later[VERSION] = 0;
        let events = events(&mut Decoder::default(), &later);
        assert_eq!(events.last(), Some(&ProtocolError::Greeting.to_string()));
    }

    #[test]
    fn dealer_is_accepted_like_req() {
        let mut decoder = Decoder::default();
        let ready = b"\x04\x1c\x05READY\x0bSOCKET-TYPE\0\0\0\x06DEALER";
        let events = events(&mut decoder, &[&GREETING[..], ready].concat());
        assert_eq!(events.last().unwrap(), "Ready");
        assert_eq!(decoder.phase(), Phase::Ready);
    }

    #[test]
    fn zmtp_2_peer_is_answered_in_zmtp_2() {
        for (kind, good) in [(3, true), (5, true), (1, false), (8, false)] {
            let hello = [SIGNATURE, &[1, kind, 0, 2], b"me", b"\x01\0\0\x04ping"].concat();
            let mut decoder = Decoder::default();
            let events = events(&mut decoder, &hello);
            assert_eq!(events[1], format!("{:?}", Event::Send(TYPE_AND_IDENTITY)));
            assert_eq!(decoder.phase() == Phase::Ready, good);
            let request = format!("{:?}", Event::Message { last: b"ping".into(), frames: 1 });
            let end = if good { request } else { ProtocolError::SocketType.to_string() };
            assert_eq!(events.last(), Some(&end));
        }
        for name in [&b"\x01\0"[..], b"\x04\0"] {
            let events = events(&mut Decoder::default(), &[SIGNATURE, &[1, 3], name].concat());
            assert_eq!(events.last(), Some(&ProtocolError::Greeting.to_string()));
        }
    }

    #[test]
    fn invalid_ready_is_refused() {
        let refused = |bytes: &[u8]| {
            let mut decoder = Decoder::default();
            let events = events(&mut decoder, &[&GREETING[..], bytes].concat());
            assert_eq!(decoder.phase(), Phase::Handshake);
            events.last().unwrap().clone()
        };
        let refused_type = |kind: &[u8]| {
            let length = u8::try_from(kind.len()).unwrap();
            let head = [4, 22 + length].into_iter().chain(*b"\x05READY\x0bsocket-type\0\0\0");
            refused(&head.chain([length]).chain(kind.iter().copied()).collect::<Vec<_>>())
        };
        for kind in [&b"PUB"[..], b"SUB", b"PUSH", b"REP", b"ROUTER", b""] {
            assert_eq!(refused_type(kind), ProtocolError::SocketType.to_string());
        }
        for wrong in [
            &b"\x04\x06\x05READY"[..],
            b"\x04\x07\x05READY\x0b",
            b"\x04\x0b\x05READY\x00\xff\xff\xff\xff",
            b"\x04\x06\x05ERROR",
            b"\0\x04ping",
            b"\x04\0",
        ] {
            assert_eq!(refused(wrong), ProtocolError::Ready.to_string());
        }
        let long = refused(b"\x06\0\0\0\0\0\0\x10\x01");
        assert_eq!(long, "expected a frame of at most 4096 bytes, found 4097");
    }
}
