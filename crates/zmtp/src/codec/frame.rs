//! ZMTP frames: flags, a length of 1 or 8 bytes, a body.

use crate::codec::error::ProtocolError;

/// Another frame of the same message follows.
const MORE: u8 = 1;
/// The length has 8 bytes instead of 1.
const LONG: u8 = 2;
/// The frame is a command, not part of a message.
pub(crate) const COMMAND: u8 = 4;

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
    /// Reads the header at the front, or returns `None` if it is incomplete. `max` returns the maximum
    /// length in bytes of the body of a command (`true`) or of any other frame (`false`).
    pub(crate) fn read(
        input: &[u8],
        max: impl FnOnce(bool) -> usize,
    ) -> Result<Option<Self>, ProtocolError> {
        let Some((&flags, rest)) = input.split_first() else { return Ok(None) };
        if flags > (MORE | LONG | COMMAND) || flags & (MORE | COMMAND) == (MORE | COMMAND) {
            return Err(ProtocolError::Flags(flags));
        }
        let (found, bytes) = if flags & LONG == 0 {
            let Some(&length) = rest.first() else { return Ok(None) };
            (u64::from(length), 2)
        } else {
            let Some(length) = rest.first_chunk() else { return Ok(None) };
            (u64::from_be_bytes(*length), 9)
        };
        let max = max(flags & COMMAND != 0);
        let length = usize::try_from(found).ok().filter(|&length| length <= max);
        let length = length.ok_or(ProtocolError::FrameTooLong { max, found })?;
        Ok(Some(Self { flags, bytes, length }))
    }

    /// Returns whether another frame of the same message follows.
    pub(crate) const fn has_more(&self) -> bool {
        self.flags & MORE != 0
    }

    pub(crate) const fn is_command(&self) -> bool {
        self.flags & COMMAND != 0
    }
}

/// A complete frame at the front of the input.
pub(crate) struct Frame<'i> {
    header: Header,
    pub(crate) whole: &'i [u8],
    pub(crate) body: &'i [u8],
}

impl<'i> Frame<'i> {
    /// Returns the frame with this header, or `None` if it is incomplete.
    pub(crate) fn split(input: &'i [u8], header: Header) -> Option<Self> {
        let end = header.bytes.checked_add(header.length)?;
        let whole = input.get(..end)?;
        Some(Self { body: &whole[header.bytes..], header, whole })
    }

    /// Returns whether another frame of the same message follows.
    pub(crate) const fn has_more(&self) -> bool {
        self.header.has_more()
    }

    pub(crate) const fn is_command(&self) -> bool {
        self.header.is_command()
    }
}

/// Appends the last frame of a message.
pub fn push_last_frame(output: &mut Vec<u8>, body: &[u8]) {
    if let Ok(length) = u8::try_from(body.len()) {
        output.extend_from_slice(&[0, length]);
    } else {
        output.push(LONG);
        output.extend_from_slice(&(body.len() as u64).to_be_bytes());
    }
    output.extend_from_slice(body);
}
