//! ZMTP 3.1, the protocol of ZeroMQ on TCP, as far as a REP socket speaks it
//! (<https://rfc.zeromq.org/spec/37/>): bytes to steps and back, without input or output.
//!
//! ```text
//! greeting   FF, 8 bytes, 7F, version 3 1, mechanism in 20 bytes, 32 bytes: 64 bytes each way
//! READY      a command each way that tells the kind of the socket
//! frames     flags, length in 1 or 8 bytes, body
//! request    frames of an envelope, an empty frame, the frames of the body
//! ```

mod command;
mod frame;
mod handshake;

use command::command;
use frame::{Frame, Head};
use handshake::Handshake;

use crate::limits::{MAX_COMMAND_BYTES, MAX_ENVELOPE_BYTES, MAX_KEPT_BYTES, MAX_REQUEST_BYTES};

pub(crate) use command::push_pong;
pub(crate) use frame::push_last_frame;
pub(crate) use handshake::SIGNATURE;
#[cfg(test)]
pub(crate) use handshake::{GREETING, READY};

/// A peer that does not keep to the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Violation {
    #[error("expected the greeting of ZMTP 2 or 3, found something else")]
    Greeting,
    #[error("expected the mechanism NULL, found another")]
    Mechanism,
    #[error("expected the command READY, found something else")]
    Ready,
    #[error("expected a REQ or DEALER socket, found another")]
    SocketType,
    #[error("expected flags from 0 to 7 and no command in several frames, found {0:#04x}")]
    Flags(u8),
    #[error("expected a frame of at most {max} bytes, found {found}")]
    FrameTooLong { max: usize, found: u64 },
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
    /// Something of a handshake, to be answered with these bytes.
    Say(&'static [u8]),
    /// The handshake is done.
    Ready,
    /// A ping, to be answered with this context.
    Ping { context: &'i [u8] },
    /// A whole request: the last frame of its body and how many frames that has. The envelope of
    /// the reply is [`Decoder::envelope`].
    Request { last: &'i [u8], frames: usize },
    /// The same with a last frame that is longer than is kept: its beginning, then zeros.
    LongRequest { last: Vec<u8>, frames: usize },
    /// A request with a frame over the limit, to be answered at once; the rest of it is skipped.
    TooLong(Violation),
}

/// Where a peer is in the protocol.
#[derive(Debug, Default)]
pub(crate) struct Decoder {
    stage: Stage,
    /// The frames before the body of the present request, as they came.
    envelope: Vec<u8>,
    /// The frame that is received and not kept.
    long: Option<LongFrame>,
    /// Whether a frame over the limit has come since the last request.
    is_oversized: bool,
}

/// A frame that is longer than any right one, and so is not kept.
#[derive(Debug)]
struct LongFrame {
    more: bool,
    length: usize,
    /// Bytes that have not come yet.
    left: usize,
    /// Its first bytes, if it may be the last frame of a request.
    beginning: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Handshake(Handshake),
    /// Between two messages; the envelope is that of the last.
    Idle,
    /// In the envelope of a message.
    Envelope,
    /// In the body of a message, after so many frames.
    Body {
        frames: usize,
    },
    /// In the rest of a message that has been answered already.
    Refused,
}

impl Default for Stage {
    fn default() -> Self {
        Self::Handshake(Handshake::default())
    }
}

impl Decoder {
    /// Whether the handshake is done, and no frame over the limit has come since the last request.
    pub(crate) fn is_ready(&self) -> bool {
        !matches!(self.stage, Stage::Handshake(_)) && !self.is_oversized
    }

    /// What a reply to the request just decoded begins with.
    pub(crate) fn envelope(&self) -> &[u8] {
        &self.envelope
    }

    /// Takes what it can from the front of `input`; gives how many bytes that was, and the step.
    pub(crate) fn step<'i>(&mut self, input: &'i [u8]) -> Result<(usize, Step<'i>), Violation> {
        if let Stage::Handshake(handshake) = self.stage {
            let (taken, next, step) = handshake.step(input)?;
            self.stage = next.map_or(Stage::Idle, Stage::Handshake);
            return Ok((taken, step));
        }
        if let Some(long) = self.long.take() {
            return Ok(self.skip(long, input));
        }
        let max = |is_command| if is_command { MAX_COMMAND_BYTES } else { usize::MAX };
        let Some(head) = Head::read(input, max)? else { return Ok((0, Step::More)) };
        if !head.is_command() && head.length > MAX_KEPT_BYTES {
            return Ok((head.bytes, self.begin_long(&head)?));
        }
        let Some(frame) = Frame::split(input, head) else { return Ok((0, Step::More)) };
        let step = match self.stage {
            _ if frame.is_command() => command(frame.body)?,
            Stage::Body { frames } => self.body(&frame, frames.saturating_add(1)),
            Stage::Envelope => self.address(&frame)?,
            Stage::Refused => {
                self.end_unless(frame.more());
                Step::Nothing
            }
            Stage::Idle | Stage::Handshake(_) => {
                self.envelope.clear();
                self.address(&frame)?
            }
        };
        Ok((frame.whole.len(), step))
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

    fn begin_long(&mut self, head: &Head) -> Result<Step<'static>, Violation> {
        let (more, length) = (head.more(), head.length);
        let is_oversized = length > MAX_REQUEST_BYTES;
        let violation = Violation::FrameTooLong { max: MAX_REQUEST_BYTES, found: length as u64 };
        let step = match self.stage {
            Stage::Body { .. } if is_oversized => {
                self.is_oversized = true;
                self.stage = Stage::Refused;
                Step::TooLong(violation)
            }
            Stage::Body { .. } | Stage::Refused => Step::Nothing,
            _ if is_oversized => return Err(violation),
            _ if more => return Err(Violation::EnvelopeTooLong),
            _ => Step::Nothing,
        };
        self.long = Some(LongFrame { more, length, left: length, beginning: Vec::new() });
        Ok(step)
    }

    /// Takes what has come of a long frame.
    fn skip<'i>(&mut self, mut long: LongFrame, input: &[u8]) -> (usize, Step<'i>) {
        let taken = input.len().min(long.left);
        let kept = taken.min(MAX_KEPT_BYTES - long.beginning.len());
        long.beginning.extend_from_slice(&input[..kept]);
        long.left -= taken;
        if long.left > 0 {
            self.long = Some(long);
            return (taken, if taken == 0 { Step::More } else { Step::Nothing });
        }
        let Stage::Body { frames } = self.stage else {
            // Either the request is answered already, or the message is none: it ends in its envelope.
            self.end_unless(long.more);
            return (taken, Step::Nothing);
        };
        let frames = frames.saturating_add(1);
        if long.more {
            self.stage = Stage::Body { frames };
            return (taken, Step::Nothing);
        }
        self.end_request();
        long.beginning.resize(long.length, 0);
        (taken, Step::LongRequest { last: long.beginning, frames })
    }

    fn end_request(&mut self) {
        self.stage = Stage::Idle;
        self.is_oversized = false;
    }

    fn end_unless(&mut self, more: bool) {
        if !more {
            self.stage = Stage::Idle;
        }
    }

    fn body<'i>(&mut self, frame: &Frame<'i>, frames: usize) -> Step<'i> {
        if frame.more() {
            self.stage = Stage::Body { frames };
            return Step::Nothing;
        }
        self.end_request();
        Step::Request { last: frame.body, frames }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::frame::COMMAND;
    use super::*;

    const REQ: &[u8] = b"\x04\x26\x05READY\x0bSocket-Type\0\0\0\x03REQ\x08Identity\0\0\0\0";

    /// What a peer sends before its first request.
    fn hello() -> Vec<u8> {
        [&GREETING[..], REQ].concat()
    }

    /// All that is said of the steps that bytes lead to.
    pub(super) fn steps(decoder: &mut Decoder, mut input: &[u8]) -> Vec<String> {
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

    /// Returns the steps for bytes that arrive in pieces of these lengths, over and over. A frame that
    /// is not kept counts as one step, however many pieces of it are skipped.
    fn steps_of_pieces(input: &[u8], lengths: &[usize]) -> Vec<String> {
        let (mut decoder, mut steps) = (Decoder::default(), Vec::new());
        let (mut start, mut end) = (0, 0);
        for length in lengths.iter().cycle() {
            end = input.len().min(end + length);
            loop {
                match decoder.step(&input[start..end]) {
                    Ok((_, Step::More)) => break,
                    Ok((taken, step)) => {
                        let is_skipping = step == Step::Nothing && decoder.long.is_some();
                        if !is_skipping {
                            steps.push(format!("{step:?}"));
                        }
                        start += taken;
                    }
                    Err(violation) => {
                        steps.push(violation.to_string());
                        return steps;
                    }
                }
            }
            if end == input.len() {
                break;
            }
        }
        steps
    }

    /// The steps after a handshake.
    fn after_handshake(input: &[u8]) -> (Vec<String>, Decoder) {
        let mut decoder = Decoder::default();
        assert_eq!(steps(&mut decoder, &hello()).last().unwrap(), "Ready");
        assert!(decoder.is_ready());
        (steps(&mut decoder, input), decoder)
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
        for flags in [8, 0x80, COMMAND | 1] {
            assert_eq!(said(&[flags]), Violation::Flags(flags).to_string());
        }
        let most = (MAX_REQUEST_BYTES as u64).to_be_bytes();
        let longest = [&b"\x01\0\x02"[..], &most, &vec![7; MAX_REQUEST_BYTES]].concat();
        let mut last = vec![7; MAX_KEPT_BYTES];
        last.resize(MAX_REQUEST_BYTES, 0);
        assert_eq!(said(&longest), format!("{:?}", Step::LongRequest { last, frames: 1 }));
        let huge = said(b"\x02\x7f\xff\xff\xff\xff\xff\xff\xff");
        assert_eq!(huge, "expected a frame of at most 65536 bytes, found 9223372036854775807");
        assert_eq!(said(b"\x03\0\0\0\0\0\0\x10\x01"), Violation::EnvelopeTooLong.to_string());
        let long = [&b"\x02\0\0\0\0\0\0\x10\x01"[..], &[7; 4097]].concat();
        // In an envelope it ends the message, in the body it is one of its frames.
        let no_request = [&long[..], b"\x01\0\0\x01x"].concat();
        assert_eq!(said(&no_request), format!("{:?}", Step::Request { last: b"x", frames: 1 }));
        let more = [b"\x01\0\x03", &long[1..], b"\0\x01x"].concat();
        assert_eq!(said(&more), format!("{:?}", Step::Request { last: b"x", frames: 2 }));
        let envelope = [&b"\x01\xff"[..], &[7; 255]].concat().repeat(16);
        assert_eq!(said(&envelope), Violation::EnvelopeTooLong.to_string());
        let (said, decoder) = after_handshake(&[b"\x01\0".repeat(100_000), vec![0, 0]].concat());
        assert!(said.last().unwrap().ends_with("frames: 100000 }"));
        assert_eq!(decoder.envelope.len(), 2, "no frame but the last is kept");
    }

    #[test]
    fn a_request_over_the_limit_is_refused_once_and_skipped() {
        let found = MAX_REQUEST_BYTES as u64 + 1;
        let refused = Step::TooLong(Violation::FrameTooLong { max: MAX_REQUEST_BYTES, found });
        let refused = format!("{refused:?}");
        let long = |flags: u8| [&[flags][..], &found.to_be_bytes(), &vec![7; 65_537]].concat();
        let said = |bytes: &[u8]| {
            let (mut said, decoder) = after_handshake(bytes);
            said.retain(|step| step != "Nothing");
            (said, decoder)
        };
        for (more, rest) in [(2, &b""[..]), (3, b"\0\x01x"), (3, b"\x01\x01x\0\x01x")] {
            let message = [b"\x01\0", &long(more)[..], rest].concat();
            let (steps, decoder) = said(&message);
            assert_eq!(steps, [&*refused]);
            assert!(!decoder.is_ready());
            // It is answered before the rest of it has come.
            assert_eq!(said(&message[..11]).0, [&*refused]);
            // The next request is served as usual.
            let (steps, decoder) = said(&[&message[..], b"\x01\0\0\x04ping"].concat());
            let ping = format!("{:?}", Step::Request { last: b"ping", frames: 1 });
            assert_eq!(steps, [&*refused, &*ping]);
            assert!(decoder.is_ready());
        }
        let twice = [b"\x01\0", &long(3)[..], &long(2)].concat();
        assert_eq!(said(&twice).0, [&*refused]);
        // Without an envelope no reply is possible.
        assert_eq!(
            said(&long(2)).0,
            [Violation::FrameTooLong { max: MAX_REQUEST_BYTES, found }.to_string()]
        );
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
            prop_assert_eq!(steps_of_pieces(&input, &[input.len()]), steps_of_pieces(&input, &cuts));
        }
    }
}
