//! ZMTP 3.1, the protocol of ZeroMQ on TCP, as far as a REP socket speaks it
//! (<https://rfc.zeromq.org/spec/37/>): bytes to steps and back, without input or output.
//!
//! ```text
//! greeting   FF, 8 bytes, 7F, version 3 1, mechanism in 20 bytes, 32 bytes: 64 bytes each way
//! READY      a command each way that tells the kind of the socket
//! frames     flags, length in 1 or 8 bytes, body
//! request    frames of an envelope, an empty frame, the frames of the body
//! ```

use crate::limits::{MAX_ENVELOPE_BYTES, MAX_HANDSHAKE_BYTES, MAX_REQUEST_BYTES};

/// What each side sends first: version 3.1, no authentication.
pub(crate) const GREETING: [u8; GREETING_BYTES] = {
    let mut greeting = [0; GREETING_BYTES];
    greeting[0] = 0xff;
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

/// The command that ends a handshake on our side.
pub(crate) const READY: &[u8] = b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\x03REP";

const GREETING_BYTES: usize = 64;
const VERSION: usize = 10;
const MECHANISM: usize = 12;
const NULL: &[u8; 20] = b"NULL\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

/// Another frame of the same message follows.
const MORE: u8 = 1;
/// The length has 8 bytes instead of one.
const LONG: u8 = 2;
/// The frame is a command to the socket, not a part of a message.
const COMMAND: u8 = 4;

/// A peer that does not keep to the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Violation {
    #[error("expected the greeting of ZMTP 3, found something else")]
    Greeting,
    #[error("expected the mechanism NULL, found another")]
    Mechanism,
    #[error("expected the command READY, found something else")]
    Ready,
    #[error("expected a REQ or DEALER socket, found another")]
    SocketType,
    #[error("expected flags from 0 to 7 and no command in several frames, found {0:#04x}")]
    Flags(u8),
    #[error("expected a frame of at most {most} bytes, found {found}")]
    FrameTooLong { most: usize, found: u64 },
    #[error("expected an envelope of at most {MAX_ENVELOPE_BYTES} bytes, found more")]
    EnvelopeTooLong,
    #[error("expected a command with a name, found none")]
    Command,
    #[error("expected no command ERROR, found one")]
    Error,
}

/// What the bytes received mean.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Step<'i> {
    /// Nothing yet, more bytes are needed.
    More,
    /// Something that calls for no answer.
    Nothing,
    /// A greeting, to be answered with [`READY`].
    Greeting,
    /// The handshake is done.
    Ready,
    /// A ping, to be answered with this context.
    Ping { context: &'i [u8] },
    /// A whole request: the last frame of its body and how many frames that has. The envelope of
    /// the reply is [`Decoder::envelope`].
    Request { last: &'i [u8], frames: usize },
}

/// Where a peer is in the protocol.
#[derive(Debug, Default)]
pub(crate) struct Decoder {
    stage: Stage,
    /// The frames before the body of the present request, as they came.
    envelope: Vec<u8>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    #[default]
    Greeting,
    Handshake,
    /// Between two messages; the envelope is that of the last.
    Idle,
    /// In the envelope of a message.
    Envelope,
    /// In the body of a message, after so many frames.
    Body {
        frames: usize,
    },
}

impl Decoder {
    /// Whether the handshake is done.
    pub(crate) fn is_ready(&self) -> bool {
        !matches!(self.stage, Stage::Greeting | Stage::Handshake)
    }

    /// What a reply to the request just decoded begins with.
    pub(crate) fn envelope(&self) -> &[u8] {
        &self.envelope
    }

    /// Takes what it can from the front of `input`; gives how many bytes that was, and the step.
    pub(crate) fn step<'i>(&mut self, input: &'i [u8]) -> Result<(usize, Step<'i>), Violation> {
        if self.stage == Stage::Greeting {
            return self.greeting(input);
        }
        let most = if self.is_ready() { MAX_REQUEST_BYTES } else { MAX_HANDSHAKE_BYTES };
        let Some(frame) = Frame::split(input, most)? else { return Ok((0, Step::More)) };
        let step = match self.stage {
            Stage::Greeting | Stage::Handshake => self.handshake(&frame)?,
            _ if frame.is_command() => command(frame.body)?,
            Stage::Idle => {
                self.envelope.clear();
                self.address(&frame)?
            }
            Stage::Envelope => self.address(&frame)?,
            Stage::Body { frames } => self.body(&frame, frames.saturating_add(1)),
        };
        Ok((frame.whole.len(), step))
    }

    fn greeting<'i>(&mut self, input: &'i [u8]) -> Result<(usize, Step<'i>), Violation> {
        // What is wrong is refused as soon as it shows.
        let has = |index: usize, good: fn(u8) -> bool| input.get(index).is_none_or(|&b| good(b));
        if !(has(0, |b| b == 0xff) && has(9, |b| b & 1 == 1) && has(VERSION, |b| b >= 3)) {
            return Err(Violation::Greeting);
        }
        let Some(greeting) = input.get(..GREETING_BYTES) else { return Ok((0, Step::More)) };
        if &greeting[MECHANISM..][..NULL.len()] != NULL {
            return Err(Violation::Mechanism);
        }
        self.stage = Stage::Handshake;
        Ok((GREETING_BYTES, Step::Greeting))
    }

    fn handshake<'i>(&mut self, frame: &Frame<'i>) -> Result<Step<'i>, Violation> {
        let properties = frame.body.strip_prefix(b"\x05READY").filter(|_| frame.is_command());
        let kind = socket_type(properties.ok_or(Violation::Ready)?)?;
        if !matches!(kind, b"REQ" | b"DEALER") {
            return Err(Violation::SocketType);
        }
        self.stage = Stage::Idle;
        Ok(Step::Ready)
    }

    fn address<'i>(&mut self, frame: &Frame<'i>) -> Result<Step<'i>, Violation> {
        if !frame.more() {
            // Without an empty frame and a body it is no request, and no reply is possible.
            self.stage = Stage::Idle;
            return Ok(Step::Nothing);
        }
        if self.envelope.len() + frame.whole.len() > MAX_ENVELOPE_BYTES {
            return Err(Violation::EnvelopeTooLong);
        }
        self.envelope.extend_from_slice(frame.whole);
        let at_end = frame.body.is_empty();
        self.stage = if at_end { Stage::Body { frames: 0 } } else { Stage::Envelope };
        Ok(Step::Nothing)
    }

    fn body<'i>(&mut self, frame: &Frame<'i>, frames: usize) -> Step<'i> {
        if frame.more() {
            self.stage = Stage::Body { frames };
            return Step::Nothing;
        }
        self.stage = Stage::Idle;
        Step::Request { last: frame.body, frames }
    }
}

/// A frame at the front of what has been received.
struct Frame<'i> {
    flags: u8,
    whole: &'i [u8],
    body: &'i [u8],
}

impl<'i> Frame<'i> {
    /// The frame at the front, if all of it is there.
    fn split(input: &'i [u8], most: usize) -> Result<Option<Self>, Violation> {
        let Some((&flags, rest)) = input.split_first() else { return Ok(None) };
        if flags > (MORE | LONG | COMMAND) || flags & (MORE | COMMAND) == (MORE | COMMAND) {
            return Err(Violation::Flags(flags));
        }
        let (found, rest) = if flags & LONG == 0 {
            let Some((&length, rest)) = rest.split_first() else { return Ok(None) };
            (u64::from(length), rest)
        } else {
            let Some((length, rest)) = rest.split_first_chunk() else { return Ok(None) };
            (u64::from_be_bytes(*length), rest)
        };
        let length = usize::try_from(found).ok().filter(|&length| length <= most);
        let length = length.ok_or(Violation::FrameTooLong { most, found })?;
        Ok(rest.get(..length).map(|body| {
            let header = input.len() - rest.len();
            Self { flags, whole: &input[..header + length], body }
        }))
    }

    const fn more(&self) -> bool {
        self.flags & MORE != 0
    }

    const fn is_command(&self) -> bool {
        self.flags & COMMAND != 0
    }
}

/// The kind of socket that a READY command tells.
fn socket_type(mut properties: &[u8]) -> Result<&[u8], Violation> {
    let mut kind = None;
    while !properties.is_empty() {
        let (name, value, rest) = property(properties).ok_or(Violation::Ready)?;
        if name.eq_ignore_ascii_case(b"Socket-Type") {
            kind = Some(value);
        }
        properties = rest;
    }
    kind.ok_or(Violation::Ready)
}

/// Splits a property off: its name, its value, and what follows.
fn property(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (&length, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(length.into())?;
    let (length, rest) = rest.split_first_chunk()?;
    let (value, rest) = rest.split_at_checked(u32::from_be_bytes(*length).try_into().ok()?)?;
    Some((name, value, rest))
}

/// The longest context of a ping that is sent back, in bytes.
const CONTEXT_BYTES: usize = 16;

/// What a command after the handshake asks for. Those that a REP socket does not know it ignores.
fn command(body: &[u8]) -> Result<Step<'_>, Violation> {
    let (&length, rest) = body.split_first().ok_or(Violation::Command)?;
    let (name, rest) = rest.split_at_checked(length.into()).ok_or(Violation::Command)?;
    match name {
        b"" => Err(Violation::Command),
        b"ERROR" => Err(Violation::Error),
        // Two bytes tell how long the peer wants to be missed; the rest is the context.
        b"PING" => {
            let context = rest.get(2..).ok_or(Violation::Command)?;
            Ok(Step::Ping { context: &context[..context.len().min(CONTEXT_BYTES)] })
        }
        _ => Ok(Step::Nothing),
    }
}

/// Adds the last frame of a message.
pub(crate) fn push_last_frame(output: &mut Vec<u8>, body: &[u8]) {
    if let Ok(length) = u8::try_from(body.len()) {
        output.extend_from_slice(&[0, length]);
    } else {
        output.push(LONG);
        output.extend_from_slice(&(body.len() as u64).to_be_bytes());
    }
    output.extend_from_slice(body);
}

/// Adds the answer to a ping.
pub(crate) fn push_pong(output: &mut Vec<u8>, context: &[u8]) {
    const NAME: &[u8] = b"\x04PONG";
    // A context has at most 16 bytes.
    let length = u8::try_from(NAME.len() + context.len()).unwrap_or(u8::MAX);
    output.extend_from_slice(&[COMMAND, length]);
    output.extend_from_slice(NAME);
    output.extend_from_slice(context);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const REQ: &[u8] = b"\x04\x26\x05READY\x0bSocket-Type\0\0\0\x03REQ\x08Identity\0\0\0\0";

    /// What a peer sends before its first request.
    fn hello() -> Vec<u8> {
        [&GREETING[..], REQ].concat()
    }

    /// All that is said of the steps that bytes lead to.
    fn steps(decoder: &mut Decoder, mut input: &[u8]) -> Vec<String> {
        let mut steps = Vec::new();
        loop {
            match decoder.step(input) {
                Ok((_, Step::More)) => return steps,
                Ok((taken, step)) => {
                    assert!(taken > 0, "{step:?}");
                    steps.push(format!("{step:?}"));
                    input = &input[taken..];
                }
                Err(violation) => {
                    steps.push(violation.to_string());
                    return steps;
                }
            }
        }
    }

    /// The steps after a handshake.
    fn after_handshake(input: &[u8]) -> (Vec<String>, Decoder) {
        let mut decoder = Decoder::default();
        assert_eq!(steps(&mut decoder, &hello()), ["Greeting", "Ready"]);
        assert!(decoder.is_ready());
        (steps(&mut decoder, input), decoder)
    }

    #[test]
    fn a_greeting_and_ready_begin() {
        let mut decoder = Decoder::default();
        assert!(!decoder.is_ready());
        assert_eq!(steps(&mut decoder, &GREETING), ["Greeting"]);
        assert_eq!(&GREETING[10..17], b"\x03\x01NULL\0");
        assert_eq!(usize::from(READY[1]), READY.len() - 2);
        assert_eq!(socket_type(READY.strip_prefix(b"\x04\x19\x05READY").unwrap()), Ok(&b"REP"[..]));
    }

    #[test]
    fn other_greetings_are_refused_at_the_first_wrong_byte() {
        for wrong in [&b"GET / HTTP/1.1"[..], b"\0", b"\x01\0", b"\xff\0\0\0\0\0\0\0\x01\0"] {
            assert_eq!(steps(&mut Decoder::default(), wrong), [Violation::Greeting.to_string()]);
        }
        for (index, byte, violation) in [
            (10, 1, Violation::Greeting),
            (12, b'C', Violation::Mechanism),
            (31, 1, Violation::Mechanism),
        ] {
            let mut greeting = GREETING;
            greeting[index] = byte;
            assert_eq!(steps(&mut Decoder::default(), &greeting), [violation.to_string()]);
        }
        let mut later = GREETING;
        (later[VERSION], later[VERSION + 1]) = (4, 7);
        assert_eq!(steps(&mut Decoder::default(), &later), ["Greeting"]);
    }

    #[test]
    fn other_handshakes_are_refused() {
        let refused = |bytes: &[u8]| {
            let mut decoder = Decoder::default();
            let said = steps(&mut decoder, &[&GREETING[..], bytes].concat());
            assert!(!decoder.is_ready());
            said[1].clone()
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

    #[test]
    fn requests_come_with_their_envelopes() {
        let (said, decoder) = after_handshake(b"\x01\0\0\x04ping");
        assert_eq!(said.len(), 2);
        assert_eq!(said[1], format!("{:?}", Step::Request { last: b"ping", frames: 1 }));
        assert_eq!(decoder.envelope(), b"\x01\0");
        let (said, mut decoder) =
            after_handshake(b"\x01\x02ab\x01\x01c\x01\0\x01\0\x03\0\0\0\0\0\0\0\0\0\x01x");
        assert_eq!(said.last(), Some(&format!("{:?}", Step::Request { last: b"x", frames: 3 })));
        assert_eq!(decoder.envelope(), b"\x01\x02ab\x01\x01c\x01\0");
        // A message without an empty frame or without a body has no reply; the next one has.
        for none in [&b"\0\x04ping"[..], b"\x01\x04ping\0\x01x", b"\0\0", b"\x01\x01x\0\0"] {
            assert!(steps(&mut decoder, none).iter().all(|step| step == "Nothing"));
            let said = steps(&mut decoder, b"\x01\0\0\0");
            assert_eq!(said[1], format!("{:?}", Step::Request { last: b"", frames: 1 }));
            assert_eq!(decoder.envelope(), b"\x01\0");
        }
    }

    #[test]
    fn frames_have_limits() {
        let said = |bytes: &[u8]| after_handshake(bytes).0.last().unwrap().clone();
        for flags in [8, 0x80, COMMAND | MORE] {
            assert_eq!(said(&[flags]), Violation::Flags(flags).to_string());
        }
        let most = (MAX_REQUEST_BYTES as u64).to_be_bytes();
        let longest = [&b"\x01\0\x02"[..], &most, &vec![0; MAX_REQUEST_BYTES]].concat();
        assert!(said(&longest).starts_with("Request"));
        let huge = said(b"\x02\x7f\xff\xff\xff\xff\xff\xff\xff");
        assert_eq!(huge, "expected a frame of at most 65536 bytes, found 9223372036854775807");
        let envelope = [&b"\x01\xff"[..], &[7; 255]].concat().repeat(16);
        assert_eq!(said(&envelope), Violation::EnvelopeTooLong.to_string());
        let (said, decoder) = after_handshake(&[b"\x01\0".repeat(100_000), vec![0, 0]].concat());
        assert!(said.last().unwrap().ends_with("frames: 100000 }"));
        assert_eq!(decoder.envelope.len(), 2, "no frame but the last is kept");
    }

    #[test]
    fn commands_are_answered_or_ignored() {
        let (said, mut decoder) = after_handshake(b"\x04\x0a\x04PING\0\x01abc");
        assert_eq!(said, [format!("{:?}", Step::Ping { context: b"abc" })]);
        let long = b"\x04\x1b\x04PING\0\x000123456789abcdefghij";
        let context = &b"0123456789abcdef"[..];
        assert_eq!(steps(&mut decoder, long), [format!("{:?}", Step::Ping { context })]);
        // Between the frames of a message too.
        let said = steps(&mut decoder, b"\x01\0\x04\x0a\x09SUBSCRIBE\x04\x02\x01X\0\x01x");
        assert_eq!(said[1..3], ["Nothing", "Nothing"]);
        assert!(said[3].starts_with("Request"));
        for wrong in [&b"\x04\0"[..], b"\x04\x01\0", b"\x04\x02\x05A", b"\x04\x06\x04PING\0"] {
            assert_eq!(after_handshake(wrong).0, [Violation::Command.to_string()]);
        }
        assert_eq!(after_handshake(b"\x04\x07\x05ERROR\0").0, [Violation::Error.to_string()]);
    }

    #[test]
    fn what_we_send() {
        let mut output = Vec::new();
        push_last_frame(&mut output, b"ok");
        push_pong(&mut output, b"abc");
        assert_eq!(output, b"\0\x02ok\x04\x08\x04PONGabc");
        output.clear();
        push_last_frame(&mut output, &[7; 256]);
        assert_eq!(output[..10], *b"\x02\0\0\0\0\0\0\x01\0\x07");
        assert_eq!(output.len(), 9 + 256);
    }

    proptest! {
        #[test]
        fn any_bytes_lead_to_the_same_steps_however_they_are_cut(
            begun in any::<bool>(),
            bytes in prop::collection::vec(prop_oneof![0u8..8, any::<u8>()], 0..400),
            cuts in prop::collection::vec(1usize..40, 1..40),
        ) {
            let input = if begun { [hello(), bytes].concat() } else { bytes };
            let whole = steps(&mut Decoder::default(), &input);
            let (mut decoder, mut pieces) = (Decoder::default(), Vec::new());
            let (mut start, mut end) = (0, 0);
            'input: for cut in cuts.into_iter().cycle() {
                end = input.len().min(end + cut);
                loop {
                    match decoder.step(&input[start..end]) {
                        Ok((_, Step::More)) => break,
                        Ok((taken, step)) => {
                            pieces.push(format!("{step:?}"));
                            start += taken;
                        }
                        Err(violation) => {
                            pieces.push(violation.to_string());
                            break 'input;
                        }
                    }
                }
                if end == input.len() {
                    break;
                }
            }
            prop_assert_eq!(whole, pieces);
        }
    }
}
