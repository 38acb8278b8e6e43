//! Maze file formats, told from their content.
use std::str::FromStr;

use crate::{Cell, CellSet, Maze, MazeSize, Walls};

mod grid;
mod oshwdem;
mod text;
mod trial;

/// A way to write a maze down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Posts and walls drawn as text, north on top:
    ///
    /// ```text
    /// o---o---o
    /// |     G |
    /// o   o---o
    /// | S     |
    /// o---o---o
    /// ```
    ///
    /// Any character may stand for a post, with two or more alike from post to post on a line of
    /// posts. A wall's place that is blank is open, one without a blank is a wall. `S` and `G` are
    /// optional: the start is (0, 0) and the goal the central cells unless marked. Blank lines,
    /// trailing blanks and `\r` are ignored, missing trailing blanks supplied, and text may follow
    /// after the last line of the maze.
    Text,
    /// What the OSHWDEM maze generator writes: a first line that starts with `OSHWDEM`, then the
    /// maze drawn with `A` in the start cell and `B` in place of the post in the middle of the
    /// goal. Its axes are turned: file right is north, file down is east.
    Oshwdem,
    /// The maze of the two-run trial: the even side n, then n lines of n comma-separated numbers,
    /// line = column from the west, number = cell from the south, bits 1 north, 2 east, 4 south
    /// and 8 west, each set where the way is open.
    Trial,
}

/// A maze file that cannot be understood: where, what was expected there, what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: expected {expected}, found {found}")]
pub struct ParseError {
    /// The line, counted from 1.
    pub line: usize,
    /// The column in characters, counted from 1.
    pub column: usize,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
}

impl Format {
    /// The format of this content, judged by its first two lines that are not blank.
    ///
    /// ```
    /// use mmsim_maze::Format;
    /// assert_eq!(Format::of("o---o\n| S |\no---o\n"), Format::Text);
    /// assert_eq!(Format::of("2\n1,3\n4,12\n"), Format::Trial);
    /// ```
    pub fn of(text: &str) -> Self {
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let (first, second) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
        let is_number = !first.is_empty() && first.chars().all(|c| c.is_ascii_digit());
        if first.starts_with("OSHWDEM") {
            Self::Oshwdem
        } else if is_number && (first.len() <= 2 || second.contains(',')) {
            // The narrowest row of posts has three characters, and a maze may be drawn with digits.
            Self::Trial
        } else {
            Self::Text
        }
    }
}

impl Maze {
    /// Reads a maze from a file's content, in whichever [`Format`] it is.
    ///
    /// # Errors
    /// Content that is empty, truncated, contradictory, too large or no maze at all, with its
    /// place.
    ///
    /// ```
    /// use mmsim_maze::Maze;
    /// let error = Maze::parse(b"o---o\n| S |\no-- o\n").unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     r#"line 3, column 2: expected "---" or three spaces between posts, found "-- ""#
    /// );
    /// ```
    pub fn parse(content: &[u8]) -> Result<Self, ParseError> {
        let text = String::from_utf8_lossy(content);
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        if text.trim().is_empty() {
            let found = if content.is_empty() { "an empty file" } else { "only blanks" };
            return Err(ParseError::new(1, 1, "a maze", found));
        }
        match Format::of(text) {
            Format::Text => text::parse(text),
            Format::Oshwdem => oshwdem::parse(text),
            Format::Trial => trial::parse(text),
        }
    }
}

impl FromStr for Maze {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        Self::parse(text.as_bytes())
    }
}

impl ParseError {
    fn new(
        line: usize,
        column: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self { line, column, expected: expected.into(), found: found.into() }
    }
}

impl ParseError {
    /// The error for a file that goes on after this content, the most that is read.
    pub(crate) fn too_large(content: &[u8]) -> Self {
        let lines = content.split(|&byte| byte == b'\n');
        let column = lines.clone().next_back().map_or(0, <[u8]>::len) + 1;
        let line = lines.count();
        let expected = format!("the end of the file before byte {}", content.len());
        Self::new(line, column, expected, "more")
    }
}

/// The cell at these coordinates, which a format has checked to be below 32.
#[allow(clippy::cast_possible_truncation)]
fn cell(x: usize, y: usize) -> Cell {
    Cell::new(x as u8, y as u8)
}

/// A size that a format has checked already, so that its errors carry a place.
fn size(width: usize, height: usize) -> Result<MazeSize, ParseError> {
    MazeSize::new(width, height).map_err(|error| {
        let found = format!("{}x{}", error.width, error.height);
        ParseError::new(1, 1, "a maze of 1x1 to 32x32 cells", found)
    })
}

/// The maze of these parts, which come from inside the drawing.
fn finish(walls: Walls, start: Option<Cell>, goals: CellSet) -> Result<Maze, ParseError> {
    Maze::new(walls, start.unwrap_or(Cell::new(0, 0)), goals).map_err(|error| {
        ParseError::new(1, 1, "a start and goals inside the maze", error.cell.to_string())
    })
}

/// Some of the file's own text for an error message: in quotes, escaped, not too long.
fn quoted(found: &str) -> String {
    const LONGEST: usize = 24;
    if found.is_empty() {
        return "the end of the line".to_string();
    }
    match found.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &found[..end]),
        None => format!("{found:?}"),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Heading;

    #[test]
    fn rubbish_gets_a_place_and_a_reason() {
        let error = |content: &[u8]| Maze::parse(content).unwrap_err().to_string();
        insta::assert_snapshot!(error(b""), @"line 1, column 1: expected a maze, found an empty file");
        insta::assert_snapshot!(error(b" \r\n\n\t "), @"line 1, column 1: expected a maze, found only blanks");
        insta::assert_snapshot!(error(b"\x7fELF\x02\x01\x01\x00\x00\xff\xfe\n\x00"), @r"line 1, column 1: expected a maze drawn with printable characters, found '\u{7f}'");
        insta::assert_snapshot!(error(b"# A README\n\nSome words.\n"), @r##"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "# A README""##);
        insta::assert_snapshot!(error(b"{\n  \"maze\": 1\n}\n"), @r#"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "{""#);
        insta::assert_snapshot!(error(b"hello\n"), @r#"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "hello""#);
    }

    fn any_maze() -> impl Strategy<Value = Maze> {
        let cells = prop::collection::vec((any::<u8>(), any::<u8>()), 1..6);
        (
            1usize..=32,
            1usize..=32,
            prop::collection::vec(any::<bool>(), 2 * MazeSize::MAX_AREA),
            cells,
        )
            .prop_map(|(width, height, present, cells)| {
                let size = MazeSize::new(width, height).unwrap();
                let mut walls = Walls::open(size);
                for (cell, present) in size.cells().zip(present.chunks(2)) {
                    walls.set(cell, Heading::North, present[0]);
                    walls.set(cell, Heading::East, present[1]);
                }
                let mut cells =
                    cells.into_iter().map(|(x, y)| Cell::new(x % size.width(), y % size.height()));
                let start = cells.next().unwrap();
                Maze::new(walls, start, cells.collect::<CellSet>()).unwrap()
            })
    }

    proptest! {
        #[test]
        fn what_is_drawn_reads_back(maze in any_maze()) {
            prop_assert_eq!(&maze.to_string().parse::<Maze>().unwrap(), &maze);
        }

        #[test]
        fn line_ends_and_blanks_do_not_matter(maze in any_maze(), blank in prop::collection::vec(0usize..4, 70)) {
            let mut text = String::new();
            for (line, blank) in maze.to_string().lines().zip(blank.iter().cycle()) {
                text += line;
                text += ["\n", "\r\n", "  \t\n", "\r\n  \n\n"][*blank];
            }
            prop_assert_eq!(&text.parse::<Maze>().unwrap(), &maze);
        }

        #[test]
        fn any_bytes_give_a_maze_or_an_error(content in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = Maze::parse(&content);
        }

        #[test]
        fn a_damaged_maze_gives_a_maze_or_an_error(
            maze in any_maze(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut content: Vec<u8> = maze.to_string().into_bytes();
            for (place, byte) in damage {
                let place = place.index(content.len());
                content[place] = byte;
            }
            let _ = Maze::parse(&content);
            content.truncate(cut.index(content.len()));
            let _ = Maze::parse(&content);
        }
    }
}
