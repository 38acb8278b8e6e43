//! Annotations: texts, colours, walls and log lines that a mouse displays with its next state.
//!
//! ```text
//! A entry …           a request of at most MAX_ANNOTATIONS_BYTES bytes with at least one entry
//!   T x y n text      text of a cell: n bytes (at most 40), at most 10 characters; none clears it
//!   C x y colour      colour of a cell: a letter of mms, or - to clear it
//!   D x y heading w   declared wall: w is 1 present, 0 absent, ? unknown, - not declared
//!   L n n text        log line: n bytes (at most 1000, 16-bit little-endian)
//!   M n text          name of the mouse: n bytes (at most 100)
//!   S n text          name of its strategy: n bytes (at most 100)
//!   R                 the mouse was put back at its start
//!   t, c, d           clears all texts, colours, declared walls
//! ```
//!
//! A character is a Unicode code point. All characters are printable except control characters,
//! line and paragraph separators, and marks that change the direction of text (see
//! [`needs_escape`](mmsim_maze::needs_escape)).

use mmsim_maze::{Cell, Colour, Excerpt, Heading, MazeSize, WallState, needs_escape};

use crate::error::RequestError;
use crate::layout::MAX_ANNOTATIONS_BYTES;

/// The maximum number of characters in the text of a cell.
pub const MAX_TEXT_CHARS: usize = 10;

/// The maximum length of a log line in bytes.
pub const MAX_LOG_BYTES: usize = 1000;

/// The maximum length of the name of a mouse or strategy in bytes.
pub const MAX_NAME_BYTES: usize = 100;

/// The maximum length of the text of a cell in bytes. A character takes up to four bytes.
pub const MAX_TEXT_BYTES: usize = 4 * MAX_TEXT_CHARS;

/// The maximum length of an annotation in a request: the letter, the length and a log line.
pub(crate) const MAX_ENTRY_BYTES: usize = 3 + MAX_LOG_BYTES;

/// Something that a mouse displays in addition to its states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Annotation<'a> {
    /// Sets the text of a cell, or clears it if the text is empty.
    Text {
        /// The cell.
        cell: Cell,
        /// At most [`MAX_TEXT_CHARS`] characters, all of them printable.
        text: &'a str,
    },
    /// Sets or clears the colour of a cell.
    Colour {
        /// The cell.
        cell: Cell,
        /// The colour, or `None` to clear it.
        colour: Option<Colour>,
    },
    /// Declares what the mouse knows about a wall, whatever the flags in its states say.
    Wall {
        /// The cell.
        cell: Cell,
        /// The side of the cell.
        heading: Heading,
        /// The declaration, or `None` to withdraw it.
        state: Option<WallState>,
    },
    /// Logs a line of at most [`MAX_LOG_BYTES`] bytes of tabs and printable characters.
    Log(&'a str),
    /// Names the mouse, in at most [`MAX_NAME_BYTES`] bytes of printable characters.
    Mouse(&'a str),
    /// Names the strategy, in at most [`MAX_NAME_BYTES`] bytes of printable characters.
    Strategy(&'a str),
    /// The mouse was put back at its start, and did not drive there.
    Restart,
    /// Clears all texts.
    ClearTexts,
    /// Clears all colours.
    ClearColours,
    /// Withdraws all declared walls.
    ClearWalls,
}

impl<'a> Annotation<'a> {
    /// Removes the first of these [`entries`](Annotations::entries), and decodes it. Returns `None` if
    /// there are no entries.
    ///
    /// # Errors
    /// Returns an error if the entry is invalid. Whether a cell is in the maze is not checked.
    ///
    /// ```
    /// use mmsim_protocol::Annotation;
    /// let mut entries: &[u8] = b"tL\x02\0hi";
    /// assert_eq!(Annotation::take_first(&mut entries)?, Some(Annotation::ClearTexts));
    /// assert_eq!(entries, b"L\x02\0hi");
    /// # Ok::<(), mmsim_protocol::RequestError>(())
    /// ```
    pub fn take_first(entries: &mut &'a [u8]) -> Result<Option<Self>, RequestError> {
        let mut parser = Entries { message: entries, offset: 0 };
        let annotation = parser.take()?;
        *entries = entries.get(parser.offset..).unwrap_or_default();
        Ok(annotation)
    }
}

/// A valid annotations request, which borrows the bytes of its message.
///
/// The annotations belong to the next state that the client sends. Texts, colours, declared walls
/// and names remain until they are changed or the simulation is reset.
///
/// ```
/// use mmsim_protocol::{Annotation, AnnotationWriter, Annotations, Cell, Colour, MazeSize};
/// let cell = Cell::new(3, 4);
/// let mut buffer = [0; 64];
/// let mut writer = AnnotationWriter::new(&mut buffer);
/// writer.push(Annotation::Text { cell, text: "1024" })?;
/// writer.push(Annotation::Colour { cell, colour: Some(Colour::Green) })?;
/// let message = writer.finish().expect("two annotations");
/// assert_eq!(message, b"AT\x03\x04\x041024C\x03\x04g");
/// let annotations = Annotations::decode(message, MazeSize::CLASSIC)?;
/// assert_eq!(annotations.iter().next(), Some(Annotation::Text { cell, text: "1024" }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Annotations<'a>(&'a [u8]);

impl<'a> Annotations<'a> {
    /// Decodes a request for a maze of this size.
    ///
    /// # Errors
    /// Returns an error if the request has no annotations, is longer than
    /// [`MAX_ANNOTATIONS_BYTES`] bytes, or has an invalid annotation.
    pub fn decode(message: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        if !(2..=MAX_ANNOTATIONS_BYTES).contains(&message.len()) || message[0] != b'A' {
            return Err(RequestError::AnnotationsLength { found: message.len() });
        }
        let mut entries = Entries { message, offset: 1 };
        while let Some(entry) = entries.take()? {
            match entry {
                Annotation::Text { cell, .. }
                | Annotation::Colour { cell, .. }
                | Annotation::Wall { cell, .. }
                    if !size.contains(cell) =>
                {
                    return Err(RequestError::Outside { cell, size });
                }
                _ => {}
            }
        }
        Ok(Self(message))
    }

    /// Returns the annotations in the order in which the client sent them.
    pub fn iter(&self) -> impl Iterator<Item = Annotation<'a>> + use<'a> {
        Self::iter_entries(self.entries())
    }

    /// Returns the bytes of the annotations, without the letter `A`.
    pub fn entries(&self) -> &'a [u8] {
        self.0.get(1..).unwrap_or_default()
    }

    /// Returns the annotations in these [`entries`](Self::entries), which may be those of several
    /// requests, one after the other. Stops at the first invalid annotation.
    pub fn iter_entries(entries: &'a [u8]) -> impl Iterator<Item = Annotation<'a>> + use<'a> {
        let mut entries = Entries { message: entries, offset: 0 };
        core::iter::from_fn(move || entries.take().ok().flatten())
    }

    /// Returns the bytes of the message.
    pub const fn as_bytes(&self) -> &'a [u8] {
        self.0
    }
}

/// Returns the letter of a colour in annotations: `-` clears a colour.
pub const fn colour_letter(colour: Option<Colour>) -> u8 {
    match colour {
        Some(colour) => colour.letter() as u8,
        None => b'-',
    }
}

/// Returns the colour with this letter in annotations, or `None` if the letter is invalid.
pub fn colour_from_letter(letter: u8) -> Option<Option<Colour>> {
    if letter == b'-' { Some(None) } else { Colour::from_letter(letter.into()).map(Some) }
}

/// Returns the letter of a declared wall in annotations: `-` withdraws the declaration.
pub const fn wall_letter(state: Option<WallState>) -> u8 {
    match state {
        Some(WallState::Present) => b'1',
        Some(WallState::Absent) => b'0',
        Some(WallState::Unknown) => b'?',
        None => b'-',
    }
}

/// Returns the declared wall with this letter in annotations, or `None` if the letter is invalid.
pub const fn wall_from_letter(letter: u8) -> Option<Option<WallState>> {
    Some(match letter {
        b'1' => Some(WallState::Present),
        b'0' => Some(WallState::Absent),
        b'?' => Some(WallState::Unknown),
        b'-' => None,
        _ => return None,
    })
}

/// A parser for the entries of a message, starting at a byte offset.
pub(crate) struct Entries<'a> {
    pub(crate) message: &'a [u8],
    pub(crate) offset: usize,
}

impl<'a> Entries<'a> {
    /// Decodes the next annotation. Returns `None` at the end of the message.
    pub(crate) fn take(&mut self) -> Result<Option<Annotation<'a>>, RequestError> {
        let Some(&kind) = self.message.get(self.offset) else { return Ok(None) };
        self.offset += 1;
        Ok(Some(match kind {
            b'T' => {
                let cell = self.cell()?;
                let [length] = self.bytes("the length of a text")?;
                let what = "a text of at most 10 printable characters in UTF-8";
                let text = self.text(length.into(), MAX_TEXT_BYTES, what, |c| !needs_escape(c))?;
                if text.chars().count() > MAX_TEXT_CHARS {
                    return Err(self.error_at(self.offset - text.len(), what));
                }
                Annotation::Text { cell, text }
            }
            b'C' => {
                let cell = self.cell()?;
                let what = "one of kbacgorwyBCAGORVY or - as the colour";
                let [letter] = self.bytes(what)?;
                let colour = colour_from_letter(letter)
                    .ok_or_else(|| self.error_at(self.offset - 1, what))?;
                Annotation::Colour { cell, colour }
            }
            b'D' => {
                let cell = self.cell()?;
                let [heading] = self.bytes("N, E, S or W as the side of a cell")?;
                let heading = Heading::from_letter(heading.into())
                    .ok_or(RequestError::Heading { found: heading })?;
                let what = "1, 0, ? or - as the declared wall";
                let [letter] = self.bytes(what)?;
                let state =
                    wall_from_letter(letter).ok_or_else(|| self.error_at(self.offset - 1, what))?;
                Annotation::Wall { cell, heading, state }
            }
            b'L' => {
                let length = u16::from_le_bytes(self.bytes("the length of a log line")?);
                let what =
                    "a log line of at most 1000 bytes of tabs and printable characters in UTF-8";
                let is_allowed = |c| c == '\t' || !needs_escape(c);
                Annotation::Log(self.text(length.into(), MAX_LOG_BYTES, what, is_allowed)?)
            }
            b'M' => Annotation::Mouse(self.name()?),
            b'S' => Annotation::Strategy(self.name()?),
            b'R' => Annotation::Restart,
            b't' => Annotation::ClearTexts,
            b'c' => Annotation::ClearColours,
            b'd' => Annotation::ClearWalls,
            _ => {
                return Err(self
                    .error_at(self.offset - 1, "an annotation (T, C, D, L, M, S, R, t, c or d)"));
            }
        }))
    }

    fn cell(&mut self) -> Result<Cell, RequestError> {
        self.bytes("x and y of a cell").map(|[x, y]| Cell::new(x, y))
    }

    fn name(&mut self) -> Result<&'a str, RequestError> {
        let [length] = self.bytes("the length of a name")?;
        let what = "a name of at most 100 bytes of printable characters in UTF-8";
        self.text(length.into(), MAX_NAME_BYTES, what, |c| !needs_escape(c))
    }

    fn bytes<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], RequestError> {
        let rest = self.message.get(self.offset..).and_then(<[u8]>::first_chunk);
        let bytes = *rest.ok_or_else(|| self.error_at(self.offset, expected))?;
        self.offset += N;
        Ok(bytes)
    }

    fn text(
        &mut self,
        length: usize,
        max: usize,
        expected: &'static str,
        is_allowed: impl Fn(char) -> bool,
    ) -> Result<&'a str, RequestError> {
        let rest = self.message.get(self.offset..).unwrap_or_default();
        let (offset, found) = (self.offset, rest.len());
        let bytes = rest.get(..length).ok_or(RequestError::TextEnd { offset, length, found })?;
        let text = core::str::from_utf8(bytes)
            .ok()
            .filter(|text| length <= max && text.chars().all(is_allowed))
            .ok_or_else(|| self.error_at(offset, expected))?;
        self.offset += length;
        Ok(text)
    }

    fn error_at(&self, offset: usize, expected: &'static str) -> RequestError {
        match self.message.get(offset..).unwrap_or_default() {
            [] => RequestError::AnnotationEnd { expected },
            rest => RequestError::Annotation { offset, expected, found: Excerpt::new(rest) },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::annotation_writer::AnnotationWriter;

    fn decode(message: &[u8]) -> Result<Vec<Annotation<'_>>, String> {
        let annotations = Annotations::decode(message, MazeSize::CLASSIC);
        annotations.map(|it| it.iter().collect()).map_err(|error| error.to_string())
    }

    fn error(message: &[u8]) -> String {
        decode(message).unwrap_err()
    }

    #[test]
    fn annotations_have_the_documented_bytes() {
        let cell = Cell::new(1, 2);
        let wall = |state| Annotation::Wall { cell, heading: Heading::West, state };
        for (annotation, bytes) in [
            (Annotation::Text { cell, text: "1024" }, &b"AT\x01\x02\x041024"[..]),
            (Annotation::Text { cell, text: "" }, b"AT\x01\x02\0"),
            (Annotation::Text { cell, text: "\u{221e}" }, b"AT\x01\x02\x03\xe2\x88\x9e"),
            (Annotation::Colour { cell, colour: Some(Colour::DarkGreen) }, b"AC\x01\x02G"),
            (Annotation::Colour { cell, colour: None }, b"AC\x01\x02-"),
            (wall(Some(WallState::Present)), b"AD\x01\x02W1"),
            (wall(Some(WallState::Absent)), b"AD\x01\x02W0"),
            (wall(Some(WallState::Unknown)), b"AD\x01\x02W?"),
            (wall(None), b"AD\x01\x02W-"),
            (Annotation::Log("a\tb"), b"AL\x03\0a\tb"),
            (Annotation::Mouse("Theseus"), b"AM\x07Theseus"),
            (Annotation::Strategy("flood fill"), b"AS\x0aflood fill"),
            (Annotation::Restart, b"AR"),
            (Annotation::ClearTexts, b"At"),
            (Annotation::ClearColours, b"Ac"),
            (Annotation::ClearWalls, b"Ad"),
        ] {
            let mut buffer = [0; 32];
            let mut writer = AnnotationWriter::new(&mut buffer);
            writer.push(annotation).unwrap();
            assert_eq!(writer.finish(), Some(bytes));
            assert_eq!(decode(bytes), Ok([annotation].into()));
        }
    }

    #[test]
    fn errors_say_expected_and_found() {
        insta::assert_snapshot!(error(b"A"), @"expected A and annotations (2 to 4096 bytes), found 1 bytes");
        insta::assert_snapshot!(error(&[b'A'; 4097]), @"expected A and annotations (2 to 4096 bytes), found 4097 bytes");
        insta::assert_snapshot!(error(b"AX"), @r#"expected an annotation (T, C, D, L, M, S, R, t, c or d), found "X" at byte 1"#);
        insta::assert_snapshot!(error(b"AtT\x01"), @r#"expected x and y of a cell, found "\x01" at byte 3"#);
        insta::assert_snapshot!(error(b"AT\x01\x02\x04102"), @"expected 4 bytes of text at byte 5, found 3");
        insta::assert_snapshot!(error(b"AT\x01\x02\x0b12345678901"), @r#"expected a text of at most 10 printable characters in UTF-8, found "12345678901" at byte 5"#);
        insta::assert_snapshot!(error(b"AT\x01\x02\x01\x1b"), @r#"expected a text of at most 10 printable characters in UTF-8, found "\x1b" at byte 5"#);
        insta::assert_snapshot!(error(b"AT\x01\x02\x01\xff"), @r#"expected a text of at most 10 printable characters in UTF-8, found "\xff" at byte 5"#);
        insta::assert_snapshot!(error(b"AT\x10\x02\x00"), @"expected a cell in a maze of 16x16 cells, found (16, 2)");
        insta::assert_snapshot!(error(b"AC\x01\x02x"), @r#"expected one of kbacgorwyBCAGORVY or - as the colour, found "x" at byte 4"#);
        insta::assert_snapshot!(error(b"AC\x01\x02"), @"expected one of kbacgorwyBCAGORVY or - as the colour, found the end of the message");
        insta::assert_snapshot!(error(b"AD\x01\x02n1"), @r#"expected N, E, S or W as the heading, found "n""#);
        insta::assert_snapshot!(error(b"AD\x01\x02N2"), @r#"expected 1, 0, ? or - as the declared wall, found "2" at byte 5"#);
        insta::assert_snapshot!(error(b"AL\x02\0a\n"), @r#"expected a log line of at most 1000 bytes of tabs and printable characters in UTF-8, found "a\n" at byte 4"#);
        insta::assert_snapshot!(error(b"AL\xff\xff"), @"expected 65535 bytes of text at byte 4, found 0");
        insta::assert_snapshot!(error(b"AM\x02a"), @"expected 2 bytes of text at byte 3, found 1");
        insta::assert_snapshot!(error(b"AM\x03\xe2\x80\x8f"), @r#"expected a name of at most 100 bytes of printable characters in UTF-8, found "\xe2\x80\x8f" at byte 3"#);
    }

    /// An annotation that owns its text.
    fn any_annotation() -> impl Strategy<Value = (u8, Cell, Heading, String, usize)> {
        let text = prop_oneof!["[0-9]{0,4}", "[^\\p{C}\\p{Zl}\\p{Zp}]{0,10}"];
        (0u8..10, 0u8..32, 0u8..32, 0usize..4, text, 0usize..16).prop_map(
            |(kind, x, y, heading, text, choice)| {
                (kind, Cell::new(x, y), Heading::ALL[heading], text, choice)
            },
        )
    }

    fn annotation(
        (kind, cell, heading, text, choice): &(u8, Cell, Heading, String, usize),
    ) -> Annotation<'_> {
        let (cell, heading) = (*cell, *heading);
        let walls = [WallState::Present, WallState::Absent, WallState::Unknown];
        match kind {
            0 => Annotation::Text { cell, text },
            1 => Annotation::Colour { cell, colour: Colour::ALL.get(*choice).copied() },
            2 => Annotation::Wall { cell, heading, state: walls.get(choice % 4).copied() },
            3 => Annotation::Log(text),
            4 => Annotation::Mouse(text),
            5 => Annotation::Strategy(text),
            6 => Annotation::ClearTexts,
            7 => Annotation::ClearColours,
            8 => Annotation::Restart,
            _ => Annotation::ClearWalls,
        }
    }

    proptest! {
        #[test]
        fn annotations_survive_a_round_trip(list in prop::collection::vec(any_annotation(), 1..60)) {
            let mut buffer = [0xa5; MAX_ANNOTATIONS_BYTES];
            let mut writer = AnnotationWriter::new(&mut buffer);
            for owned in &list {
                writer.push(annotation(owned)).unwrap();
            }
            let message = writer.finish().unwrap();
            let decoded = Annotations::decode(message, MazeSize::HALF_SIZE).unwrap();
            prop_assert!(decoded.iter().eq(list.iter().map(annotation)));
            let twice = decoded.entries().repeat(2);
            let expected = list.iter().chain(&list).map(annotation);
            prop_assert!(Annotations::iter_entries(&twice).eq(expected));
            // A request that ends in the middle of an annotation is invalid.
            let ends = ends(&list);
            for length in 2..message.len() {
                let is_complete = ends.contains(&length);
                let decoded = Annotations::decode(&message[..length], MazeSize::HALF_SIZE);
                prop_assert_eq!(decoded.is_ok(), is_complete);
            }
        }

        #[test]
        fn any_bytes_are_annotations_or_an_error(
            pieces in prop::collection::vec(
                prop_oneof![
                    prop::collection::vec(any::<u8>(), 0..8),
                    Just(b"T\0\0\x0212".to_vec()),
                    Just(b"C\0\0k".to_vec()),
                    Just(b"D\0\0N1".to_vec()),
                    Just(b"L\x01\0a".to_vec()),
                ],
                0..30,
            ),
        ) {
            let message = [b"A".to_vec(), pieces.concat()].concat();
            match Annotations::decode(&message, MazeSize::CLASSIC) {
                Ok(annotations) => {
                    let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
                    let mut writer = AnnotationWriter::new(&mut buffer);
                    for annotation in annotations.iter() {
                        writer.push(annotation).unwrap();
                    }
                    prop_assert_eq!(writer.finish(), Some(&message[..]));
                }
                Err(error) => {
                    let text = error.to_string();
                    prop_assert!(text.starts_with("expected ") && text.contains(", found "));
                    prop_assert!(!text.contains('\n') && text.len() < 200);
                }
            }
        }
    }

    /// Returns the positions at which the annotations end in their request.
    fn ends(list: &[(u8, Cell, Heading, String, usize)]) -> Vec<usize> {
        let mut end = 1;
        let mut next = |owned: &(u8, Cell, Heading, String, usize)| {
            let mut buffer = [0; MAX_ANNOTATIONS_BYTES];
            let mut writer = AnnotationWriter::new(&mut buffer);
            writer.push(annotation(owned)).unwrap();
            end += writer.finish().map_or(0, |message| message.len() - 1);
            end
        };
        list.iter().map(&mut next).collect()
    }
}
