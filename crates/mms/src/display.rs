//! The texts and colours that a mouse displays in the cells.

use std::fmt;

use mmsim_maze::{Cell, CellMap, Colour, MazeSize};

use crate::command::Command;

/// The text and colour of each cell. Equal displays look the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Display {
    size: MazeSize,
    texts: CellMap<CellText>,
    colours: CellMap<Option<Colour>>,
}

impl Display {
    /// Creates a display without texts and colours.
    pub(crate) const fn new(size: MazeSize) -> Self {
        Self { size, texts: CellMap::new(CellText::EMPTY), colours: CellMap::new(None) }
    }

    /// Returns the text of a cell, which is empty if the cell is outside the maze.
    pub fn text(&self, cell: Cell) -> &CellText {
        if self.size.contains(cell) { &self.texts[cell] } else { &CellText::EMPTY }
    }

    /// Returns the colour of a cell, or `None` if the cell has no colour.
    pub fn colour(&self, cell: Cell) -> Option<Colour> {
        self.size.contains(cell).then(|| self.colours[cell]).flatten()
    }

    /// Executes a command that changes texts or colours. Other commands, and cells outside the maze,
    /// have no effect.
    pub(crate) fn execute(&mut self, command: Command<'_>) {
        match command {
            Command::Text { cell, text } if self.size.contains(cell) => {
                self.texts[cell] = CellText::new(text);
            }
            Command::Colour { cell, colour } if self.size.contains(cell) => {
                self.colours[cell] = colour;
            }
            Command::ClearAllText => self.texts = CellMap::new(CellText::EMPTY),
            Command::ClearAllColours => self.colours = CellMap::new(None),
            _ => {}
        }
    }
}

/// The text of a cell as mms shows it: the first ten characters, where each character that is not
/// in the font of mms is a question mark.
///
/// The font contains the printable ASCII characters except the backslash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellText {
    ascii: [u8; Self::MAX_CHARS],
    length: u8,
}

impl CellText {
    /// The maximum number of characters.
    pub const MAX_CHARS: usize = 10;

    const EMPTY: Self = Self { ascii: [0; Self::MAX_CHARS], length: 0 };

    fn new(text: &[u8]) -> Self {
        let mut shown = Self::EMPTY;
        // A character takes at most four bytes.
        let start = &text[..text.len().min(4 * Self::MAX_CHARS)];
        for (place, c) in shown.ascii.iter_mut().zip(String::from_utf8_lossy(start).chars()) {
            let is_in_font = matches!(c, ' '..='~') && c != '\\';
            *place = u8::try_from(c).ok().filter(|_| is_in_font).unwrap_or(b'?');
            shown.length += 1;
        }
        shown
    }

    /// Returns true if there is no text.
    pub const fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Returns the text, including leading and trailing blanks.
    pub fn as_str(&self) -> &str {
        let text = self.ascii.get(..self.length.into()).unwrap_or_default();
        str::from_utf8(text).unwrap_or_default()
    }

    /// Returns the text as a number, 65,535 if the number is larger, or 0 if the text is not a
    /// number. Most mice use the text to display a distance.
    pub fn number(&self) -> u16 {
        let digits = self.as_str().trim_ascii();
        let is_number = digits.bytes().all(|byte| byte.is_ascii_digit());
        // Ten digits fit into 64 bits.
        let number = digits.parse::<u64>().ok().filter(|_| is_number).unwrap_or(0);
        number.try_into().unwrap_or(u16::MAX)
    }
}

impl fmt::Display for CellText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_shown_as_in_mms() {
        for (text, shown) in [
            ("", ""),
            (" 12 ", " 12 "),
            ("0123456789ab", "0123456789"),
            ("caf\u{e9} \u{1f401}\t\\", "caf? ???"),
            ("~}!", "~}!"),
            (&"\u{1f401}".repeat(20), "??????????"),
        ] {
            assert_eq!(CellText::new(text.as_bytes()).as_str(), shown, "{text:?}");
        }
        assert_eq!(CellText::new(b"a\xff\xfeb\x7f").as_str(), "a??b?");
    }

    #[test]
    fn digits_are_a_number() {
        for (text, number) in [
            ("7", 7),
            (" 12 ", 12),
            ("300", 300),
            ("65536", u16::MAX),
            ("99999999", u16::MAX),
            ("a", 0),
            ("-1", 0),
            ("", 0),
        ] {
            assert_eq!(CellText::new(text.as_bytes()).number(), number, "{text}");
        }
    }

    #[test]
    fn cells_outside_the_maze_display_nothing() {
        let mut display = Display::new(MazeSize::new(3, 2).unwrap());
        for outside in [Cell::new(3, 0), Cell::new(0, 2)] {
            display.execute(Command::Text { cell: outside, text: b"1" });
            display.execute(Command::Colour { cell: outside, colour: Some(Colour::Green) });
            assert_eq!((display.text(outside).as_str(), display.colour(outside)), ("", None));
        }
        assert_eq!(display, Display::new(MazeSize::new(3, 2).unwrap()));
    }
}
