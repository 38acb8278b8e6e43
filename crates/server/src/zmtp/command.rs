//! Commands to the socket: a name and what follows it.

use super::frame::COMMAND;
use super::{Step, Violation};

/// The kind of socket that a READY command tells.
pub(super) fn socket_type(mut properties: &[u8]) -> Result<&[u8], Violation> {
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
pub(super) fn command(body: &[u8]) -> Result<Step<'_>, Violation> {
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

/// Adds the answer to a ping.
pub(crate) fn push_pong(output: &mut Vec<u8>, context: &[u8]) {
    const NAME: &[u8] = b"\x04PONG";
    // A context has at most 16 bytes.
    let length = u8::try_from(NAME.len() + context.len()).unwrap_or(u8::MAX);
    output.extend_from_slice(&[COMMAND, length]);
    output.extend_from_slice(NAME);
    output.extend_from_slice(context);
}
