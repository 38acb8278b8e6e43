//! Parses the commands of a mouse.

use mmsim_fastrun::{Side, TurnKind};
use mmsim_maze::{Cell, Colour, Excerpt, Heading, MazeSize};

use crate::scores::Stat;

/// A parsed command from a mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command<'a> {
    /// Report the width of the maze in cells.
    MazeWidth,
    /// Report the height of the maze in cells.
    MazeHeight,
    /// Report the goal cells. mms does not know this command.
    Goals,
    /// Check for a wall or post within the given number of half steps.
    Wall {
        /// The direction relative to the mouse, in eighths of a turn clockwise.
        turn: i8,
        /// The distance in half steps, at least 1.
        half_steps: u64,
    },
    /// Move forward.
    Forward {
        /// The distance in half steps, or 0 if the argument is less than 1 or not an integer.
        half_steps: u64,
    },
    /// Turn in place.
    Turn {
        /// The angle in eighths of a turn, clockwise if positive.
        eighths: i8,
    },
    /// Drive a slalom turn. mms does not know this command.
    Slalom {
        /// The turn.
        kind: TurnKind,
        /// The side to which the mouse turns.
        side: Side,
    },
    /// Mark a wall as present or absent.
    MarkWall {
        /// The cell whose side is marked.
        cell: Cell,
        /// The marked side of the cell.
        heading: Heading,
        /// True if the wall is present.
        is_present: bool,
    },
    /// Set or clear the colour of a cell.
    Colour {
        /// The cell.
        cell: Cell,
        /// The colour, or `None` to clear it.
        colour: Option<Colour>,
    },
    /// Clear the colours of all cells.
    ClearAllColours,
    /// Set or clear the text of a cell.
    Text {
        /// The cell.
        cell: Cell,
        /// The text, including leading and trailing blanks, or an empty string to clear the text.
        text: &'a [u8],
    },
    /// Clear the texts of all cells.
    ClearAllText,
    /// Report whether the reset button was pressed.
    WasReset,
    /// Move the mouse back to the start.
    AckReset,
    /// Report a statistic.
    GetStat(Stat),
}

/// An invalid line, which mms ignores without a response.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// An unknown command.
    #[error("unknown command {0}")]
    Unknown(Excerpt<MAX_EXCERPT>),
    /// A known command with invalid arguments.
    #[error("expected {expected}, found {found}")]
    Arguments {
        /// The syntax of the command.
        expected: &'static str,
        /// The line.
        found: Excerpt<MAX_EXCERPT>,
    },
    /// A cell outside the maze.
    #[error("expected a cell in a maze of {size} cells, found {found}")]
    Outside {
        /// The size of the maze.
        size: MazeSize,
        /// The line.
        found: Excerpt<MAX_EXCERPT>,
    },
}

/// The maximum length of an excerpt from a line, in bytes.
const MAX_EXCERPT: usize = 60;

/// Returns the start of a line for an error message, without trailing blanks.
pub fn excerpt(line: &[u8]) -> Excerpt<MAX_EXCERPT> {
    Excerpt::new(line.trim_ascii_end())
}

impl<'a> Command<'a> {
    /// Parses a command from a mouse in a maze of the given size. The line may end with blanks and
    /// `\r\n`.
    ///
    /// Numbers that are out of range are clamped. The name of a [`Stat`] is also accepted without
    /// `getStat`, because the `mms-rs` crate omits `getStat`.
    ///
    /// # Errors
    /// Returns an error if the command is unknown, its arguments are invalid, or its cell is
    /// outside the maze.
    ///
    /// ```
    /// use mmsim_maze::MazeSize;
    /// use mmsim_mms::Command;
    /// let parse = |line: &'static str| Command::parse(line.as_bytes(), MazeSize::CLASSIC);
    /// assert_eq!(parse("moveForward 3"), Ok(Command::Forward { half_steps: 6 }));
    /// assert_eq!(parse("hello").unwrap_err().to_string(), "unknown command \"hello\"");
    /// ```
    pub fn parse(line: &'a [u8], size: MazeSize) -> Result<Self, CommandError> {
        let words = Words(line.strip_suffix(b"\n").unwrap_or(line));
        let mut parser = Parser { line, size, words };
        let name = parser.words.next().unwrap_or_default();
        let is_display = name.starts_with(b"set") || name.starts_with(b"clear");
        if is_display && !line.starts_with(name) {
            return Err(parser.invalid_arguments("no blank before this command"));
        }
        match name {
            b"mazeWidth" => parser.no_arguments("mazeWidth", Self::MazeWidth),
            b"mazeHeight" => parser.no_arguments("mazeHeight", Self::MazeHeight),
            b"goals" => parser.no_arguments("goals", Self::Goals),
            b"wallFront" => parser.wall(0),
            b"wallFrontRight" => parser.wall(1),
            b"wallRight" => parser.wall(2),
            b"wallBackRight" => parser.wall(3),
            b"wallBack" => parser.wall(4),
            b"wallBackLeft" => parser.wall(-3),
            b"wallLeft" => parser.wall(-2),
            b"wallFrontLeft" => parser.wall(-1),
            b"moveForward" => parser.forward(2),
            b"moveForwardHalf" => parser.forward(1),
            b"turnRight" | b"turnRight90" => parser.turn(2),
            b"turnLeft" | b"turnLeft90" => parser.turn(-2),
            b"turnRight45" => parser.turn(1),
            b"turnLeft45" => parser.turn(-1),
            b"slalomLeft" => parser.slalom(Side::Left),
            b"slalomRight" => parser.slalom(Side::Right),
            b"setWall" => parser.mark_wall("setWall X Y n|e|s|w", true),
            b"clearWall" => parser.mark_wall("clearWall X Y n|e|s|w", false),
            b"setColor" => parser.colour(),
            b"clearColor" => {
                let cell = parser.only_cell("clearColor X Y")?;
                Ok(Self::Colour { cell, colour: None })
            }
            b"clearAllColor" => parser.no_arguments("clearAllColor", Self::ClearAllColours),
            b"setText" => parser.text(),
            b"clearText" => {
                let cell = parser.only_cell("clearText X Y")?;
                Ok(Self::Text { cell, text: b"" })
            }
            b"clearAllText" => parser.no_arguments("clearAllText", Self::ClearAllText),
            b"wasReset" => parser.no_arguments("wasReset", Self::WasReset),
            b"ackReset" => parser.no_arguments("ackReset", Self::AckReset),
            b"getStat" => parser.stat(),
            name => match Stat::from_name(name) {
                Some(stat) => {
                    let expected = "only the name of a statistic";
                    parser.no_arguments(expected, Self::GetStat(stat))
                }
                None => Err(CommandError::Unknown(excerpt(parser.line))),
            },
        }
    }
}

type Result<T, E = CommandError> = std::result::Result<T, E>;

/// A parser for the arguments of a command. It keeps the whole line, which error messages quote.
struct Parser<'a> {
    line: &'a [u8],
    size: MazeSize,
    /// The words that have not been parsed.
    words: Words<'a>,
}

impl<'a> Parser<'a> {
    fn no_arguments(mut self, expected: &'static str, command: Command<'a>) -> Result<Command<'a>> {
        match self.words.next() {
            None => Ok(command),
            Some(_) => Err(self.invalid_arguments(expected)),
        }
    }

    fn wall(self, turn: i8) -> Result<Command<'a>> {
        let number = self.number("a wall command with at most one number")?;
        Ok(Command::Wall { turn, half_steps: number.max(1) })
    }

    fn forward(self, half_steps: u64) -> Result<Command<'a>> {
        let number = self.number("a moveForward command with at most one number")?;
        Ok(Command::Forward { half_steps: number.saturating_mul(half_steps) })
    }

    fn turn(self, eighths: i8) -> Result<Command<'a>> {
        self.no_arguments("a turn command without arguments", Command::Turn { eighths })
    }

    fn slalom(mut self, side: Side) -> Result<Command<'a>> {
        let kind =
            self.words.next().and_then(|name| TurnKind::from_name(str::from_utf8(name).ok()?));
        match (kind, self.words.next()) {
            (Some(kind), None) => Ok(Command::Slalom { kind, side }),
            _ => Err(self.invalid_arguments("the name of a slalom turn, such as slalomLeft s90")),
        }
    }

    fn mark_wall(mut self, expected: &'static str, is_present: bool) -> Result<Command<'a>> {
        let cell = self.cell(expected)?;
        let heading = match (self.words.next(), self.words.next()) {
            (Some(b"n"), None) => Heading::North,
            (Some(b"e"), None) => Heading::East,
            (Some(b"s"), None) => Heading::South,
            (Some(b"w"), None) => Heading::West,
            _ => return Err(self.invalid_arguments(expected)),
        };
        Ok(Command::MarkWall { cell: cell?, heading, is_present })
    }

    fn colour(mut self) -> Result<Command<'a>> {
        let expected = "setColor X Y C, where C is one of kbacgorwyBCAGORVY";
        let cell = self.cell(expected)?;
        let colour = match (self.words.next(), self.words.next()) {
            (Some(&[letter]), None) => Colour::from_letter(letter.into()),
            _ => None,
        };
        let colour = colour.ok_or_else(|| self.invalid_arguments(expected))?;
        Ok(Command::Colour { cell: cell?, colour: Some(colour) })
    }

    fn text(mut self) -> Result<Command<'a>> {
        let expected = "setText X Y TEXT, with one blank before X and Y";
        let blanks = self.line.split(u8::is_ascii_whitespace);
        if blanks.skip(1).take(2).any(<[u8]>::is_empty) {
            return Err(self.invalid_arguments(expected));
        }
        let cell = self.cell(expected)??;
        // The first blank is a separator; further ones are part of the text.
        let Words(text) = self.words;
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        Ok(Command::Text { cell, text: text.get(1..).unwrap_or_default() })
    }

    fn stat(mut self) -> Result<Command<'a>> {
        match (self.words.next().and_then(Stat::from_name), self.words.next()) {
            (Some(stat), None) => Ok(Command::GetStat(stat)),
            _ => Err(self.invalid_arguments("getStat and the name of a statistic, such as score")),
        }
    }

    /// Parses a cell as the only argument of a command.
    fn only_cell(mut self, expected: &'static str) -> Result<Cell> {
        let cell = self.cell(expected)?;
        if self.words.next().is_some() { Err(self.invalid_arguments(expected)) } else { cell }
    }

    /// Parses a cell. Returns the outer error if the coordinates are missing or are not integers,
    /// and the inner error if the cell is outside the maze. Callers report the inner error only if
    /// all other arguments are valid.
    fn cell(&mut self, expected: &'static str) -> Result<Result<Cell>> {
        let [x, y] = [(); 2].map(|()| self.words.next().and_then(parse_number));
        let (x, y) = x.zip(y).ok_or_else(|| self.invalid_arguments(expected))?;
        let cell = u8::try_from(x).ok().zip(u8::try_from(y).ok());
        let cell = cell.map(|(x, y)| Cell::new(x, y)).filter(|&cell| self.size.contains(cell));
        let outside = || CommandError::Outside { size: self.size, found: excerpt(self.line) };
        Ok(cell.ok_or_else(outside))
    }

    /// Parses an optional number that defaults to 1. Returns 0 if the number is negative or
    /// invalid.
    fn number(mut self, expected: &'static str) -> Result<u64> {
        match (self.words.next(), self.words.next()) {
            (None, _) => Ok(1),
            (Some(number), None) => {
                Ok(parse_number(number).and_then(|number| u64::try_from(number).ok()).unwrap_or(0))
            }
            _ => Err(self.invalid_arguments(expected)),
        }
    }

    fn invalid_arguments(&self, expected: &'static str) -> CommandError {
        CommandError::Arguments { expected, found: excerpt(self.line) }
    }
}

/// Parses an integer. Clamps numbers that are out of range.
fn parse_number(text: &[u8]) -> Option<i64> {
    let text = str::from_utf8(text).ok()?;
    let (is_negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let number = digits.parse().unwrap_or(i64::MAX);
    Some(if is_negative { -number } else { number })
}

/// The remaining words of a line.
struct Words<'a>(&'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.0.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parse(line: &str) -> Result<Command<'_>, CommandError> {
        Command::parse(line.as_bytes(), MazeSize::CLASSIC)
    }

    #[test]
    fn extra_blanks_and_line_endings_are_ignored() {
        for line in
            ["moveForward 3", "moveForward   3  ", " moveForward\t3\r\n", "moveForward +3\n"]
        {
            assert_eq!(parse(line), Ok(Command::Forward { half_steps: 6 }), "{line:?}");
        }
        // The crate mms-rs sends this line.
        assert_eq!(parse("moveForward \n"), Ok(Command::Forward { half_steps: 2 }));
    }

    #[test]
    fn numbers_saturate() {
        for (number, half_steps) in [
            ("1", 1),
            ("0", 0),
            ("-1", 0),
            ("2147483648", 1 << 31),
            ("1000000000000000000000000000000", i64::MAX.unsigned_abs()),
            ("-1000000000000000000000000000000", 0),
            ("1.5", 0),
            ("0x10", 0),
            ("many", 0),
            ("+", 0),
            ("--1", 0),
        ] {
            let line = format!("moveForwardHalf {number}");
            assert_eq!(parse(&line), Ok(Command::Forward { half_steps }), "{line}");
            let line = format!("wallFront {number}");
            let half_steps = half_steps.max(1);
            assert_eq!(parse(&line), Ok(Command::Wall { turn: 0, half_steps }), "{line}");
        }
        let max = 2 * i64::MAX.unsigned_abs();
        assert_eq!(
            parse(&format!("moveForward {}0", u64::MAX)),
            Ok(Command::Forward { half_steps: max })
        );
    }

    #[test]
    fn text_is_the_rest_of_the_line() {
        let cell = Cell::new(1, 2);
        for (line, text) in [
            ("setText 1 2 12\r\n", "12"),
            ("setText 1 2  two words ", " two words "),
            ("setText 1 2 ", ""),
            ("setText 1 2", ""),
            ("clearText 1 2", ""),
            ("setText 1 2 é", "é"),
        ] {
            let text = text.as_bytes();
            assert_eq!(parse(line), Ok(Command::Text { cell, text }), "{line:?}");
        }
    }

    #[test]
    fn the_name_of_a_statistic_alone_is_accepted() {
        assert_eq!(parse("getStat score"), Ok(Command::GetStat(Stat::Score)));
        assert_eq!(parse("total-turns\n"), Ok(Command::GetStat(Stat::TotalTurns)));
    }

    #[test]
    fn errors_quote_the_line() {
        let error = |line: &[u8]| Command::parse(line, MazeSize::CLASSIC).unwrap_err().to_string();
        insta::assert_snapshot!(error(b"moveForwrad\n"), @r#"unknown command "moveForwrad""#);
        insta::assert_snapshot!(error(b""), @"unknown command an empty message");
        insta::assert_snapshot!(error(b"\xff\x1b[2J"), @r#"unknown command "\xff\x1b[2J""#);
        insta::assert_snapshot!(error(b"MoveForward"), @r#"unknown command "MoveForward""#);
        insta::assert_snapshot!(error(&[b'x'; 4096]), @r#"unknown command "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"… of 4096 bytes"#);
        insta::assert_snapshot!(error(b"mazeWidth 3"), @r#"expected mazeWidth, found "mazeWidth 3""#);
        insta::assert_snapshot!(error(b"wallFront 1 2"), @r#"expected a wall command with at most one number, found "wallFront 1 2""#);
        insta::assert_snapshot!(error(b"moveForward 1 2"), @r#"expected a moveForward command with at most one number, found "moveForward 1 2""#);
        insta::assert_snapshot!(error(b"turnLeft45 2"), @r#"expected a turn command without arguments, found "turnLeft45 2""#);
        insta::assert_snapshot!(error(b"setWall 1 2"), @r#"expected setWall X Y n|e|s|w, found "setWall 1 2""#);
        insta::assert_snapshot!(error(b"clearWall 1 2 N"), @r#"expected clearWall X Y n|e|s|w, found "clearWall 1 2 N""#);
        insta::assert_snapshot!(error(b"setWall 16 0 n"), @r#"expected a cell in a maze of 16x16 cells, found "setWall 16 0 n""#);
        insta::assert_snapshot!(error(b"setWall 16 0 up"), @r#"expected setWall X Y n|e|s|w, found "setWall 16 0 up""#);
        insta::assert_snapshot!(error(b"setText  0 0 x"), @r#"expected setText X Y TEXT, with one blank before X and Y, found "setText  0 0 x""#);
        insta::assert_snapshot!(error(b" clearAllText"), @r#"expected no blank before this command, found " clearAllText""#);
        insta::assert_snapshot!(error(b"setColor 0 0 x"), @r#"expected setColor X Y C, where C is one of kbacgorwyBCAGORVY, found "setColor 0 0 x""#);
        insta::assert_snapshot!(error(b"clearColor 0 0 r"), @r#"expected clearColor X Y, found "clearColor 0 0 r""#);
        insta::assert_snapshot!(error(b"setText 0 -1 a"), @r#"expected a cell in a maze of 16x16 cells, found "setText 0 -1 a""#);
        insta::assert_snapshot!(error(b"setText 0"), @r#"expected setText X Y TEXT, with one blank before X and Y, found "setText 0""#);
        insta::assert_snapshot!(error(b"getStat"), @r#"expected getStat and the name of a statistic, such as score, found "getStat""#);
        insta::assert_snapshot!(error(b"score 1"), @r#"expected only the name of a statistic, found "score 1""#);
    }

    proptest! {
        #[test]
        fn any_line_is_a_command_or_a_printable_error(
            line in prop_oneof![
                prop::collection::vec(any::<u8>(), 0..200),
                "(setText|setWall|wallBack|moveForward|getStat|clearColor)( -?[0-9a-z]{0,30}){0,4}\r?"
                    .prop_map(String::into_bytes),
            ],
        ) {
            if let Err(error) = Command::parse(&line, MazeSize::CLASSIC) {
                prop_assert!(error.to_string().chars().all(|c| c == '…' || (' '..='~').contains(&c)));
            }
        }
    }
}
