//! Frames: flags, a length in 1 or 8 bytes, a body.

use super::Violation;

/// Another frame of the same message follows.
const MORE: u8 = 1;
/// The length has 8 bytes instead of one.
const LONG: u8 = 2;
/// The frame is a command to the socket, not a part of a message.
pub(crate) const COMMAND: u8 = 4;

/// What a frame begins with.
#[derive(Debug)]
pub(crate) struct Head {
    flags: u8,
    /// How many bytes this is itself.
    pub(crate) bytes: usize,
    /// How many bytes the body has.
    pub(crate) length: usize,
}

impl Head {
    /// Reads the head at the front, if all of it is there. `max` returns the longest body in bytes of
    /// a command (`true`) or of any other frame.
    pub(crate) fn read(
        input: &[u8],
        max: impl FnOnce(bool) -> usize,
    ) -> Result<Option<Self>, Violation> {
        let Some((&flags, rest)) = input.split_first() else { return Ok(None) };
        if flags > (MORE | LONG | COMMAND) || flags & (MORE | COMMAND) == (MORE | COMMAND) {
            return Err(Violation::Flags(flags));
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
        let length = length.ok_or(Violation::FrameTooLong { max, found })?;
        Ok(Some(Self { flags, bytes, length }))
    }

    pub(crate) const fn more(&self) -> bool {
        self.flags & MORE != 0
    }

    pub(crate) const fn is_command(&self) -> bool {
        self.flags & COMMAND != 0
    }
}

/// A frame at the front of what has been received.
pub(crate) struct Frame<'i> {
    head: Head,
    pub(crate) whole: &'i [u8],
    pub(crate) body: &'i [u8],
}

impl<'i> Frame<'i> {
    /// The frame that begins with this head, if all of it is there.
    pub(crate) fn split(input: &'i [u8], head: Head) -> Option<Self> {
        let whole = input.get(..head.bytes + head.length)?;
        Some(Self { body: &whole[head.bytes..], head, whole })
    }

    pub(crate) const fn more(&self) -> bool {
        self.head.more()
    }

    pub(crate) const fn is_command(&self) -> bool {
        self.head.is_command()
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
