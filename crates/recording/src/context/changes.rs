//! The bytes of changes to notes.
//!
//! ```text
//! changes  the following entries in this order, each at most once except L
//! M, S, t  as in annotations
//! T n …    n changed texts, each as skip and value; a value 0 precedes the length of the text (1
//!          byte) and the text, and any other value v means the number b + d, where v - 1 is d in
//!          zigzag encoding, and b is the number that the cell displayed before, or else the
//!          previous number in these changes, or else 0
//! c        as in annotations
//! C n …    n changed colours, each as skip and letter; - clears the colour
//! d        as in annotations
//! D n …    n changed declared walls, each as skip and 1, 0, ? or -
//! r        the mouse was put back at its start
//! L        as in annotations
//! ```
//!
//! `n`, skip and value are LEB128 numbers: seven bits per byte, lowest bits first; the high bit is
//! set in every byte except the last. Texts and colours are numbered row by row from the south, and
//! declared walls are the north wall and the east wall of each cell. A skip is the number of
//! unchanged cells or walls since the previous change.

use mmsim_maze::{Excerpt, MazeSize, WallState, needs_escape};
use mmsim_protocol::{
    Annotation, Colour, MAX_LOG_BYTES, MAX_NAME_BYTES, MAX_TEXT_BYTES, MAX_TEXT_CHARS,
    colour_from_letter, wall_from_letter,
};

use crate::context::update::Events;

/// A change of one cell or wall, or an annotation that does not belong to a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change<'a> {
    Text { cell: usize, text: NewText<'a> },
    Colour { cell: usize, colour: Option<Colour> },
    Wall { wall: usize, state: Option<WallState> },
    Other(Annotation<'a>),
}

/// The new text of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NewText<'a> {
    Text(&'a str),
    /// A number, as the difference from another number.
    Difference(u32),
}

/// The letters of lists. The same letter in lower case clears all values of the list.
pub(crate) const TEXTS: u8 = b'T';
pub(crate) const COLOURS: u8 = b'C';
pub(crate) const WALLS: u8 = b'D';

/// The letters of the names of the mouse and its strategy.
pub(crate) const MOUSE: u8 = b'M';
pub(crate) const STRATEGY: u8 = b'S';

/// The letter of a log line.
const LINE: u8 = b'L';

/// The letters of all entries in their order. Only log lines can be repeated.
const ORDER: &[u8] = &[MOUSE, STRATEGY, b't', TEXTS, b'c', COLOURS, b'd', WALLS, b'r', LINE];

/// Changes that have been checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Changes<'a> {
    bytes: &'a [u8],
    size: MazeSize,
}

impl<'a> Changes<'a> {
    /// Creates an empty list of changes.
    pub(crate) const fn none(size: MazeSize) -> Self {
        Self { bytes: &[], size }
    }

    /// Checks the bytes of changes. The error states what was expected and found.
    pub(crate) fn decode(bytes: &'a [u8], size: MazeSize) -> Result<Self, String> {
        let mut reader = Reader::new(bytes, size);
        while reader.take()?.is_some() {}
        Ok(Self { bytes, size })
    }

    /// Returns the changes that are not changes of notes.
    pub(crate) fn events(self) -> Events {
        self.iter().fold(Events::default(), |events, change| match change {
            Change::Other(Annotation::Restart) => Events { has_restart: true, ..events },
            Change::Other(Annotation::Log(_)) => Events { lines: events.lines + 1, ..events },
            _ => events,
        })
    }

    /// Iterates over the changes in order.
    pub(crate) fn iter(self) -> impl Iterator<Item = Change<'a>> {
        let mut reader = Reader::new(self.bytes, self.size);
        std::iter::from_fn(move || reader.take().ok().flatten())
    }
}

struct Reader<'a> {
    rest: &'a [u8],
    area: usize,
    /// The letters of the entries that may follow.
    letters: &'static [u8],
    /// The letter of the current list.
    list: u8,
    /// The number of changes that remain in the current list.
    remaining: u64,
    /// The number of the next cell or wall in the current list.
    next: usize,
}

impl<'a> Reader<'a> {
    const fn new(bytes: &'a [u8], size: MazeSize) -> Self {
        Self { rest: bytes, area: size.area(), letters: ORDER, list: TEXTS, remaining: 0, next: 0 }
    }

    /// Returns the next change, or `None` at the end.
    fn take(&mut self) -> Result<Option<Change<'a>>, String> {
        while self.remaining == 0 {
            let start = self.rest;
            let Some((&letter, rest)) = self.rest.split_first() else { return Ok(None) };
            self.rest = rest;
            self.letters = after(letter, self.letters).ok_or_else(|| invalid(start))?;
            let annotation = match letter {
                TEXTS | COLOURS | WALLS => {
                    let count = take_number(&mut self.rest).ok_or_else(|| invalid(start))?;
                    (self.list, self.remaining, self.next) = (letter, count, 0);
                    continue;
                }
                b'r' => Some(Annotation::Restart),
                b't' => Some(Annotation::ClearTexts),
                b'c' => Some(Annotation::ClearColours),
                b'd' => Some(Annotation::ClearWalls),
                LINE => self.take_line().map(Annotation::Log),
                MOUSE => self.take_text(MAX_NAME_BYTES).map(Annotation::Mouse),
                STRATEGY => self.take_text(MAX_NAME_BYTES).map(Annotation::Strategy),
                _ => None,
            };
            return annotation.map(|it| Some(Change::Other(it))).ok_or_else(|| invalid(start));
        }
        let start = self.rest;
        self.remaining -= 1;
        self.take_in_list().map(Some).ok_or_else(|| invalid(start))
    }

    fn take_in_list(&mut self) -> Option<Change<'a>> {
        let skip = usize::try_from(take_number(&mut self.rest)?).ok()?;
        let index = self.next.checked_add(skip)?;
        let count = if self.list == WALLS { 2 * self.area } else { self.area };
        self.next = (index < count).then_some(index + 1)?;
        if self.list == TEXTS {
            let text = match take_number(&mut self.rest)? {
                0 => NewText::Text(
                    self.take_text(MAX_TEXT_BYTES)
                        .filter(|text| text.chars().count() <= MAX_TEXT_CHARS)?,
                ),
                value => NewText::Difference(from_zigzag(u32::try_from(value - 1).ok()?)),
            };
            return Some(Change::Text { cell: index, text });
        }
        let (&value, rest) = self.rest.split_first()?;
        self.rest = rest;
        if self.list == COLOURS {
            return Some(Change::Colour { cell: index, colour: colour_from_letter(value)? });
        }
        Some(Change::Wall { wall: index, state: wall_from_letter(value)? })
    }

    /// Takes a text after its length in one byte.
    fn take_text(&mut self, max: usize) -> Option<&'a str> {
        let (&length, rest) = self.rest.split_first()?;
        self.rest = rest;
        self.take_chars(length.into(), max, |c| !needs_escape(c))
    }

    /// Takes a log line after its length in two bytes.
    fn take_line(&mut self) -> Option<&'a str> {
        let (length, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        let is_allowed = |c| c == '\t' || !needs_escape(c);
        self.take_chars(u16::from_le_bytes(*length).into(), MAX_LOG_BYTES, is_allowed)
    }

    fn take_chars(
        &mut self,
        length: usize,
        max: usize,
        is_allowed: impl Fn(char) -> bool,
    ) -> Option<&'a str> {
        let (text, rest) = self.rest.split_at_checked(length).filter(|_| length <= max)?;
        self.rest = rest;
        str::from_utf8(text).ok().filter(|text| text.chars().all(is_allowed))
    }
}

/// Returns those of the letters that may follow an entry, or `None` if its letter is not one of
/// them.
fn after(letter: u8, letters: &'static [u8]) -> Option<&'static [u8]> {
    let at = letters.iter().position(|&other| other == letter)?;
    letters.get(if letter == LINE { at } else { at + 1 }..)
}

fn invalid(bytes: &[u8]) -> String {
    format!("expected a change of annotations, found {}", Excerpt::<16>::new(bytes))
}

/// Takes a LEB128 number of at most 35 bits.
fn take_number(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..35).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        number |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

/// Appends a LEB128 number.
pub(crate) fn put_number(to: &mut Vec<u8>, mut number: u64) {
    while number > 0x7f {
        let [low, ..] = number.to_le_bytes();
        to.push(low | 0x80);
        number >>= 7;
    }
    let [low, ..] = number.to_le_bytes();
    to.push(low);
}

const fn to_zigzag(difference: u32) -> u32 {
    difference << 1 ^ 0_u32.wrapping_sub(difference >> 31)
}

const fn from_zigzag(zigzag: u32) -> u32 {
    zigzag >> 1 ^ 0_u32.wrapping_sub(zigzag & 1)
}

/// Appends changes. The changes of texts, colours and walls form lists.
pub(crate) struct ChangeWriter<'t> {
    to: &'t mut Vec<u8>,
    next: usize,
}

impl<'t> ChangeWriter<'t> {
    pub(crate) const fn new(to: &'t mut Vec<u8>) -> Self {
        Self { to, next: 0 }
    }

    /// Begins a list of `count` changes of texts, colours or walls.
    pub(crate) fn begin(&mut self, list: u8, count: usize) {
        self.to.push(list);
        put_number(self.to, count as u64);
        self.next = 0;
    }

    /// Clears all values of a list.
    pub(crate) fn clear(&mut self, list: u8) {
        self.to.push(list.to_ascii_lowercase());
    }

    fn skip_to(&mut self, index: usize) {
        put_number(self.to, (index - self.next) as u64);
        self.next = index + 1;
    }

    pub(crate) fn text(&mut self, cell: usize, text: NewText<'_>) {
        self.skip_to(cell);
        match text {
            NewText::Difference(difference) => {
                put_number(self.to, u64::from(to_zigzag(difference)) + 1);
            }
            NewText::Text(text) => {
                put_number(self.to, 0);
                self.short_text(text);
            }
        }
    }

    /// Appends the letter of a new colour or of the new state of a wall.
    pub(crate) fn value(&mut self, index: usize, letter: u8) {
        self.skip_to(index);
        self.to.push(letter);
    }

    /// Appends a new name of the mouse or of its strategy.
    pub(crate) fn name(&mut self, letter: u8, name: &str) {
        self.to.push(letter);
        self.short_text(name);
    }

    pub(crate) fn restart(&mut self) {
        self.to.push(b'r');
    }

    pub(crate) fn line(&mut self, line: &str) {
        self.to.push(LINE);
        // The length fits, because annotations limit it.
        self.to.extend(u16::try_from(line.len()).unwrap_or_default().to_le_bytes());
        self.to.extend_from_slice(line.as_bytes());
    }

    fn short_text(&mut self, text: &str) {
        // The length fits, because annotations limit it.
        self.to.push(u8::try_from(text.len()).unwrap_or_default());
        self.to.extend_from_slice(text.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use mmsim_protocol::{colour_letter, wall_letter};
    use proptest::prelude::*;

    use super::*;

    fn size() -> MazeSize {
        MazeSize::new(3, 2).unwrap()
    }

    #[test]
    fn changes_have_the_documented_bytes() {
        let mut bytes = Vec::new();
        let mut writer = ChangeWriter::new(&mut bytes);
        writer.name(MOUSE, "Theseus");
        writer.name(STRATEGY, "swing");
        writer.clear(TEXTS);
        writer.begin(TEXTS, 3);
        writer.text(1, NewText::Difference(16));
        writer.text(2, NewText::Difference(200_u32.wrapping_neg()));
        writer.text(5, NewText::Text("\u{221e}"));
        writer.clear(COLOURS);
        writer.begin(COLOURS, 1);
        writer.value(5, colour_letter(Some(Colour::DarkGreen)));
        writer.clear(WALLS);
        writer.begin(WALLS, 2);
        writer.value(0, wall_letter(None));
        writer.value(11, wall_letter(Some(WallState::Unknown)));
        writer.restart();
        writer.line("a\tb");
        let expected =
            b"M\x07TheseusS\x05swingtT\x03\x01\x21\0\x90\x03\x02\0\x03\xe2\x88\x9ecC\x01\x05G\
            dD\x02\0-\x0a?rL\x03\0a\tb";
        assert_eq!(bytes, expected);
        let changes: Vec<_> = Changes::decode(&bytes, size()).unwrap().iter().collect();
        let text = |cell, text| Change::Text { cell, text };
        assert_eq!(
            changes,
            [
                Change::Other(Annotation::Mouse("Theseus")),
                Change::Other(Annotation::Strategy("swing")),
                Change::Other(Annotation::ClearTexts),
                text(1, NewText::Difference(16)),
                text(2, NewText::Difference(200_u32.wrapping_neg())),
                text(5, NewText::Text("\u{221e}")),
                Change::Other(Annotation::ClearColours),
                Change::Colour { cell: 5, colour: Some(Colour::DarkGreen) },
                Change::Other(Annotation::ClearWalls),
                Change::Wall { wall: 0, state: None },
                Change::Wall { wall: 11, state: Some(WallState::Unknown) },
                Change::Other(Annotation::Restart),
                Change::Other(Annotation::Log("a\tb")),
            ]
        );
    }

    #[test]
    fn malformed_changes_are_errors() {
        let error = |bytes: &[u8]| Changes::decode(bytes, size()).unwrap_err();
        insta::assert_snapshot!(error(b"X"), @r#"expected a change of annotations, found "X""#);
        insta::assert_snapshot!(error(b"C\x01\x06g"), @r#"expected a change of annotations, found "\x06g""#);
        insta::assert_snapshot!(error(b"D\x02\x0b1\x001"), @r#"expected a change of annotations, found "\x001""#);
        insta::assert_snapshot!(error(b"T\x01\0\0\x02a\n"), @r#"expected a change of annotations, found "\x00\x00\x02a\n""#);
        insta::assert_snapshot!(error(b"T\x01\0\0\x0b12345678901"), @r#"expected a change of annotations, found "\x00\x00\x0b12345678901""#);
        insta::assert_snapshot!(error(b"C\xff\xff\xff\xff\xff\0"), @r#"expected a change of annotations, found "C\xff\xff\xff\xff\xff\x00""#);
        insta::assert_snapshot!(error(b"cC\x01\0gcC\x01\0g"), @r#"expected a change of annotations, found "cC\x01\x00g""#);
        insta::assert_snapshot!(error(b"T\0T\0"), @r#"expected a change of annotations, found "T\x00""#);
        insta::assert_snapshot!(error(b"L\0\0L\0\0r"), @r#"expected a change of annotations, found "r""#);
        insta::assert_snapshot!(error(b"M\x02a"), @r#"expected a change of annotations, found "M\x02a""#);
    }

    proptest! {
        #[test]
        fn numbers_survive_a_round_trip(difference in any::<u32>(), number in 0u64..1 << 35) {
            prop_assert_eq!(from_zigzag(to_zigzag(difference)), difference);
            let mut bytes = Vec::new();
            put_number(&mut bytes, number);
            prop_assert_eq!(take_number(&mut &*bytes), Some(number));
        }

        #[test]
        fn any_bytes_are_changes_or_an_error(bytes in prop::collection::vec(
            prop_oneof![prop::sample::select(b"TCDLMStcd-1g\x00\x01\x02".to_vec()), any::<u8>()],
            0..40,
        )) {
            if let Err(error) = Changes::decode(&bytes, size()) {
                prop_assert!(error.starts_with("expected ") && !error.contains('\n'));
            }
        }
    }
}
