//! The decoder of a REQ socket, which converts received bytes to replies.

use crate::codec::event::{Event, ProtocolError};
use crate::codec::frame::{Frame, Header, decode_command};
use crate::codec::handshake::{Handshake, Role};
use crate::config::ClientConfig;

/// A decoder for the bytes that a server sends, beginning with the greeting.
///
/// The input may arrive in chunks of any length. A frame is decoded when all of it has arrived, so
/// the caller stores at most [`max_reply_bytes`](ClientConfig::max_reply_bytes) and one chunk. The
/// decoder stores nothing else.
#[derive(Debug, Default)]
pub struct ReplyDecoder {
    config: ClientConfig,
    handshake: Handshake,
    stage: ReplyStage,
}

/// After the handshake, the part of a reply that the decoder expects next.
#[derive(Debug, Default)]
enum ReplyStage {
    /// The empty delimiter frame.
    #[default]
    Delimiter,
    /// The next frame of the body. `frames` and `bytes` are the number and length of the body
    /// frames so far.
    Body { frames: usize, bytes: usize },
}

impl ReplyDecoder {
    /// Creates a decoder for a new connection.
    pub fn new(config: &ClientConfig) -> Self {
        Self { config: *config, ..Self::default() }
    }

    /// Returns true if the handshake is complete.
    pub fn is_ready(&self) -> bool {
        self.handshake == Handshake::Complete
    }

    /// Returns true if the handshake is complete and no part of a reply has been decoded since the
    /// previous reply.
    pub fn is_idle(&self) -> bool {
        self.is_ready() && matches!(self.stage, ReplyStage::Delimiter)
    }

    /// Decodes the next event from the beginning of `input`. Returns the number of bytes consumed
    /// and the event. An [`Event::Message`] contains the last frame of a reply. The decoder drops
    /// the other frames of the body, because valid replies have one frame.
    ///
    /// # Errors
    /// Returns an error if the server violates the protocol or exceeds a limit. The caller should
    /// then disconnect.
    pub fn decode<'i>(&mut self, input: &'i [u8]) -> Result<(usize, Event<'i>), ProtocolError> {
        let (max, max_command) = (self.config.max_reply_bytes, self.config.max_command_bytes);
        if !self.is_ready() {
            let (consumed, next, event) = self.handshake.decode(input, Role::Req, max_command)?;
            self.handshake = next;
            return Ok((consumed, event));
        }
        let Some(header) = Header::read(input, max, max_command)? else {
            return Ok((0, Event::Incomplete));
        };
        let Some(frame) = Frame::split(input, header) else { return Ok((0, Event::Incomplete)) };
        let event = match self.stage {
            _ if frame.header.is_command() => decode_command(frame.body)?,
            ReplyStage::Delimiter if frame.body.is_empty() && frame.header.has_more() => {
                self.stage = ReplyStage::Body { frames: 0, bytes: frame.whole.len() };
                Event::Ignored
            }
            ReplyStage::Delimiter => return Err(ProtocolError::Delimiter),
            ReplyStage::Body { frames, bytes } => {
                let (frames, bytes) = (frames + 1, bytes + frame.whole.len());
                if bytes > max {
                    return Err(ProtocolError::ReplyTooLong { max });
                }
                if frame.header.has_more() {
                    self.stage = ReplyStage::Body { frames, bytes };
                    Event::Ignored
                } else {
                    self.stage = ReplyStage::Delimiter;
                    Event::Message { last: frame.body.into(), frames }
                }
            }
        };
        Ok((frame.whole.len(), event))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::codec::decoder::Decoder;
    use crate::codec::frame::push_request;
    use crate::codec::handshake::{GREETING, READY, REQ_READY};

    const MAX_REPLY_BYTES: usize = 2000;
    const CONFIG: ClientConfig =
        ClientConfig { max_reply_bytes: MAX_REPLY_BYTES, ..ClientConfig::DEFAULT };

    /// Passes `input` to `decode` in chunks, cycling through `lengths` for their lengths. Returns the
    /// events as text. If decoding fails, the last element is the error.
    fn decode_in_pieces(
        input: &[u8],
        lengths: &[usize],
        mut decode: impl FnMut(&[u8]) -> Result<(usize, String), ProtocolError>,
    ) -> Vec<String> {
        let (mut events, mut start, mut end) = (Vec::new(), 0, 0);
        for length in lengths.iter().cycle() {
            end = input.len().min(end + length);
            loop {
                match decode(&input[start..end]) {
                    Ok((0, _)) => break,
                    Ok((consumed, event)) => {
                        start += consumed;
                        events.push(event);
                    }
                    Err(error) => {
                        events.push(error.to_string());
                        return events;
                    }
                }
            }
            if end == input.len() {
                return events;
            }
        }
        unreachable!("`lengths` is not empty");
    }

    fn events_in_pieces(input: &[u8], lengths: &[usize]) -> Vec<String> {
        let mut decoder = ReplyDecoder::new(&CONFIG);
        decode_in_pieces(input, lengths, |input| {
            let (consumed, event) = decoder.decode(input)?;
            Ok((consumed, format!("{event:?}")))
        })
    }

    /// Returns the events after a handshake.
    fn events(input: &[u8]) -> Vec<String> {
        let input = [&GREETING[..], READY, input].concat();
        let mut events = events_in_pieces(&input, &[input.len()]);
        events.drain(..4);
        events
    }

    fn message(last: &[u8], frames: usize) -> String {
        format!("{:?}", Event::Message { last: last.into(), frames })
    }

    #[test]
    fn handshake_sends_greeting_and_ready_of_a_req_socket() {
        for minor_version in [0, 1, 7] {
            let mut greeting = GREETING;
            greeting[11] = minor_version;
            let events = events_in_pieces(&[&greeting[..], READY].concat(), &[1]);
            let sent = |bytes| format!("{:?}", Event::Send(bytes));
            assert_eq!(events[0], sent(&GREETING[10..11]));
            assert_eq!(events[1], sent(&GREETING[11..]));
            assert_eq!(events[2..], [sent(REQ_READY), "Ready".into()]);
        }
        let mut decoder = ReplyDecoder::default();
        assert!(!decoder.is_ready() && !decoder.is_idle());
        for part in [&GREETING[..10], &GREETING[10..11], &GREETING[11..], READY] {
            assert_eq!(decoder.decode(part).unwrap().0, part.len());
        }
        assert!(decoder.is_idle());
        assert_eq!(decoder.decode(b"\x01\0").unwrap(), (2, Event::Ignored));
        assert!(decoder.is_ready() && !decoder.is_idle());
    }

    #[test]
    fn other_peers_are_refused() {
        let last = |input: &[u8]| events_in_pieces(input, &[input.len()]).pop().unwrap();
        let zmtp_2 = [&GREETING[..10], b"\x01\x04\0\0"].concat();
        assert_eq!(last(&zmtp_2), "expected ZMTP 3 (ZeroMQ 4), found ZMTP 2 (ZeroMQ 3)");
        assert_eq!(last(b"HTTP/1.1 400 "), "expected a ZMTP greeting, found other bytes");
        let own_kind = [&GREETING[..], REQ_READY].concat();
        assert_eq!(last(&own_kind), ProtocolError::ServerSocketType.to_string());
        let router = b"\x04\x1c\x05READY\x0bSocket-Type\0\0\0\x06ROUTER";
        assert_eq!(last(&[&GREETING[..], router].concat()), "Ready");
    }

    #[test]
    fn replies_are_decoded_and_commands_handled() {
        let ping = format!("{:?}", Event::Ping { context: b"c" });
        for (input, expected) in [
            (&b"\x01\0\0\x02ok"[..], vec!["Ignored".into(), message(b"ok", 1)]),
            (b"\x01\0\0\0", vec!["Ignored".into(), message(b"", 1)]),
            (b"\x01\0\x01\x01a\0\x01b", vec!["Ignored".into(), "Ignored".into(), message(b"b", 2)]),
            (
                b"\x04\x08\x04PING\0\x01c\x01\0\x04\x08\x04PING\0\x01c\x04\x02\x01X\0\x01x",
                vec![
                    ping.clone(),
                    "Ignored".into(),
                    ping.clone(),
                    "Ignored".into(),
                    message(b"x", 1),
                ],
            ),
            (b"\0\x02ok", vec![ProtocolError::Delimiter.to_string()]),
            (b"\0\0", vec![ProtocolError::Delimiter.to_string()]),
            (b"\x01\x01x", vec![ProtocolError::Delimiter.to_string()]),
            (b"\x08", vec![ProtocolError::Flags(8).to_string()]),
        ] {
            assert_eq!(events(input), expected, "{input:?}");
        }
    }

    #[test]
    fn length_of_replies_is_limited() {
        let head = b"\x01\0\x02";
        let max = MAX_REPLY_BYTES - 2 - 9;
        let reply = |length: usize, sent: usize| {
            [head, &(length as u64).to_be_bytes()[..], &vec![7; sent]].concat()
        };
        assert_eq!(events(&reply(max, max))[1], message(&vec![7; max], 1));
        let too_long = ProtocolError::ReplyTooLong { max: MAX_REPLY_BYTES }.to_string();
        assert_eq!(events(&reply(max + 1, max + 1))[1], too_long);
        // A huge frame is refused before its body arrives.
        for found in [MAX_REPLY_BYTES + 1, usize::MAX >> 1] {
            let error = events(&reply(found, 0)).pop().unwrap();
            let expected = format!("expected a frame of at most {MAX_REPLY_BYTES} bytes, found ");
            assert_eq!(error, expected + &found.to_string());
        }
        // So is an endless number of frames.
        assert_eq!(events(&b"\x01\0".repeat(MAX_REPLY_BYTES)).pop().unwrap(), too_long);
    }

    proptest! {
        #[test]
        fn decoder_accepts_any_bytes_in_any_pieces(
            after_handshake in any::<bool>(),
            bytes in prop::collection::vec(prop_oneof![0u8..8, any::<u8>()], 0..400),
            cuts in prop::collection::vec(1usize..40, 1..40),
        ) {
            let handshake = if after_handshake { [&GREETING[..], READY].concat() } else { vec![] };
            let input = [handshake, bytes].concat();
            prop_assert_eq!(events_in_pieces(&input, &[input.len()]), events_in_pieces(&input, &cuts));
        }

        #[test]
        fn encoded_messages_are_decoded_by_both_sides(
            messages in prop::collection::vec(
                prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 1..4), 0..5),
            cuts in prop::collection::vec(1usize..100, 1..40),
        ) {
            let (mut bytes, mut expected) = (Vec::new(), Vec::new());
            for frames in &messages {
                let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
                push_request(&mut bytes, &frames);
                expected.push(message(frames[frames.len() - 1], frames.len()));
            }
            let is_message = |event: &String| event.starts_with("Message");
            // A request has the same bytes as a reply.
            let replies = events_in_pieces(&[&GREETING[..], READY, &bytes].concat(), &cuts);
            prop_assert_eq!(replies.into_iter().filter(is_message).collect::<Vec<_>>(), &expected[..]);
            let mut decoder = Decoder::default();
            let input = [&GREETING[..], REQ_READY, &bytes].concat();
            let requests = decode_in_pieces(&input, &cuts, |input| {
                let (consumed, event) = decoder.decode(input)?;
                Ok((consumed, format!("{event:?}")))
            });
            prop_assert_eq!(requests.into_iter().filter(is_message).collect::<Vec<_>>(), expected);
        }
    }
}
