//! The lines that a mouse writes, the loop that executes them as commands of mms, and reports of those
//! that are no commands.

use std::io::{self, BufRead, Read};
use std::sync::mpsc::SyncSender;
use std::{fmt, mem};

use mmsim_mms::{Command, CommandError, Environment, Response, SimulatedMouse, excerpt};

/// The maximum length of a line in bytes, including the newline.
pub(crate) const MAX_LINE_BYTES: usize = 4096;

/// The maximum length of an excerpt from a line, in bytes.
pub(crate) const START_BYTES: usize = 40;

/// A line of output from a mouse.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// A complete line, including the newline.
    Whole(Vec<u8>),
    /// The start of a line that exceeds the maximum length.
    TooLong(Vec<u8>),
    /// The last line of the output, if it does not end with a newline.
    Unfinished(Vec<u8>),
}

/// Reads the next line, or returns `None` at the end of output. Truncates overlong lines.
pub(crate) fn read_line(stdout: &mut impl BufRead) -> io::Result<Option<Line>> {
    let mut line = Vec::new();
    stdout.by_ref().take(MAX_LINE_BYTES as u64).read_until(b'\n', &mut line)?;
    if line.ends_with(b"\n") {
        return Ok(Some(Line::Whole(line)));
    }
    if line.len() < MAX_LINE_BYTES {
        return Ok((!line.is_empty()).then_some(Line::Unfinished(line)));
    }
    stdout.skip_until(b'\n')?;
    line.truncate(START_BYTES);
    Ok(Some(Line::TooLong(line)))
}

/// The number of lines of each kind that are reported.
const REPORTED: u64 = 5;

/// Reads lines and sends them to a queue until the end of the output.
pub(crate) fn read_lines(mut stdout: impl BufRead, lines: &SyncSender<Line>) {
    // An error ends the output.
    while let Ok(Some(line)) = read_line(&mut stdout) {
        if lines.send(line).is_err() {
            return;
        }
    }
}

/// A mouse that writes lines and reads replies, in an environment `E`.
pub(crate) trait CommandSource<E: Environment> {
    /// Returns the environment.
    fn environment(&mut self) -> &mut E;

    /// Waits for the next line. Returns `None` if no further line is executed.
    fn next_line(&mut self, mouse: &SimulatedMouse) -> Result<Option<Line>, E::Error>;

    /// Notes a valid command. Returns false if it must not be executed.
    fn accept(&mut self, mouse: &mut SimulatedMouse) -> bool;

    /// Notes an invalid line that is not blank.
    fn refuse(&mut self, line: &InvalidLine<'_>);

    /// Sends the reply to the command that the mouse has just executed.
    fn reply(&mut self, mouse: &SimulatedMouse, reply: Response) -> Result<(), E::Error>;
}

/// Executes the commands of a mouse until there are no more lines.
pub(crate) fn execute_all<E: Environment>(
    mouse: &mut SimulatedMouse,
    source: &mut impl CommandSource<E>,
) -> Result<(), E::Error> {
    let is_blank = |line: &_| matches!(line, Line::Whole(line) if line.trim_ascii().is_empty());
    while let Some(line) = source.next_line(mouse)? {
        let command = match &line {
            Line::Whole(line) => {
                Command::parse(line, mouse.map().size()).map_err(InvalidLine::Command)
            }
            Line::TooLong(start) => Err(InvalidLine::TooLong(start)),
            Line::Unfinished(start) => Err(InvalidLine::Unfinished(start)),
        };
        match command {
            Ok(command) if source.accept(mouse) => {
                if let Some(reply) = mouse.execute(command, source.environment())? {
                    source.reply(mouse, reply)?;
                }
            }
            Err(invalid) if !is_blank(&line) => source.refuse(&invalid),
            Ok(_) | Err(_) => {}
        }
    }
    Ok(())
}

/// A line that is no command.
#[derive(Debug)]
pub(crate) enum InvalidLine<'l> {
    /// A line that is not a valid command.
    Command(CommandError),
    /// A line that exceeds the maximum length.
    TooLong(&'l [u8]),
    /// The last line of the output, without a newline.
    Unfinished(&'l [u8]),
}

/// The number of the kinds that [`InvalidLine::kind`] returns.
const KINDS: usize = 5;

impl InvalidLine<'_> {
    /// Returns an index for the kind and what its lines are called.
    const fn kind(&self) -> (usize, &'static str) {
        match self {
            Self::Command(CommandError::Arguments { .. }) => (0, "invalid arguments"),
            Self::Command(CommandError::Outside { .. }) => (1, "cells outside the maze"),
            Self::Command(_) => (2, "unknown commands"),
            Self::TooLong(_) => (3, "overlong lines"),
            Self::Unfinished(_) => (4, "incomplete lines"),
        }
    }
}

impl fmt::Display for InvalidLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(error) => error.fmt(f),
            Self::TooLong(start) => {
                let start = excerpt(start);
                write!(
                    f,
                    "expected at most {MAX_LINE_BYTES} bytes, found a longer line that starts with {start}"
                )
            }
            Self::Unfinished(start) => {
                write!(f, "expected a newline, found the end of output after {}", excerpt(start))
            }
        }
    }
}

/// Counts the invalid lines of a mouse and selects those to report: the first five of each kind,
/// and the line after which a mouse falls silent.
#[derive(Debug, Default)]
pub(crate) struct InvalidLines {
    counts: [u64; KINDS],
    /// The report of the latest line, if that line is invalid and was not reported.
    withheld: Option<String>,
    /// The number of withheld reports that were returned. After the first five, no report is
    /// withheld.
    explained: u64,
}

impl InvalidLines {
    /// Returns the number of invalid lines.
    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Counts an invalid line and returns the message to print, if any.
    pub(crate) fn add(&mut self, line: u64, invalid_line: &InvalidLine<'_>) -> Option<String> {
        let (kind, name) = invalid_line.kind();
        let count = self.counts.get_mut(kind)?;
        *count += 1;
        self.withheld = None;
        if *count <= REPORTED {
            return Some(format!("mms: line {line}: {invalid_line}"));
        }
        if self.explained < REPORTED {
            self.withheld = Some(format!("mms: line {line}: {invalid_line}"));
        }
        (*count == REPORTED + 1).then(|| format!("mms: further {name} are counted but not shown"))
    }

    /// Notes that the latest line is valid.
    pub(crate) fn accept(&mut self) {
        self.withheld = None;
    }

    /// Returns true if the report of the latest line was withheld.
    pub(crate) const fn has_withheld(&self) -> bool {
        self.withheld.is_some()
    }

    /// Returns the report of the latest line if it was withheld, because the mouse may be waiting
    /// for a reply to that line.
    pub(crate) fn take_withheld(&mut self) -> Option<String> {
        self.explained += u64::from(self.has_withheld());
        mem::take(&mut self.withheld)
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use mmsim_maze::MazeSize;

    use super::*;

    #[test]
    fn overlong_and_unfinished_lines_are_distinguished() {
        let long = vec![b'x'; 3 * MAX_LINE_BYTES];
        let longest = [&long[..MAX_LINE_BYTES - 1], b"\n"].concat();
        let text = [&b"one\n\ntwo\r\n"[..], &longest, &long, b"\nthree"].concat();
        let mut reader = BufReader::with_capacity(7, &text[..]);
        let mut next = || read_line(&mut reader).unwrap();
        for whole in [&b"one\n"[..], b"\n", b"two\r\n", &longest] {
            assert_eq!(next(), Some(Line::Whole(whole.to_vec())));
        }
        assert_eq!(next(), Some(Line::TooLong(long[..START_BYTES].to_vec())));
        assert_eq!(next(), Some(Line::Unfinished(b"three".to_vec())));
        assert_eq!(next(), None);
    }

    fn add(invalid_lines: &mut InvalidLines, number: u64, line: &str) -> Option<String> {
        let error = Command::parse(line.as_bytes(), MazeSize::CLASSIC).unwrap_err();
        invalid_lines.add(number, &InvalidLine::Command(error))
    }

    #[test]
    fn five_lines_of_each_kind_are_reported() {
        let mut invalid_lines = InvalidLines::default();
        let mut messages = Vec::new();
        for number in 1..=1000 {
            messages.extend(add(&mut invalid_lines, number, &format!("hello {number}")));
        }
        messages.extend(add(&mut invalid_lines, 1001, "clearText 16 0"));
        insta::assert_snapshot!(messages.join("\n"), @r#"
        mms: line 1: unknown command "hello 1"
        mms: line 2: unknown command "hello 2"
        mms: line 3: unknown command "hello 3"
        mms: line 4: unknown command "hello 4"
        mms: line 5: unknown command "hello 5"
        mms: further unknown commands are counted but not shown
        mms: line 1001: expected a cell in a maze of 16x16 cells, found "clearText 16 0"
        "#);
        assert_eq!(invalid_lines.total(), 1001);
    }

    #[test]
    fn silence_is_explained_five_times() {
        let mut invalid_lines = InvalidLines::default();
        for number in 1..=5 {
            add(&mut invalid_lines, number, "hello");
            assert_eq!(invalid_lines.take_withheld(), None, "the line was reported");
        }
        add(&mut invalid_lines, 6, "hello");
        invalid_lines.accept();
        assert_eq!(invalid_lines.take_withheld(), None, "the latest line is valid");
        for number in 8..=12 {
            add(&mut invalid_lines, number, "moveForwrad");
            let explained = invalid_lines.take_withheld();
            let expected = format!("mms: line {number}: unknown command \"moveForwrad\"");
            assert_eq!(explained, Some(expected));
            assert_eq!(invalid_lines.take_withheld(), None, "the line was reported");
        }
        add(&mut invalid_lines, 13, "hello");
        assert_eq!(invalid_lines.take_withheld(), None);
    }
}
