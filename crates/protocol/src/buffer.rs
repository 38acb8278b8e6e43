//! Writes messages into the caller's buffer.

/// The error for a buffer that is too short for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a buffer of at least {expected} bytes, found {found}")]
pub struct BufferTooSmall {
    /// The length of the message in bytes.
    pub expected: usize,
    /// The length of the buffer in bytes.
    pub found: usize,
}

/// Returns the first `length` bytes of the buffer.
pub(crate) fn front_of(buffer: &mut [u8], length: usize) -> Result<&mut [u8], BufferTooSmall> {
    let found = buffer.len();
    buffer.get_mut(..length).ok_or(BufferTooSmall { expected: length, found })
}

/// Copies a message into the buffer and returns the length of the message.
pub(crate) fn write_bytes(buffer: &mut [u8], message: &[u8]) -> Result<usize, BufferTooSmall> {
    front_of(buffer, message.len())?.copy_from_slice(message);
    Ok(message.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_fill_the_front_of_the_buffer() {
        let mut buffer = [9; 4];
        assert_eq!(front_of(&mut buffer, 0), Ok(&mut [][..]));
        assert_eq!(front_of(&mut buffer, 4), Ok(&mut [9; 4][..]));
        assert_eq!(write_bytes(&mut buffer, b"ab"), Ok(2));
        assert_eq!(buffer, [b'a', b'b', 9, 9]);
        let error = write_bytes(&mut buffer, b"abcde").unwrap_err();
        assert_eq!(error, BufferTooSmall { expected: 5, found: 4 });
        insta::assert_snapshot!(error, @"expected a buffer of at least 5 bytes, found 4");
        assert_eq!(buffer, [b'a', b'b', 9, 9]);
    }
}
