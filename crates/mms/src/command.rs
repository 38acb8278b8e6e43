//! What a mouse asks for, as a line of text.

use mmsim_maze::{Cell, Excerpt, Heading, MazeSize};

use crate::Stat;

/// A command, read from a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command<'a> {
    /// How many cells are there from west to east?
    MazeWidth,
    /// How many cells are there from south to north?
    MazeHeight,
    /// Is anything in the way within so many half steps?
    Wall {
        /// Which way, in eighths of a turn clockwise from the nose.
        turn: i8,
        /// How far, 1 at least.
        half_steps: u64,
    },
    /// Go straight on.
    Forward {
        /// How far. 0 where the mouse said less than 1, or what is no number.
        half_steps: u64,
    },
    /// Turn on the point.
    Turn {
        /// Eighths of a turn clockwise; the other way where less than 0.
        eighths: i8,
    },
    /// Show a wall, or that there is none.
    MarkWall {
        /// The cell beside it.
        cell: Cell,
        /// The side of the cell.
        heading: Heading,
        /// Whether there is one.
        present: bool,
    },
    /// Colour a cell, or take the colour away.
    Colour {
        /// The cell.
        cell: Cell,
        /// The letter of the colour, one of `kbacgorwyBCAGRY`.
        letter: Option<char>,
    },
    /// Take the colours of all cells away.
    ClearAllColours,
    /// Write into a cell; what is empty takes the text away.
    Text {
        /// The cell.
        cell: Cell,
        /// The text, blanks included.
        text: &'a [u8],
    },
    /// Take the texts of all cells away.
    ClearAllText,
    /// Was the reset button pressed?
    WasReset,
    /// Put the mouse back to the start.
    AckReset,
    /// How well is it doing?
    GetStat(Stat),
}

/// A line that is no command. mms says nothing to those, and does nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// None of the commands.
    #[error("unknown command {0}")]
    Unknown(Excerpt<MAX_EXCERPT>),
    /// A command with arguments that are not its own.
    #[error("expected {expected}, found {found}")]
    Arguments {
        /// What the command looks like.
        expected: &'static str,
        /// The line.
        found: Excerpt<MAX_EXCERPT>,
    },
    /// A cell outside of the maze.
    #[error("expected a cell in a maze of {size} cells, found {found}")]
    Outside {
        /// The size of the maze.
        size: MazeSize,
        /// The line.
        found: Excerpt<MAX_EXCERPT>,
    },
}

/// Maximum length of an excerpt of a line in bytes.
const MAX_EXCERPT: usize = 60;

/// Returns the start of a line for an error, without trailing blanks.
pub fn excerpt(line: &[u8]) -> Excerpt<MAX_EXCERPT> {
    Excerpt::new(line.trim_ascii_end())
}

/// The letters of the colours that mms knows.
const COLOURS: &[u8] = b"kbacgorwyBCAGRY";

impl<'a> Command<'a> {
    /// The command on this line, for a maze of this size. A line may end with blanks and `\r\n`.
    ///
    /// A number that is too large to be read is as large as can be. The bare name of a [`Stat`] is
    /// taken as if `getStat` stood before it, which the crate `mms-rs` forgets.
    ///
    /// # Errors
    /// A line that is no command, or one about a cell outside of the maze.
    ///
    /// ```
    /// use mmsim_maze::MazeSize;
    /// use mmsim_mms::Command;
    /// let parse = |line: &'static str| Command::parse(line.as_bytes(), MazeSize::CLASSIC);
    /// assert_eq!(parse("moveForward 3"), Ok(Command::Forward { half_steps: 6 }));
    /// assert_eq!(parse("hello").unwrap_err().to_string(), "unknown command \"hello\"");
    /// ```
    pub fn parse(line: &'a [u8], size: MazeSize) -> Result<Self, CommandError> {
        let mut words = Words(line.strip_suffix(b"\n").unwrap_or(line));
        let name = words.next().unwrap_or_default();
        let name = str::from_utf8(name).unwrap_or_default();
        let line = Line { line, size };
        match name {
            "mazeWidth" => line.alone(words, "mazeWidth", Self::MazeWidth),
            "mazeHeight" => line.alone(words, "mazeHeight", Self::MazeHeight),
            "wallFront" => line.wall(words, 0),
            "wallFrontRight" => line.wall(words, 1),
            "wallRight" => line.wall(words, 2),
            "wallBackRight" => line.wall(words, 3),
            "wallBack" => line.wall(words, 4),
            "wallBackLeft" => line.wall(words, -3),
            "wallLeft" => line.wall(words, -2),
            "wallFrontLeft" => line.wall(words, -1),
            "moveForward" => line.forward(words, 2),
            "moveForwardHalf" => line.forward(words, 1),
            "turnRight" | "turnRight90" => line.turn(words, 2),
            "turnLeft" | "turnLeft90" => line.turn(words, -2),
            "turnRight45" => line.turn(words, 1),
            "turnLeft45" => line.turn(words, -1),
            "setWall" => line.mark_wall(words, "setWall x y n, e, s or w", true),
            "clearWall" => line.mark_wall(words, "clearWall x y n, e, s or w", false),
            "setColor" => line.colour(words),
            "clearColor" => {
                let cell = line.cell_alone(words, "clearColor x y")?;
                Ok(Self::Colour { cell, letter: None })
            }
            "clearAllColor" => line.alone(words, "clearAllColor", Self::ClearAllColours),
            "setText" => line.text(words),
            "clearText" => {
                let cell = line.cell_alone(words, "clearText x y")?;
                Ok(Self::Text { cell, text: b"" })
            }
            "clearAllText" => line.alone(words, "clearAllText", Self::ClearAllText),
            "wasReset" => line.alone(words, "wasReset", Self::WasReset),
            "ackReset" => line.alone(words, "ackReset", Self::AckReset),
            "getStat" => line.stat(words),
            name => match name.parse() {
                Ok(stat) => line.alone(words, "the name of a number alone", Self::GetStat(stat)),
                Err(_) => Err(CommandError::Unknown(excerpt(line.line))),
            },
        }
    }
}

/// A line, and the maze it speaks of.
#[derive(Clone, Copy)]
struct Line<'a> {
    line: &'a [u8],
    size: MazeSize,
}

impl<'a> Line<'a> {
    /// A command without arguments.
    fn alone(
        self,
        mut words: Words<'_>,
        expected: &'static str,
        command: Command<'a>,
    ) -> Result<Command<'a>, CommandError> {
        match words.next() {
            None => Ok(command),
            Some(_) => Err(self.wrong(expected)),
        }
    }

    fn wall(self, words: Words<'_>, turn: i8) -> Result<Command<'a>, CommandError> {
        let number = self.number(words, "at most a number of half steps after wall…")?;
        Ok(Command::Wall { turn, half_steps: number.max(1) })
    }

    fn forward(self, words: Words<'_>, half_steps: u64) -> Result<Command<'a>, CommandError> {
        let number = self.number(words, "at most a number of steps after moveForward…")?;
        Ok(Command::Forward { half_steps: number.saturating_mul(half_steps) })
    }

    fn turn(self, words: Words<'_>, eighths: i8) -> Result<Command<'a>, CommandError> {
        self.alone(words, "turn… without a number", Command::Turn { eighths })
    }

    fn mark_wall(
        self,
        mut words: Words<'_>,
        expected: &'static str,
        present: bool,
    ) -> Result<Command<'a>, CommandError> {
        let cell = self.cell(&mut words, expected)?;
        let heading = match (words.next(), words.next()) {
            (Some(b"n"), None) => Heading::North,
            (Some(b"e"), None) => Heading::East,
            (Some(b"s"), None) => Heading::South,
            (Some(b"w"), None) => Heading::West,
            _ => return Err(self.wrong(expected)),
        };
        Ok(Command::MarkWall { cell: cell?, heading, present })
    }

    fn colour(self, mut words: Words<'_>) -> Result<Command<'a>, CommandError> {
        let expected = "setColor x y and one of kbacgorwyBCAGRY";
        let cell = self.cell(&mut words, expected)?;
        match (words.next(), words.next()) {
            (Some(&[letter]), None) if COLOURS.contains(&letter) => {
                Ok(Command::Colour { cell: cell?, letter: Some(letter.into()) })
            }
            _ => Err(self.wrong(expected)),
        }
    }

    fn text(self, mut words: Words<'a>) -> Result<Command<'a>, CommandError> {
        let cell = self.cell(&mut words, "setText x y TEXT")??;
        // One blank parts the text from the number, all others belong to it.
        let Words(text) = words;
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        Ok(Command::Text { cell, text: text.get(1..).unwrap_or_default() })
    }

    fn stat(self, mut words: Words<'_>) -> Result<Command<'a>, CommandError> {
        let stat = words.next().and_then(|name| str::from_utf8(name).ok()?.parse().ok());
        match (stat, words.next()) {
            (Some(stat), None) => Ok(Command::GetStat(stat)),
            _ => Err(self.wrong("getStat and the name of a number, such as score")),
        }
    }

    /// A cell and nothing else.
    fn cell_alone(
        self,
        mut words: Words<'_>,
        expected: &'static str,
    ) -> Result<Cell, CommandError> {
        let cell = self.cell(&mut words, expected)?;
        if words.next().is_some() { Err(self.wrong(expected)) } else { cell }
    }

    /// A cell, and whether it lies inside: where the rest of the line is wrong, that counts more.
    fn cell(
        self,
        words: &mut Words<'_>,
        expected: &'static str,
    ) -> Result<Result<Cell, CommandError>, CommandError> {
        let mut number = || words.next().and_then(read_number).ok_or_else(|| self.wrong(expected));
        let (x, y) = (number()?, number()?);
        let cell = u8::try_from(x).ok().zip(u8::try_from(y).ok());
        let cell = cell.map(|(x, y)| Cell::new(x, y)).filter(|&cell| self.size.contains(cell));
        let outside = || CommandError::Outside { size: self.size, found: excerpt(self.line) };
        Ok(cell.ok_or_else(outside))
    }

    /// At most one number, 1 where there is none; 0 for less, and for what is no number.
    fn number(self, mut words: Words<'_>, expected: &'static str) -> Result<u64, CommandError> {
        match (words.next(), words.next()) {
            (None, _) => Ok(1),
            (Some(number), None) => {
                Ok(read_number(number).and_then(|number| u64::try_from(number).ok()).unwrap_or(0))
            }
            _ => Err(self.wrong(expected)),
        }
    }

    fn wrong(self, expected: &'static str) -> CommandError {
        CommandError::Arguments { expected, found: excerpt(self.line) }
    }
}

/// A whole number, as large or as small as can be where it is beyond that.
fn read_number(text: &[u8]) -> Option<i64> {
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

/// What is left of a line, word by word.
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
    fn blanks_and_ends_of_lines_do_not_matter() {
        for line in
            ["moveForward 3", "moveForward   3  ", " moveForward\t3\r\n", "moveForward +3\n"]
        {
            assert_eq!(parse(line), Ok(Command::Forward { half_steps: 6 }), "{line:?}");
        }
        // As mms-rs sends it.
        assert_eq!(parse("moveForward \n"), Ok(Command::Forward { half_steps: 2 }));
    }

    #[test]
    fn numbers_are_as_large_as_can_be() {
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
        let most = 2 * i64::MAX.unsigned_abs();
        assert_eq!(
            parse(&format!("moveForward {}0", u64::MAX)),
            Ok(Command::Forward { half_steps: most })
        );
    }

    #[test]
    fn a_text_is_all_that_is_left() {
        let cell = Cell::new(1, 2);
        for (line, text) in [
            ("setText 1 2 12\r\n", "12"),
            ("setText 1 2  two words ", " two words "),
            ("setText  1   2 a", "a"),
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
    fn a_number_may_be_asked_for_by_its_bare_name() {
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
        insta::assert_snapshot!(error(b"wallFront 1 2"), @r#"expected at most a number of half steps after wall…, found "wallFront 1 2""#);
        insta::assert_snapshot!(error(b"moveForward 1 2"), @r#"expected at most a number of steps after moveForward…, found "moveForward 1 2""#);
        insta::assert_snapshot!(error(b"turnLeft45 2"), @r#"expected turn… without a number, found "turnLeft45 2""#);
        insta::assert_snapshot!(error(b"setWall 1 2"), @r#"expected setWall x y n, e, s or w, found "setWall 1 2""#);
        insta::assert_snapshot!(error(b"clearWall 1 2 N"), @r#"expected clearWall x y n, e, s or w, found "clearWall 1 2 N""#);
        insta::assert_snapshot!(error(b"setWall 16 0 n"), @r#"expected a cell in a maze of 16x16 cells, found "setWall 16 0 n""#);
        insta::assert_snapshot!(error(b"setWall 16 0 up"), @r#"expected setWall x y n, e, s or w, found "setWall 16 0 up""#);
        insta::assert_snapshot!(error(b"setColor 0 0 x"), @r#"expected setColor x y and one of kbacgorwyBCAGRY, found "setColor 0 0 x""#);
        insta::assert_snapshot!(error(b"clearColor 0 0 r"), @r#"expected clearColor x y, found "clearColor 0 0 r""#);
        insta::assert_snapshot!(error(b"setText 0 -1 a"), @r#"expected a cell in a maze of 16x16 cells, found "setText 0 -1 a""#);
        insta::assert_snapshot!(error(b"setText 0"), @r#"expected setText x y TEXT, found "setText 0""#);
        insta::assert_snapshot!(error(b"getStat"), @r#"expected getStat and the name of a number, such as score, found "getStat""#);
        insta::assert_snapshot!(error(b"score 1"), @r#"expected the name of a number alone, found "score 1""#);
    }

    proptest! {
        #[test]
        fn any_line_is_a_command_or_an_error_that_can_be_shown(
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
