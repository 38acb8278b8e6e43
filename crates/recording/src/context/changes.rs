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
use mmsim_protocol::{Annotation, Colour, MAX_TEXT_CHARS, colour_from_letter, wall_from_letter};

use crate::context::update::Events;

/// A change of one cell or wall, or an annotation that does not belong to a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change<'a> {
    Text {
        cell: usize,
        text: &'a str,
    },
    /// The new text of a cell is a number, given as the difference from another number.
    Number {
        cell: usize,
        difference: u32,
    },
    Colour {
        cell: usize,
        colour: Option<Colour>,
    },
    Wall {
        wall: usize,
        state: Option<WallState>,
    },
    Other(Annotation<'a>),
}

/// The letters of lists. The same letter in lower case clears all values of the list.
pub(crate) const TEXTS: u8 = b'T';
pub(crate) const COLOURS: u8 = b'C';
pub(crate) const WALLS: u8 = b'D';

/// The letters of the names of the mouse and its strategy.
pub(crate) const MOUSE: u8 = b'M';
pub(crate) const STRATEGY: u8 = b'S';

/// The letters of a restart and of a log line.
pub(crate) const RESTART: u8 = b'r';
const LINE: u8 = b'L';

/// The letters of all entries in their order. Only log lines can be repeated.
const ORDER: &[u8] = &[MOUSE, STRATEGY, b't', TEXTS, b'c', COLOURS, b'd', WALLS, RESTART, LINE];

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
            let Some(&letter) = start.first() else { return Ok(None) };
            self.letters = after(letter, self.letters).ok_or_else(|| invalid(start))?;
            if !matches!(letter, TEXTS | COLOURS | WALLS | RESTART) {
                let annotation = Annotation::take_first(&mut self.rest);
                return annotation.map(|it| it.map(Change::Other)).map_err(|_| invalid(start));
            }
            self.rest = &start[1..];
            if letter == RESTART {
                return Ok(Some(Change::Other(Annotation::Restart)));
            }
            let count = take_number(&mut self.rest).ok_or_else(|| invalid(start))?;
            (self.list, self.remaining, self.next) = (letter, count, 0);
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
            return Some(match take_number(&mut self.rest)? {
                0 => Change::Text { cell: index, text: self.take_text()? },
                value => {
                    let difference = from_zigzag(u32::try_from(value - 1).ok()?);
                    Change::Number { cell: index, difference }
                }
            });
        }
        let &letter = self.rest.split_off_first()?;
        Some(if self.list == COLOURS {
            Change::Colour { cell: index, colour: colour_from_letter(letter)? }
        } else {
            Change::Wall { wall: index, state: wall_from_letter(letter)? }
        })
    }

    /// Takes the text of a cell after its length in one byte.
    fn take_text(&mut self) -> Option<&'a str> {
        let &length = self.rest.split_off_first()?;
        let text = str::from_utf8(self.rest.split_off(..length.into())?).ok()?;
        let is_valid = text.chars().count() <= MAX_TEXT_CHARS && !text.chars().any(needs_escape);
        is_valid.then_some(text)
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
        let &byte = bytes.split_off_first()?;
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

/// Appends a list of changes with their cells or walls, unless it is empty. `put` appends the value of
/// a change.
pub(crate) fn put_list<C>(
    to: &mut Vec<u8>,
    list: u8,
    changes: impl Iterator<Item = (usize, C)> + Clone,
    mut put: impl FnMut(&mut Vec<u8>, C),
) {
    let count = changes.clone().count();
    if count > 0 {
        to.push(list);
        put_number(to, count as u64);
    }
    let mut next = 0;
    for (index, change) in changes {
        put_number(to, (index - next) as u64);
        next = index + 1;
        put(to, change);
    }
}

/// Appends the value of a text that becomes a number.
pub(crate) fn put_difference(to: &mut Vec<u8>, difference: u32) {
    put_number(to, u64::from(to_zigzag(difference)) + 1);
}

/// Appends a text after its length in one byte.
pub(crate) fn put_text(to: &mut Vec<u8>, text: &str) {
    // The length fits, because annotations limit it.
    to.push(u8::try_from(text.len()).unwrap_or_default());
    to.extend_from_slice(text.as_bytes());
}

/// Appends a log line.
pub(crate) fn put_line(to: &mut Vec<u8>, line: &str) {
    to.push(LINE);
    // The length fits, because annotations limit it.
    to.extend(u16::try_from(line.len()).unwrap_or_default().to_le_bytes());
    to.extend_from_slice(line.as_bytes());
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
        bytes.push(MOUSE);
        put_text(&mut bytes, "Theseus");
        bytes.push(STRATEGY);
        put_text(&mut bytes, "swing");
        bytes.push(b't');
        let texts = [(1, Ok(16)), (2, Ok(200_u32.wrapping_neg())), (5, Err("\u{221e}"))];
        put_list(&mut bytes, TEXTS, texts.into_iter(), |to, text| match text {
            Ok(difference) => put_difference(to, difference),
            Err(text) => {
                to.push(0);
                put_text(to, text);
            }
        });
        bytes.push(b'c');
        let colour = [(5, Some(Colour::DarkGreen))].into_iter();
        put_list(&mut bytes, COLOURS, colour, |to, colour| to.push(colour_letter(colour)));
        bytes.push(b'd');
        let walls = [(0, None), (11, Some(WallState::Unknown))].into_iter();
        put_list(&mut bytes, WALLS, walls, |to, state| to.push(wall_letter(state)));
        put_list(&mut bytes, WALLS, [].into_iter(), |to, state| to.push(wall_letter(state)));
        bytes.push(RESTART);
        put_line(&mut bytes, "a\tb");
        let expected =
            b"M\x07TheseusS\x05swingtT\x03\x01\x21\0\x90\x03\x02\0\x03\xe2\x88\x9ecC\x01\x05G\
            dD\x02\0-\x0a?rL\x03\0a\tb";
        assert_eq!(bytes, expected);
        let changes: Vec<_> = Changes::decode(&bytes, size()).unwrap().iter().collect();
        assert_eq!(
            changes,
            [
                Change::Other(Annotation::Mouse("Theseus")),
                Change::Other(Annotation::Strategy("swing")),
                Change::Other(Annotation::ClearTexts),
                Change::Number { cell: 1, difference: 16 },
                Change::Number { cell: 2, difference: 200_u32.wrapping_neg() },
                Change::Text { cell: 5, text: "\u{221e}" },
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
