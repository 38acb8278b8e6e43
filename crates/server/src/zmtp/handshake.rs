//! What is said before the first message.
//!
//! A peer that knows no more than ZMTP 2.0 (<https://rfc.zeromq.org/spec/15/>), as older ones in
//! Java and C# do, says so in the eleventh byte. Then each side tells the kind of its socket in one
//! byte and its name in a frame, and the frames are the same as in ZMTP 3. So what is said after
//! the version waits for that of the peer.

use super::command::socket_type;
use super::frame::{Frame, Head};
use super::{Step, Violation};
use crate::limits::MAX_COMMAND_BYTES;

/// What each side sends: version 3.1, no authentication.
pub(crate) const GREETING: [u8; GREETING_BYTES] = {
    let mut greeting = [0; GREETING_BYTES];
    greeting[0] = 0xff;
    greeting[8] = 1;
    greeting[9] = 0x7f;
    greeting[VERSION] = 3;
    greeting[VERSION + 1] = 1;
    let mut index = 0;
    while index < NULL.len() {
        greeting[MECHANISM + index] = NULL[index];
        index += 1;
    }
    greeting
};

/// What is sent first, then, and at last of the greeting.
pub(crate) const SIGNATURE: &[u8] = GREETING.split_at(VERSION).0;
const MAJOR_VERSION: &[u8] = GREETING.split_at(VERSION + 1).0.split_at(VERSION).1;
const REST: &[u8] = GREETING.split_at(VERSION + 1).1;

/// What ZMTP 2.0 has in place of the rest: a REP socket without a name.
const KIND_AND_NAME: &[u8] = b"\x04\0\0";

/// The command that ends a handshake on our side.
pub(crate) const READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REP";

const GREETING_BYTES: usize = 64;
const VERSION: usize = 10;
const MECHANISM: usize = 12;
const NULL: &[u8; 20] = b"NULL\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// Where a peer is in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Handshake {
    #[default]
    Signature,
    Version,
    /// The rest of the greeting.
    Greeting,
    /// The command READY.
    Ready,
    /// With a peer of ZMTP 2.0, the kind of its socket …
    Kind,
    /// … and its name.
    Name,
}

/// Bytes taken, what comes next if the handshake is not done, and the step.
type Next<'i> = (usize, Option<Handshake>, Step<'i>);

impl Handshake {
    /// Takes what it can from the front of `input`.
    pub(super) fn step<'i>(self, input: &[u8]) -> Result<Next<'i>, Violation> {
        let next = match self {
            Self::Signature => signature(input)?,
            Self::Version => version(input)?,
            Self::Greeting => greeting(input)?,
            Self::Ready => ready(input)?,
            Self::Kind => kind(input)?,
            Self::Name => name(input)?,
        };
        Ok(next.unwrap_or((0, Some(self), Step::More)))
    }
}

fn signature<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    // What is wrong is refused as soon as it shows.
    let has = |index: usize, good: fn(u8) -> bool| input.get(index).is_none_or(|&b| good(b));
    if !(has(0, |b| b == 0xff) && has(VERSION - 1, |b| b & 1 == 1)) {
        return Err(Violation::Greeting);
    }
    let next = (VERSION, Some(Handshake::Version), Step::Say(MAJOR_VERSION));
    Ok((input.len() >= VERSION).then_some(next))
}

fn version<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    Ok(match input.first() {
        None => None,
        Some(1) => Some((1, Some(Handshake::Kind), Step::Say(KIND_AND_NAME))),
        Some(3..) => Some((1, Some(Handshake::Greeting), Step::Say(REST))),
        Some(_) => return Err(Violation::Greeting),
    })
}

fn greeting<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    let Some(rest) = input.get(..REST.len()) else { return Ok(None) };
    if &rest[MECHANISM - VERSION - 1..][..NULL.len()] != NULL {
        return Err(Violation::Mechanism);
    }
    Ok(Some((rest.len(), Some(Handshake::Ready), Step::Say(READY))))
}

fn ready<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    let Some(frame) = frame(input)? else { return Ok(None) };
    let properties = frame.body.strip_prefix(b"\x05READY").filter(|_| frame.is_command());
    match socket_type(properties.ok_or(Violation::Ready)?)? {
        b"REQ" | b"DEALER" => Ok(Some((frame.whole.len(), None, Step::Ready))),
        _ => Err(Violation::SocketType),
    }
}

fn kind<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    match input.first() {
        None => Ok(None),
        // REQ and DEALER.
        Some(3 | 5) => Ok(Some((1, Some(Handshake::Name), Step::Nothing))),
        Some(_) => Err(Violation::SocketType),
    }
}

fn name<'i>(input: &[u8]) -> Result<Option<Next<'i>>, Violation> {
    match frame(input)? {
        Some(frame) if frame.more() || frame.is_command() => Err(Violation::Greeting),
        frame => Ok(frame.map(|frame| (frame.whole.len(), None, Step::Ready))),
    }
}

fn frame(input: &[u8]) -> Result<Option<Frame<'_>>, Violation> {
    let head = Head::read(input, |_| MAX_COMMAND_BYTES)?;
    Ok(head.and_then(|head| Frame::split(input, head)))
}

#[cfg(test)]
mod tests {
    use super::super::Decoder;
    use super::super::tests::steps;
    use super::*;

    #[test]
    fn a_greeting_and_ready_begin() {
        let mut decoder = Decoder::default();
        assert!(!decoder.is_ready());
        let say = |bytes| format!("{:?}", Step::Say(bytes));
        let expected = [MAJOR_VERSION, REST, READY].map(say);
        assert_eq!(steps(&mut decoder, &GREETING), expected);
        assert_eq!([SIGNATURE, MAJOR_VERSION, REST].concat(), GREETING);
        assert_eq!(&GREETING[10..17], b"\x03\x01NULL\0");
        assert_eq!(usize::from(READY[1]), READY.len() - 2);
        assert_eq!(socket_type(READY.strip_prefix(b"\x04\x19\x05READY").unwrap()), Ok(&b"REP"[..]));
    }

    #[test]
    fn other_greetings_are_refused_at_the_first_wrong_byte() {
        for wrong in [&b"GET / HTTP/1.1"[..], b"\0", b"\x01\0", b"\xff\0\0\0\0\0\0\0\x01\0"] {
            let said = steps(&mut Decoder::default(), wrong);
            assert_eq!(said.last(), Some(&Violation::Greeting.to_string()));
        }
        for (index, byte, violation) in [
            (10, 2, Violation::Greeting),
            (12, b'C', Violation::Mechanism),
            (31, 1, Violation::Mechanism),
        ] {
            let mut greeting = GREETING;
            greeting[index] = byte;
            let said = steps(&mut Decoder::default(), &greeting);
            assert_eq!(said.last(), Some(&violation.to_string()));
        }
        let mut later = GREETING;
        (later[VERSION], later[VERSION + 1]) = (4, 7);
        assert_eq!(steps(&mut Decoder::default(), &later).len(), 3);
    }

    #[test]
    fn older_peers_are_met_with_their_own_version() {
        for (kind, good) in [(3, true), (5, true), (1, false), (8, false)] {
            let hello = [SIGNATURE, &[1, kind, 0, 2], b"me", b"\x01\0\0\x04ping"].concat();
            let mut decoder = Decoder::default();
            let said = steps(&mut decoder, &hello);
            assert_eq!(said[1], format!("{:?}", Step::Say(KIND_AND_NAME)));
            assert_eq!(decoder.is_ready(), good);
            let request = format!("{:?}", Step::Request { last: b"ping", frames: 1 });
            let end = if good { request } else { Violation::SocketType.to_string() };
            assert_eq!(said.last(), Some(&end));
        }
        for name in [&b"\x01\0"[..], b"\x04\0"] {
            let said = steps(&mut Decoder::default(), &[SIGNATURE, &[1, 3], name].concat());
            assert_eq!(said.last(), Some(&Violation::Greeting.to_string()));
        }
    }

    #[test]
    fn other_handshakes_are_refused() {
        let refused = |bytes: &[u8]| {
            let mut decoder = Decoder::default();
            let said = steps(&mut decoder, &[&GREETING[..], bytes].concat());
            assert!(!decoder.is_ready());
            said.last().unwrap().clone()
        };
        let of_type = |kind: &[u8]| {
            let length = u8::try_from(kind.len()).unwrap();
            let head = [4, 22 + length].into_iter().chain(*b"\x05READY\x0bsocket-type\0\0\0");
            refused(&head.chain([length]).chain(kind.iter().copied()).collect::<Vec<_>>())
        };
        for kind in [&b"PUB"[..], b"SUB", b"PUSH", b"REP", b"ROUTER", b""] {
            assert_eq!(of_type(kind), Violation::SocketType.to_string());
        }
        for wrong in [
            &b"\x04\x06\x05READY"[..],
            b"\x04\x07\x05READY\x0b",
            b"\x04\x0b\x05READY\x00\xff\xff\xff\xff",
            b"\x04\x06\x05ERROR",
            b"\0\x04ping",
            b"\x04\0",
        ] {
            assert_eq!(refused(wrong), Violation::Ready.to_string());
        }
        let long = refused(b"\x06\0\0\0\0\0\0\x10\x01");
        assert_eq!(long, "expected a frame of at most 4096 bytes, found 4097");
    }
}
