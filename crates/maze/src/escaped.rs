//! Display of counts, and safe display of untrusted text and bytes, in messages.

use core::array::from_fn;
use core::fmt::{self, Display, Formatter, Write};

/// Untrusted text, such as a file name, displayed on one line. Control characters and characters
/// that change the text direction are written as Rust escape sequences, so that the text cannot
/// control a terminal.
///
/// All other characters, including the backslash, are unchanged, so escaping a text twice gives the
/// same result as escaping it once.
///
/// ```
/// use mmsim_maze::Escaped;
/// assert_eq!(Escaped("ä\n\u{1b}[2J.txt").to_string(), r"ä\n\u{1b}[2J.txt");
/// ```
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct Escaped<T>(pub T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(Escaping(f), "{}", self.0)
    }
}

struct Escaping<'a, 'b>(&'a mut Formatter<'b>);

impl Write for Escaping<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars().try_for_each(|c| match c {
            _ if !needs_escape(c) => self.0.write_char(c),
            _ => write!(self.0, "{}", c.escape_default()),
        })
    }
}

/// Returns true if [`Escaped`] escapes the character `c`.
pub fn needs_escape(c: char) -> bool {
    let ends_line = matches!(c, '\u{2028}' | '\u{2029}');
    // The marks, embeddings, overrides and isolates of the Unicode bidirectional algorithm.
    let turns_text = matches!(
        c,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    c.is_control() || ends_line || turns_text
}

/// The first `MAX` bytes of a message, displayed as a quoted ASCII string with escape sequences. If
/// the message is longer than `MAX` bytes, its length is displayed as well.
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
    /// Copies the first `MAX` bytes of `message`.
    pub fn new(message: &[u8]) -> Self {
        let start = from_fn(|at| message.get(at).copied().unwrap_or(0));
        Self { start, length: message.len() }
    }
}

impl<const MAX: usize> fmt::Display for Excerpt<MAX> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.start.get(..self.length) {
            Some([]) => f.write_str("an empty message"),
            Some(all) => write!(f, "\"{}\"", all.escape_ascii()),
            None => write!(f, "\"{}\"… of {} bytes", self.start.escape_ascii(), self.length),
        }
    }
}

impl<const MAX: usize> fmt::Debug for Excerpt<MAX> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Returns a count with its noun, such as `2 steps`. A count other than 1 adds an `s` to the noun.
///
/// ```
/// use mmsim_maze::counted;
/// assert_eq!(counted(1_u8, "step").to_string(), "1 step");
/// assert_eq!(format!("{} in {}", counted(2_usize, "step"), counted(0_u64, "maze")), "2 steps in 0 mazes");
/// ```
pub fn counted(count: impl TryInto<u64>, noun: &str) -> Counted<'_> {
    Counted { count: count.try_into().unwrap_or(u64::MAX), noun }
}

/// A count with its noun. See [`counted`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub struct Counted<'n> {
    count: u64,
    noun: &'n str,
}

impl Display for Counted<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let ending = if self.count == 1 { "" } else { "s" };
        write!(f, "{} {}{ending}", self.count, self.noun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        let text = |count: u64| counted(count, "turn").to_string();
        assert_eq!(
            [0, 1, 2, u64::MAX].map(text),
            ["0 turns", "1 turn", "2 turns", "18446744073709551615 turns"]
        );
    }

    #[test]
    fn terminal_controls_are_escaped() {
        let text = "\0\u{7}\t\n\r\u{1b}[2J\u{7f}\u{85}\u{9b}31m\u{2028}\u{202e}\u{2066}\u{200f}";
        let escaped = Escaped(text).to_string();
        insta::assert_snapshot!(escaped, @r"\u{0}\u{7}\t\n\r\u{1b}[2J\u{7f}\u{85}\u{9b}31m\u{2028}\u{202e}\u{2066}\u{200f}");
        assert_eq!(Escaped(&escaped).to_string(), escaped);
    }

    #[test]
    fn only_controls_line_ends_and_marks_of_direction_are_escaped() {
        let is_mark = |&c: &char| needs_escape(c) && !c.is_control();
        let marks: String = ('\0'..=char::MAX).filter(is_mark).collect();
        assert_eq!(
            marks,
            "\u{61c}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\
             \u{2066}\u{2067}\u{2068}\u{2069}"
        );
        assert!(needs_escape('\n') && needs_escape('\u{7f}') && !needs_escape(' '));
    }

    #[test]
    fn excerpts_have_the_length_of_a_longer_message() {
        let excerpt = |message: &[u8]| Excerpt::<3>::new(message).to_string();
        assert_eq!(excerpt(b""), "an empty message");
        assert_eq!(excerpt(b"a\"\0"), r#""a\"\x00""#);
        assert_eq!(excerpt(b"abcd"), r#""abc"… of 4 bytes"#);
        assert_eq!(format!("{:?}", Excerpt::<3>::new(b"ab")), r#""ab""#);
    }

    #[test]
    fn ordinary_text_is_unchanged() {
        let text = "\"ä\" \\ 'ß' 全日本\u{3000}2013 👩\u{200d}💻 e\u{301}";
        assert_eq!(Escaped(text).to_string(), text);
    }
}
