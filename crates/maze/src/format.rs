//! Maze file formats, told from their content.
use std::fmt;
use std::str::FromStr;

use error::quoted;

use crate::{Cell, CellSet, Maze, MazeSize, Walls};

mod csv;
mod detect;
mod error;
mod grid;
mod hex;
mod maz;
mod maze;
mod num;
mod oshwdem;
mod rows;
mod stated;
mod text;
mod trial;
mod write;

pub use error::{FormatNameError, ParseError, ParseErrorKind, Place, WriteError};

/// A way to write a maze down. Where a format marks no start it is (0, 0), and where it marks no
/// goal the goal is the central cells ([`MazeSize::central_cells`]). Lines of a text may end in
/// `\n`, `\r\n` or `\r`.
///
/// ```
/// use mmsim_maze::{Format, Maze};
/// let maze: Maze = "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse()?;
/// assert!(Format::Num.write(&maze).is_err(), "it marks no goal");
/// assert_eq!(Format::Text.write(&maze)?, maze.to_string().into_bytes());
/// assert_eq!("num".parse(), Ok(Format::Num));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// optional: the start is (0, 0) and the goal the central cells unless marked. Blank lines and
    /// trailing blanks are ignored, missing trailing blanks supplied, and text may follow after
    /// the last line of the maze.
    Text,
    /// The same with ` . ` or `.` in place of an inner wall that nobody knows of, as kerikun11's
    /// micromouse library writes its `.maze` files. Such a wall is taken as open. Where posts or
    /// outer walls are dots, dots are walls.
    Maze,
    /// What the OSHWDEM maze generator writes: a first line that starts with `OSHWDEM`, then the
    /// maze drawn with `A` in the start cell and `B` in place of the post in the middle of the
    /// goal. Its axes are turned: file right is north, file down is east.
    Oshwdem,
    /// The maze of the two-run trial: the even side n, then n lines of n comma-separated numbers,
    /// line = column from the west, number = cell from the south, bits 1 north, 2 east, 4 south
    /// and 8 west, each set where the way is open.
    Trial,
    /// 256 bytes, those of the cells of a 16×16 maze: the columns from the west, each from the
    /// south; bits 1 north, 2 east, 4 south and 8 west, each set where there is a wall.
    Maz,
    /// A line for each cell, in any order: x, y, and 1 for a wall or 0 for none to the north,
    /// east, south and west, parted by blanks. The largest x and y give the size.
    Num,
    /// The table of the Python simulators: the rows from the north, the cells of each from the
    /// west, parted by commas, semicolons or blanks. The codes from 1 to 16 are walls W, N, E, S,
    /// SW, SE, NE, NW, WE, NS, SWE, NSE, NWE, NSW, none, all. They may be written as floats.
    Csv,
    /// Rows of hex digits, a digit a cell, with or without commas or blanks between or `0x` or `0X`
    /// before each. How they lie and what the bits mean is found out: taken is what does not
    /// contradict itself, has all outer walls, and a start cell (0, 0) that is open to the north only.
    ///
    /// Should several mazes fit, taken is one whose goal can be reached, and of these the first in
    /// this order. The bits 1, 2, 4, 8 stand for north, east, south, west; for east, north, west,
    /// south. For each of these, they are set for walls, then for openings. For each of these, the
    /// lines are rows from the north, each from the west; columns from the west, each from the south;
    /// rows from the north, from the east; from the south, from the west; from the south, from the
    /// east; columns from the west, from the north; from the east, from the south; from the east,
    /// from the north. After all these, for each of the same lies of the lines, the bits are in the
    /// other orders as in a dictionary with the letters north, east, south, west; for each of these
    /// set for walls, then for openings. [`Reading::ambiguous_way`] tells that several fit.
    Hex,
}

/// A maze as it was read from a file, with what the reader had to take for granted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The maze.
    pub maze: Maze,
    /// Where it is unknown whether there is a wall: these are taken as open.
    pub unknown_walls: Vec<Place>,
    /// The way in which the content was read, in words, if it may be read as other mazes as well.
    ///
    /// ```
    /// use mmsim_maze::Format;
    /// let way = |content: &[u8]| Format::Hex.read(content).map(|reading| reading.ambiguous_way);
    /// assert_eq!(way(b"9113\nec46\n"), Ok(None));
    /// let taken = "rows from the north, each from the west, bits 1 2 4 8 walls north east south west";
    /// assert_eq!(way(b"9153\nec7e\n"), Ok(Some(taken.into())));
    /// ```
    pub ambiguous_way: Option<String>,
}

impl Reading {
    /// Of a maze that nothing had to be taken for granted of.
    const fn of(maze: Maze) -> Self {
        Self { maze, unknown_walls: Vec::new(), ambiguous_way: None }
    }
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 8] = [
        Self::Text,
        Self::Maze,
        Self::Oshwdem,
        Self::Trial,
        Self::Maz,
        Self::Num,
        Self::Csv,
        Self::Hex,
    ];

    /// Its name, by which [`str::parse`] knows it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Maze => "maze",
            Self::Oshwdem => "oshwdem",
            Self::Trial => "trial",
            Self::Maz => "maz",
            Self::Num => "num",
            Self::Csv => "csv",
            Self::Hex => "hex",
        }
    }

    /// Whether mazes can be written in it, too.
    pub const fn is_writable(self) -> bool {
        matches!(self, Self::Text | Self::Trial | Self::Maz | Self::Num)
    }

    /// The format of this content: what it looks like, whether it can be read or not.
    ///
    /// ```
    /// use mmsim_maze::Format;
    /// assert_eq!(Format::detect(b"o---o\n| S |\no---o\n"), Format::Text);
    /// assert_eq!(Format::detect(b"2\n1,3\n4,12\n"), Format::Trial);
    /// ```
    pub fn detect(content: &[u8]) -> Self {
        detect::format(content)
    }

    /// Reads a maze that is in this format, with all there is to say of it.
    ///
    /// # Errors
    /// Content that is empty, truncated, contradictory, too large or no maze at all, with its
    /// place. Of contradictions and gaps in the outer wall there may be several, of anything else
    /// only the first.
    ///
    /// ```
    /// use mmsim_maze::Format;
    /// let errors = Format::Text.read(b"o   o\n| S |\no   o\n").unwrap_err();
    /// assert_eq!(errors.len(), 2, "two gaps in the outer wall");
    /// ```
    pub fn read(self, content: &[u8]) -> Result<Reading, Vec<ParseError>> {
        let text = &text_of(content);
        if self != Self::Maz && text.trim().is_empty() {
            let found = if content.is_empty() { "an empty file" } else { "only blanks" };
            return Err(ParseError::new(1, 1, "a maze", found).into());
        }
        match self {
            Self::Text => text::read(text),
            Self::Maze => maze::read(text),
            Self::Oshwdem => oshwdem::parse(text).map(Reading::of),
            Self::Trial => trial::parse(text).map(Reading::of),
            Self::Num => num::parse(text).map(Reading::of),
            Self::Csv => csv::parse(text).map(Reading::of),
            Self::Hex => hex::read(text),
            Self::Maz => maz::parse(content).map(Reading::of),
        }
    }

    /// Reads a maze that is in this format, whatever it looks like.
    ///
    /// # Errors
    /// The first of those of [`read`](Self::read).
    pub fn parse(self, content: &[u8]) -> Result<Maze, ParseError> {
        match self.read(content) {
            Ok(reading) => Ok(reading.maze),
            Err(errors) => Err(errors.into_iter().next().unwrap_or_else(|| {
                ParseError::new(1, 1, format!("a maze in the format {self}"), "none")
            })),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = FormatNameError;

    fn from_str(name: &str) -> Result<Self, FormatNameError> {
        let found = Self::ALL.into_iter().find(|format| format.name() == name);
        found.ok_or_else(|| FormatNameError { found: name.into() })
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
        Format::detect(content).parse(content)
    }
}

impl FromStr for Maze {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        Self::parse(text.as_bytes())
    }
}

/// The content as text without a byte order mark, with line ends of one kind: `\n`, `\r\n` and
/// `\r`, which old Macs wrote, are taken alike.
fn text_of(content: &[u8]) -> String {
    let text = String::from_utf8_lossy(content);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    text.replace("\r\n", "\n").replace('\r', "\n")
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

/// The maze of these walls in a format that marks neither start nor goal.
fn unmarked(walls: Walls) -> Result<Maze, Vec<ParseError>> {
    Ok(finish(walls, None, CellSet::EMPTY)?)
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

    /// Mazes of which most formats can hold some: small, square or 16×16, often without marks.
    fn likely_maze() -> impl Strategy<Value = Maze> {
        (any_maze(), any::<bool>(), any::<bool>()).prop_map(|(maze, classic, marked)| {
            let width = maze.size().width().into();
            let size =
                if classic { MazeSize::CLASSIC } else { MazeSize::new(width, width).unwrap() };
            let walls =
                Walls::from_rows(size, *maze.walls().north_rows(), *maze.walls().east_rows());
            if marked {
                return maze;
            }
            Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap()
        })
    }

    #[test]
    fn names_are_read_back() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
        }
        insta::assert_snapshot!("png".parse::<Format>().unwrap_err(), @r#"expected one of text, maze, oshwdem, trial, maz, num, csv, hex, found "png""#);
    }

    #[test]
    fn what_a_format_cannot_hold_is_told() {
        let written = |format: Format, text: &str| {
            let maze: Maze = text.parse().unwrap();
            format.write(&maze).map_or_else(|error| error.to_string(), |_| "written".into())
        };
        let row = "o---o---o\n|       |\no---o---o\n";
        insta::assert_snapshot!(written(Format::Num, row), @"written");
        insta::assert_snapshot!(written(Format::Maz, row), @"maz holds mazes of 16x16 cells, found one of 2x1");
        insta::assert_snapshot!(written(Format::Trial, row), @"trial holds mazes of as many cells each way, an even number, found one of 2x1");
        insta::assert_snapshot!(written(Format::Num, &row.replace("      |", "    S |")), @"num marks no start: expected it at (0, 0), found it at (1, 0)");
        insta::assert_snapshot!(written(Format::Num, &row.replace("|    ", "| G  ")), @"num marks no goal: expected the central cells (0, 0) (1, 0), found (0, 0)");
        insta::assert_snapshot!(written(Format::Hex, row), @"expected a format that can be written, text, trial, maz, num, found hex");
    }

    #[test]
    fn all_gaps_and_contradictions_are_told() {
        let faults = |content: &str| -> Vec<(ParseErrorKind, Option<Cell>)> {
            let errors = Format::detect(content.as_bytes()).read(content.as_bytes()).unwrap_err();
            errors.into_iter().map(|error| (error.kind, error.cell)).collect()
        };
        let gap = (ParseErrorKind::OpenPerimeter, None);
        let wrong = (ParseErrorKind::Unreadable, None);
        assert_eq!(faults("o   o---o\n| S .    \no---o---o\n"), [gap, gap]);
        assert_eq!(faults("o   o---o\n| S .    \no--- ---o\n"), [gap, gap, wrong]);
        let at = |x, y| Some(Cell::new(x, y));
        assert_eq!(
            faults("2\n1,6\n4,5\n"),
            [
                (ParseErrorKind::Contradiction, at(1, 1)),
                (ParseErrorKind::Contradiction, at(1, 1)),
                (ParseErrorKind::OpenPerimeter, at(1, 0)),
                (ParseErrorKind::OpenPerimeter, at(1, 1)),
            ]
        );
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(maze in likely_maze()) {
            for format in Format::ALL {
                if let Ok(content) = format.write(&maze) {
                    prop_assert_eq!(Format::detect(&content), format);
                    prop_assert_eq!(&Maze::parse(&content).unwrap(), &maze);
                }
            }
        }

        #[test]
        fn any_bytes_give_a_maze_or_an_error_in_every_format(content in prop::collection::vec(any::<u8>(), 0..300)) {
            for format in Format::ALL {
                let _ = format.read(&content);
            }
        }

        #[test]
        fn tables_give_a_maze_or_an_error(content in "([0-9a-f]{1,2}[,; \n.]){1,60}") {
            for format in Format::ALL {
                let _ = format.read(content.as_bytes());
            }
            let _ = Maze::parse(content.as_bytes());
        }

        #[test]
        fn what_is_drawn_reads_back(maze in any_maze()) {
            prop_assert_eq!(&maze.to_string().parse::<Maze>().unwrap(), &maze);
        }

        #[test]
        fn line_ends_and_blanks_do_not_matter(maze in any_maze(), blank in prop::collection::vec(0usize..5, 70)) {
            let mut text = String::new();
            for (line, blank) in maze.to_string().lines().zip(blank.iter().cycle()) {
                text += line;
                text += ["\n", "\r\n", "  \t\n", "\r\n  \n\n", "\r"][*blank];
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
