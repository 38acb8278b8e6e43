//! The decoder, which converts received bytes to events.

use std::borrow::Cow;

use crate::codec::event::{Event, ProtocolError};
use crate::codec::frame::{Frame, Header, decode_command};
use crate::codec::handshake::{Handshake, Role};
use crate::config::ServerConfig;

/// A decoder for the bytes that a client sends, beginning with the greeting.
///
/// The input may arrive in chunks of any length. The decoder stores at most one envelope and the
/// first [`max_kept_bytes`](ServerConfig::max_kept_bytes) of one frame.
#[derive(Debug, Default)]
pub struct Decoder {
    config: ServerConfig,
    handshake: Handshake,
    stage: Stage,
    /// The encoded envelope of the current request.
    envelope: Vec<u8>,
    /// The long frame that is being received, if any.
    long: Option<LongFrame>,
    /// True if an oversized frame has arrived, and no complete request has followed yet.
    is_oversized: bool,
}

/// The phase of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The handshake is incomplete.
    Handshake,
    /// The peer may send requests.
    Ready,
    /// A frame longer than [`max_request_bytes`](ServerConfig::max_request_bytes) has arrived, and no
    /// complete request has followed yet.
    Oversized,
}

/// A frame of more than [`max_kept_bytes`](ServerConfig::max_kept_bytes), which the decoder stores
/// only in part.
#[derive(Debug)]
struct LongFrame {
    header: Header,
    /// The number of bytes of the frame that have not arrived yet.
    remaining: usize,
    /// The first bytes of the frame.
    kept: Vec<u8>,
}

/// After the handshake, the part of a message that the decoder expects next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Stage {
    /// The first frame of a message. Until this frame arrives, the decoder keeps the envelope of
    /// the previous message.
    #[default]
    Idle,
    /// The next frame of the envelope.
    Envelope,
    /// The next frame of the body. `frames` is the number of body frames so far.
    Body { frames: usize },
    /// The next frame of a refused message, which the decoder skips.
    Refused,
}

impl Decoder {
    /// Creates a decoder for a new connection.
    pub fn new(config: &ServerConfig) -> Self {
        Self { config: *config, ..Self::default() }
    }

    /// Returns the limits.
    pub(crate) const fn config(&self) -> &ServerConfig {
        &self.config
    }

    /// Returns the phase of the connection.
    pub const fn phase(&self) -> Phase {
        match self.handshake {
            Handshake::Complete if self.is_oversized => Phase::Oversized,
            Handshake::Complete => Phase::Ready,
            _ => Phase::Handshake,
        }
    }

    /// Returns the envelope of the latest request as encoded bytes. The encoded reply must begin
    /// with a copy of the envelope.
    pub fn envelope(&self) -> &[u8] {
        &self.envelope
    }

    /// Decodes the next event from the beginning of `input`. Returns the number of bytes consumed
    /// and the event.
    ///
    /// # Errors
    /// Returns an error if the peer violates the protocol or exceeds a limit. The caller should
    /// then disconnect the peer.
    pub fn decode<'i>(&mut self, input: &'i [u8]) -> Result<(usize, Event<'i>), ProtocolError> {
        if self.handshake != Handshake::Complete {
            let max_command = self.config.max_command_bytes;
            let (consumed, next, event) = self.handshake.decode(input, Role::Rep, max_command)?;
            self.handshake = next;
            return Ok((consumed, event));
        }
        if let Some(long) = self.long.take() {
            return Ok(self.continue_long(long, input));
        }
        let Some(header) = Header::read(input, usize::MAX, self.config.max_command_bytes)? else {
            return Ok((0, Event::Incomplete));
        };
        if !header.is_command() && header.length > self.config.max_kept_bytes {
            return Ok((header.bytes, self.begin_long(header)?));
        }
        let Some(frame) = Frame::split(input, header) else { return Ok((0, Event::Incomplete)) };
        let event = match self.stage {
            _ if frame.header.is_command() => decode_command(frame.body)?,
            Stage::Idle | Stage::Envelope if frame.header.has_more() => {
                self.push_envelope(&frame)?
            }
            // A message that ends within the envelope has no body and cannot be answered.
            _ => self.end_frame(frame.header.has_more(), frame.body.into()),
        };
        Ok((frame.whole.len(), event))
    }

    /// Appends a frame to the envelope. An empty frame completes the envelope.
    fn push_envelope(&mut self, frame: &Frame) -> Result<Event<'static>, ProtocolError> {
        if self.stage == Stage::Idle {
            self.envelope.clear();
        }
        if self.envelope.len() + frame.whole.len() > self.config.max_envelope_bytes {
            return Err(self.envelope_too_long());
        }
        self.envelope.extend_from_slice(frame.whole);
        self.stage =
            if frame.body.is_empty() { Stage::Body { frames: 0 } } else { Stage::Envelope };
        Ok(Event::Ignored)
    }

    const fn envelope_too_long(&self) -> ProtocolError {
        ProtocolError::EnvelopeTooLong { max: self.config.max_envelope_bytes }
    }

    fn begin_long(&mut self, header: Header) -> Result<Event<'static>, ProtocolError> {
        let max = self.config.max_request_bytes;
        let (remaining, is_oversized) = (header.length, header.length > max);
        let error = ProtocolError::FrameTooLong { max, found: remaining as u64 };
        let event = match self.stage {
            Stage::Body { .. } if is_oversized => {
                self.is_oversized = true;
                self.stage = Stage::Refused;
                Event::Oversized(error)
            }
            Stage::Body { .. } | Stage::Refused => Event::Ignored,
            _ if is_oversized => return Err(error),
            _ if header.has_more() => return Err(self.envelope_too_long()),
            _ => Event::Ignored,
        };
        self.long = Some(LongFrame { header, remaining, kept: Vec::new() });
        Ok(event)
    }

    /// Consumes the next bytes of a long frame. Stores only its first bytes.
    fn continue_long<'i>(&mut self, mut long: LongFrame, input: &[u8]) -> (usize, Event<'i>) {
        let consumed = input.len().min(long.remaining);
        let kept = consumed.min(self.config.max_kept_bytes - long.kept.len());
        long.kept.extend_from_slice(&input[..kept]);
        long.remaining -= consumed;
        if long.remaining > 0 {
            self.long = Some(long);
            return (consumed, if consumed == 0 { Event::Incomplete } else { Event::Ignored });
        }
        long.kept.resize(long.header.length, 0);
        // A long frame within the envelope is always the last frame of its message.
        (consumed, self.end_frame(long.header.has_more(), long.kept.into()))
    }

    /// Handles the end of a frame. The frame belongs to a body or to a message that gets no reply.
    fn end_frame<'i>(&mut self, has_more: bool, last: Cow<'i, [u8]>) -> Event<'i> {
        match &mut self.stage {
            Stage::Body { frames } if has_more => *frames = frames.saturating_add(1),
            Stage::Body { frames } => {
                let frames = frames.saturating_add(1);
                (self.stage, self.is_oversized) = (Stage::Idle, false);
                return Event::Message { last, frames };
            }
            _ if has_more => {}
            stage => *stage = Stage::Idle,
        }
        Event::Ignored
    }
}

#[cfg(test)]
pub(super) use tests::events;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::codec::frame::{COMMAND, push_last_frame, push_pong};
    use crate::codec::handshake::GREETING;

    const MAX_REQUEST_BYTES: usize = ServerConfig::DEFAULT.max_request_bytes;
    const MAX_KEPT_BYTES: usize = ServerConfig::DEFAULT.max_kept_bytes;
    const ENVELOPE_TOO_LONG: ProtocolError = ProtocolError::EnvelopeTooLong { max: 4096 };

    const REQ: &[u8] = b"\x04\x26\x05READY\x0bSocket-Type\0\0\0\x03REQ\x08Identity\0\0\0\0";

    /// Returns the bytes that a REQ peer sends for the handshake.
    fn handshake() -> Vec<u8> {
        [&GREETING[..], REQ].concat()
    }

    /// Decodes `input`. Returns the events as text. If decoding fails, the last element is the
    /// error.
    pub(crate) fn events(decoder: &mut Decoder, mut input: &[u8]) -> Vec<String> {
        let mut events = Vec::new();
        loop {
            match decoder.decode(input) {
                Ok((_, Event::Incomplete)) => return events,
                Ok((consumed, event)) => {
                    assert!(consumed > 0, "{event:?}");
                    events.push(format!("{event:?}"));
                    input = &input[consumed..];
                }
                Err(error) => {
                    events.push(error.to_string());
                    return events;
                }
            }
        }
    }

    /// Decodes `input` in chunks, cycling through `lengths` for their lengths. Skips the
    /// [`Event::Ignored`] events within a long frame, because their number depends on how the input
    /// is split.
    fn events_in_pieces(input: &[u8], lengths: &[usize]) -> Vec<String> {
        let (mut decoder, mut events) = (Decoder::default(), Vec::new());
        let (mut start, mut end) = (0, 0);
        for length in lengths.iter().cycle() {
            end = input.len().min(end + length);
            loop {
                match decoder.decode(&input[start..end]) {
                    Ok((_, Event::Incomplete)) => break,
                    Ok((consumed, event)) => {
                        let is_skipping = event == Event::Ignored && decoder.long.is_some();
                        if !is_skipping {
                            events.push(format!("{event:?}"));
                        }
                        start += consumed;
                    }
                    Err(error) => {
                        events.push(error.to_string());
                        return events;
                    }
                }
            }
            if end == input.len() {
                break;
            }
        }
        events
    }

    /// Passes a handshake and then `input` to a new decoder. Returns the events decoded from
    /// `input`, and the decoder.
    fn after_handshake(input: &[u8]) -> (Vec<String>, Decoder) {
        let mut decoder = Decoder::default();
        assert_eq!(events(&mut decoder, &handshake()).last().unwrap(), "Ready");
        assert_eq!(decoder.phase(), Phase::Ready);
        (events(&mut decoder, input), decoder)
    }

    #[test]
    fn requests_keep_their_envelopes() {
        let (found, decoder) = after_handshake(b"\x01\0\0\x04ping");
        assert_eq!(found.len(), 2);
        assert_eq!(found[1], format!("{:?}", Event::Message { last: b"ping".into(), frames: 1 }));
        assert_eq!(decoder.envelope(), b"\x01\0");
        let (found, mut decoder) =
            after_handshake(b"\x01\x02ab\x01\x01c\x01\0\x01\0\x03\0\0\0\0\0\0\0\0\0\x01x");
        assert_eq!(
            found.last(),
            Some(&format!("{:?}", Event::Message { last: b"x".into(), frames: 3 }))
        );
        assert_eq!(decoder.envelope(), b"\x01\x02ab\x01\x01c\x01\0");
        // A message without an empty frame or without a body gets no reply, but the next message
        // does.
        for ignored in [&b"\0\x04ping"[..], b"\x01\x04ping\0\x01x", b"\0\0", b"\x01\x01x\0\0"] {
            assert!(events(&mut decoder, ignored).iter().all(|event| event == "Ignored"));
            let found = events(&mut decoder, b"\x01\0\0\0");
            assert_eq!(found[1], format!("{:?}", Event::Message { last: b"".into(), frames: 1 }));
            assert_eq!(decoder.envelope(), b"\x01\0");
        }
    }

    #[test]
    fn frames_and_envelopes_are_limited() {
        let last_event = |bytes: &[u8]| after_handshake(bytes).0.last().unwrap().clone();
        for flags in [8, 0x80, COMMAND | 1] {
            assert_eq!(last_event(&[flags]), ProtocolError::Flags(flags).to_string());
        }
        assert_eq!(last_event(&[8]), "expected frame flags 0, 1, 2, 3, 4 or 6, found 0x08");
        let max = (MAX_REQUEST_BYTES as u64).to_be_bytes();
        let longest = [&b"\x01\0\x02"[..], &max, &vec![7; MAX_REQUEST_BYTES]].concat();
        let mut last = vec![7; MAX_KEPT_BYTES];
        last.resize(MAX_REQUEST_BYTES, 0);
        assert_eq!(
            last_event(&longest),
            format!("{:?}", Event::Message { last: last.into(), frames: 1 })
        );
        let huge = last_event(b"\x02\x7f\xff\xff\xff\xff\xff\xff\xff");
        assert_eq!(huge, "expected a frame of at most 65536 bytes, found 9223372036854775807");
        assert_eq!(last_event(b"\x03\0\0\0\0\0\0\x10\x01"), ENVELOPE_TOO_LONG.to_string());
        let long = [&b"\x02\0\0\0\0\0\0\x10\x01"[..], &[7; 4097]].concat();
        // A long frame within the envelope ends the message. A long frame within the body is a
        // normal frame.
        let ignored = [&long[..], b"\x01\0\0\x01x"].concat();
        assert_eq!(
            last_event(&ignored),
            format!("{:?}", Event::Message { last: b"x".into(), frames: 1 })
        );
        let more = [b"\x01\0\x03", &long[1..], b"\0\x01x"].concat();
        assert_eq!(
            last_event(&more),
            format!("{:?}", Event::Message { last: b"x".into(), frames: 2 })
        );
        let envelope = [&b"\x01\xff"[..], &[7; 255]].concat().repeat(16);
        assert_eq!(last_event(&envelope), ENVELOPE_TOO_LONG.to_string());
        // The envelope may have 4096 bytes: 15 frames, one that fills it up, and an empty frame.
        let with_last = |length: u8| {
            let last =
                [vec![1, length], vec![7; length.into()], b"\x01\0\0\x01x".to_vec()].concat();
            last_event(&[&envelope[..15 * 257], &last].concat())
        };
        let request = format!("{:?}", Event::Message { last: b"x".into(), frames: 1 });
        assert_eq!(with_last(237), request);
        assert_eq!(with_last(238), ENVELOPE_TOO_LONG.to_string());
        let command = |length: u64| {
            let body = [&b"\x01X"[..], &[7; 4096]].concat();
            let length_bytes = length.to_be_bytes();
            last_event(&[b"\x06", &length_bytes[..], &body[..4096]].concat())
        };
        assert_eq!(command(4096), "Ignored");
        assert_eq!(command(4097), "expected a frame of at most 4096 bytes, found 4097");
        let (found, decoder) = after_handshake(&[b"\x01\0".repeat(100_000), vec![0, 0]].concat());
        assert!(found.last().unwrap().ends_with("frames: 100000 }"));
        assert_eq!(decoder.envelope.len(), 2, "the envelope contains no body frames");
    }

    #[test]
    fn oversized_request_is_refused_once_and_skipped() {
        let found = MAX_REQUEST_BYTES as u64 + 1;
        let refused =
            Event::Oversized(ProtocolError::FrameTooLong { max: MAX_REQUEST_BYTES, found });
        let refused = format!("{refused:?}");
        let long = |flags: u8| [&[flags][..], &found.to_be_bytes(), &vec![7; 65_537]].concat();
        let run = |bytes: &[u8]| {
            let (mut found, decoder) = after_handshake(bytes);
            found.retain(|event| event != "Ignored");
            (found, decoder)
        };
        for (more, rest) in [(2, &b""[..]), (3, b"\0\x01x"), (3, b"\x01\x01x\0\x01x")] {
            let message = [b"\x01\0", &long(more)[..], rest].concat();
            let (events, decoder) = run(&message);
            assert_eq!(events, [&*refused]);
            assert_eq!(decoder.phase(), Phase::Oversized);
            // The message is refused before all of it has arrived.
            assert_eq!(run(&message[..11]).0, [&*refused]);
            // The next request is answered as usual.
            let (events, decoder) = run(&[&message[..], b"\x01\0\0\x04ping"].concat());
            let ping = format!("{:?}", Event::Message { last: b"ping".into(), frames: 1 });
            assert_eq!(events, [&*refused, &*ping]);
            assert_eq!(decoder.phase(), Phase::Ready);
        }
        let twice = [b"\x01\0", &long(3)[..], &long(2)].concat();
        assert_eq!(run(&twice).0, [&*refused]);
        // Without an envelope no reply is possible.
        assert_eq!(
            run(&long(2)).0,
            [ProtocolError::FrameTooLong { max: MAX_REQUEST_BYTES, found }.to_string()]
        );
    }

    #[test]
    fn ping_is_answered_and_unknown_commands_ignored() {
        let (found, mut decoder) = after_handshake(b"\x04\x0a\x04PING\0\x01abc");
        assert_eq!(found, [format!("{:?}", Event::Ping { context: b"abc" })]);
        let long = b"\x04\x1b\x04PING\0\x000123456789abcdefghij";
        let context = &b"0123456789abcdef"[..];
        assert_eq!(events(&mut decoder, long), [format!("{:?}", Event::Ping { context })]);
        // Commands may arrive between the frames of a message.
        let found = events(&mut decoder, b"\x01\0\x04\x0a\x09SUBSCRIBE\x04\x02\x01X\0\x01x");
        assert_eq!(found[1..3], ["Ignored", "Ignored"]);
        assert!(found[3].starts_with("Message"));
        for wrong in [&b"\x04\0"[..], b"\x04\x01\0", b"\x04\x02\x05A", b"\x04\x06\x04PING\0"] {
            assert_eq!(after_handshake(wrong).0, [ProtocolError::Command.to_string()]);
        }
        assert_eq!(after_handshake(b"\x04\x07\x05ERROR\0").0, [ProtocolError::Error.to_string()]);
    }

    #[test]
    fn frames_and_pongs_are_encoded() {
        let mut output = Vec::new();
        push_last_frame(&mut output, b"ok");
        push_pong(&mut output, b"abc");
        assert_eq!(output, b"\0\x02ok\x04\x08\x04PONGabc");
        output.clear();
        push_last_frame(&mut output, &[7; 255]);
        assert_eq!(output, [&[0, 255][..], &[7; 255]].concat());
        output.clear();
        push_pong(&mut output, &[7; 256]);
        assert_eq!(output[..14], *b"\x06\0\0\0\0\0\0\x01\x05\x04PONG");
        output.clear();
        push_last_frame(&mut output, &[7; 256]);
        assert_eq!(output[..10], *b"\x02\0\0\0\0\0\0\x01\0\x07");
        assert_eq!(output.len(), 9 + 256);
    }

    proptest! {
        #[test]
        fn events_do_not_depend_on_how_the_input_is_cut(
            after_handshake in any::<bool>(),
            bytes in prop::collection::vec(prop_oneof![0u8..8, any::<u8>()], 0..400),
            cuts in prop::collection::vec(1usize..40, 1..40),
        ) {
            let input = if after_handshake { [handshake(), bytes].concat() } else { bytes };
            prop_assert_eq!(events_in_pieces(&input, &[input.len()]), events_in_pieces(&input, &cuts));
        }
    }

    #[test]
    fn only_the_first_bytes_of_a_long_frame_are_kept() {
        let body = vec![7; 2 * MAX_KEPT_BYTES];
        let mut input = handshake();
        input.extend_from_slice(b"\x01\0");
        push_last_frame(&mut input, &body);
        let events = events_in_pieces(&input, &[input.len()]);
        assert_eq!(events_in_pieces(&input, &[3000]), events);
        let mut kept = vec![7; MAX_KEPT_BYTES];
        kept.resize(2 * MAX_KEPT_BYTES, 0);
        assert!(events.last().unwrap().contains(&format!("{kept:?}")));
    }
}
