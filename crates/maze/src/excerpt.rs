//! The start of a message, for errors.

use core::fmt;

/// The first `MAX` bytes of a message, displayed in quotes with escapes, and with the length of the
/// message if it is longer.
///
/// ```
/// use mmsim_maze::Excerpt;
/// assert_eq!(Excerpt::<8>::new(b"ping\n").to_string(), r#""ping\n""#);
/// assert_eq!(Excerpt::<8>::new(&[b'x'; 100]).to_string(), r#""xxxxxxxx"… of 100 bytes"#);
/// assert_eq!(Excerpt::<8>::new(b"").to_string(), "an empty message");
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Excerpt<const MAX: usize> {
    start: [u8; MAX],
    length: usize,
}

impl<const MAX: usize> Excerpt<MAX> {
    /// Copies the start of a message.
    pub fn new(message: &[u8]) -> Self {
        let mut start = [0; MAX];
        for (copy, byte) in start.iter_mut().zip(message) {
            *copy = *byte;
        }
        Self { start, length: message.len() }
    }
}

impl<const MAX: usize> fmt::Display for Excerpt<MAX> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.start.get(..self.length) {
            Some([]) => f.write_str("an empty message"),
            Some(all) => write!(f, "\"{}\"", all.escape_ascii()),
            None => write!(f, "\"{}\"… of {} bytes", self.start.escape_ascii(), self.length),
        }
    }
}

impl<const MAX: usize> fmt::Debug for Excerpt<MAX> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
