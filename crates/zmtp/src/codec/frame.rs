//! ZMTP frames. A frame consists of a flags byte, a length field of 1 or 8 bytes, and a body. The
//! body of a command consists of a name and data.

use crate::codec::event::{Event, ProtocolError};

/// The flag that announces another frame of the same message.
const MORE: u8 = 1;
/// The flag for a length field of 8 bytes instead of 1 byte.
const LONG: u8 = 2;
/// The flag that distinguishes a command from a frame of a message.
pub(crate) const COMMAND: u8 = 4;

/// The maximum length of the context of a PING or PONG command, in bytes.
const MAX_CONTEXT_BYTES: usize = 16;

/// The header of a frame: its flags and length.
#[derive(Debug)]
pub(crate) struct Header {
    flags: u8,
    /// The length of the header in bytes.
    pub(crate) bytes: usize,
    /// The length of the body in bytes.
    pub(crate) length: usize,
}

impl Header {
    /// Reads the header at the beginning of `input`, or returns `None` if the header is incomplete.
    /// `max` and `max_command` are the maximum lengths of message frames and commands, in bytes.
    pub(crate) fn read(
        input: &[u8],
        max: usize,
        max_command: usize,
    ) -> Result<Option<Self>, ProtocolError> {
        let Some((&flags, rest)) = input.split_first() else { return Ok(None) };
        if flags > (MORE | LONG | COMMAND) || flags & (MORE | COMMAND) == (MORE | COMMAND) {
            return Err(ProtocolError::Flags(flags));
        }
        let length = if flags & LONG == 0 {
            rest.first().map(|&length| (u64::from(length), 2))
        } else {
            rest.first_chunk().map(|length| (u64::from_be_bytes(*length), 9))
        };
        let Some((found, bytes)) = length else { return Ok(None) };
        let max = if flags & COMMAND == 0 { max } else { max_command };
        let length = usize::try_from(found).ok().filter(|&length| length <= max);
        let length = length.ok_or(ProtocolError::FrameTooLong { max, found })?;
        Ok(Some(Self { flags, bytes, length }))
    }

    /// Returns true if another frame of the same message follows.
    pub(crate) const fn has_more(&self) -> bool {
        self.flags & MORE != 0
    }

    pub(crate) const fn is_command(&self) -> bool {
        self.flags & COMMAND != 0
    }
}

/// A complete frame.
pub(crate) struct Frame<'i> {
    pub(crate) header: Header,
    pub(crate) whole: &'i [u8],
    pub(crate) body: &'i [u8],
}

impl<'i> Frame<'i> {
    /// Reads the handshake frame of at most `max` bytes at the beginning of `input`, or returns
    /// `None` if the frame is incomplete.
    pub(crate) fn read(input: &'i [u8], max: usize) -> Result<Option<Self>, ProtocolError> {
        let header = Header::read(input, max, max)?;
        Ok(header.and_then(|header| Self::split(input, header)))
    }

    /// Returns the frame at the beginning of `input`, or `None` if the frame is incomplete. The
    /// caller has already decoded the `header` of the frame.
    pub(crate) fn split(input: &'i [u8], header: Header) -> Option<Self> {
        let whole = input.get(..header.bytes + header.length)?;
        Some(Self { body: &whole[header.bytes..], header, whole })
    }
}

/// Appends `body` to `output` as the last frame of a message.
pub fn push_last_frame(output: &mut Vec<u8>, body: &[u8]) {
    push_frame(output, 0, body);
}

/// Appends a request to `output`: the empty delimiter frame and the frames of the body. Without
/// frames, the body is one empty frame.
pub fn push_request(output: &mut Vec<u8>, frames: &[&[u8]]) {
    push_frame(output, MORE, &[]);
    let Some((last, others)) = frames.split_last() else { return push_last_frame(output, &[]) };
    for frame in others {
        push_frame(output, MORE, frame);
    }
    push_last_frame(output, last);
}

/// Appends a PONG command with `context` to `output`.
pub fn push_pong(output: &mut Vec<u8>, context: &[u8]) {
    push_frame(output, COMMAND, &[b"\x04PONG", context].concat());
}

fn push_frame(output: &mut Vec<u8>, flags: u8, body: &[u8]) {
    if let Ok(length) = u8::try_from(body.len()) {
        output.extend_from_slice(&[flags, length]);
    } else {
        output.push(flags | LONG);
        output.extend_from_slice(&(body.len() as u64).to_be_bytes());
    }
    output.extend_from_slice(body);
}

/// Returns the socket type from the properties of a READY command.
pub(crate) fn socket_type(mut properties: &[u8]) -> Result<&[u8], ProtocolError> {
    let mut socket_type = None;
    while !properties.is_empty() {
        let (name, value, rest) = split_property(properties).ok_or(ProtocolError::Ready)?;
        if name.eq_ignore_ascii_case(b"Socket-Type") {
            socket_type = Some(value);
        }
        properties = rest;
    }
    socket_type.ok_or(ProtocolError::Ready)
}

/// Returns the name of the first property, its value, and the bytes after the property.
fn split_property(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (&length, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(length.into())?;
    let (length, rest) = rest.split_first_chunk()?;
    let (value, rest) = rest.split_at_checked(u32::from_be_bytes(*length).try_into().ok()?)?;
    Some((name, value, rest))
}

/// Decodes a command received after the handshake. Unknown commands are ignored.
pub(crate) fn decode_command(body: &[u8]) -> Result<Event<'_>, ProtocolError> {
    let (&length, rest) = body.split_first().ok_or(ProtocolError::Command)?;
    let (name, rest) = rest.split_at_checked(length.into()).ok_or(ProtocolError::Command)?;
    match name {
        b"" => Err(ProtocolError::Command),
        b"ERROR" => Err(ProtocolError::Error),
        // The data consists of a time to live (two bytes) and the context.
        b"PING" => {
            let context = rest.get(2..).ok_or(ProtocolError::Command)?;
            Ok(Event::Ping { context: &context[..context.len().min(MAX_CONTEXT_BYTES)] })
        }
        _ => Ok(Event::Ignored),
    }
}
