//! ZMTP commands: a name, followed by data.

use crate::codec::error::ProtocolError;
use crate::codec::event::Event;
use crate::codec::frame::COMMAND;

/// The maximum number of context bytes of a PING that the PONG returns.
const MAX_CONTEXT_BYTES: usize = 16;

/// Returns the socket type in the properties of a READY command.
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

/// Splits off the first property: its name, its value, and the remaining properties.
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
        // A time to live of two bytes, then the context.
        b"PING" => {
            let context = rest.get(2..).ok_or(ProtocolError::Command)?;
            Ok(Event::Ping { context: &context[..context.len().min(MAX_CONTEXT_BYTES)] })
        }
        _ => Ok(Event::Ignored),
    }
}

/// Appends a PONG command with this context.
pub fn push_pong(output: &mut Vec<u8>, context: &[u8]) {
    const NAME: &[u8] = b"\x04PONG";
    let context = &context[..context.len().min(MAX_CONTEXT_BYTES)];
    let length = u8::try_from(NAME.len() + context.len()).unwrap_or(u8::MAX);
    output.extend_from_slice(&[COMMAND, length]);
    output.extend_from_slice(NAME);
    output.extend_from_slice(context);
}
