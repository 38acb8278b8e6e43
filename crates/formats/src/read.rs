//! Reading mazes from the content of files, and from files.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;

use crate::error::ParseError;
use crate::format::Format;
use crate::grid::Dots;
use crate::parsed_maze::ParsedMaze;
use crate::rows::decode_text;
use crate::{csv, hex, maz, num, text, trial};

impl Format {
    /// Reads a maze in this format. The result also reports the assumptions that were made to read
    /// the maze.
    ///
    /// # Errors
    /// Returns an error for each contradiction between adjacent cells and for each gap in the outer
    /// wall. `read` stops at the first error that is neither a contradiction nor a gap, and returns
    /// it last.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// let errors = Format::Text.read(b"o   o\n| S |\no   o\n").unwrap_err();
    /// assert_eq!(errors.len(), 2, "two gaps in the outer wall");
    /// ```
    pub fn read(self, content: &[u8]) -> Result<ParsedMaze, Vec<ParseError>> {
        let text = &decode_text(content);
        if self != Self::Maz && text.trim().is_empty() {
            let found = if text.is_empty() { "an empty file" } else { "only blanks" };
            return Err(ParseError::new(1, 1, "a maze", found).into());
        }
        match self {
            Self::Text => text::parse(text, Dots::Wall),
            Self::Maze => text::parse(text, Dots::Unknown),
            Self::Oshwdem => text::parse_oshwdem(text).map(ParsedMaze::from),
            Self::Trial => trial::parse(text).map(ParsedMaze::from),
            Self::Num => num::parse(text).map(ParsedMaze::from),
            Self::Csv => csv::parse(text).map(ParsedMaze::from),
            Self::Hex => hex::parse(text),
            Self::Maz => maz::parse(content).map(ParsedMaze::from),
        }
    }

    /// Reads a maze in this format, like [`read`](Self::read), but returns only the maze.
    ///
    /// # Errors
    /// Returns the first error that [`read`](Self::read) returns.
    pub fn parse(self, content: &[u8]) -> Result<Maze, ParseError> {
        match self.read(content) {
            Ok(parsed) => Ok(parsed.maze),
            Err(errors) => Err(errors.into_iter().next().unwrap_or_else(|| {
                ParseError::new(1, 1, format!("a maze in the format {self}"), "none")
            })),
        }
    }
}

/// Reads a maze from the content of a file in any [`Format`].
///
/// # Errors
/// Returns the first error in the content.
///
/// ```
/// let error = mmsim_formats::parse_maze(b"o---o\n| S |\no-- o\n").unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     r#"line 3, column 2: expected "---" or three spaces between posts, found "-- ""#
/// );
/// ```
pub fn parse_maze(content: &[u8]) -> Result<Maze, ParseError> {
    Format::detect(content).parse(content)
}

/// The maximum size of a maze file, in bytes. The largest maze (32×32) drawn as text takes only
/// 8,385 bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// An error while reading a file or folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file or folder could not be opened or read, or the file is too large.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The path of the file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The content of the file is not a valid maze.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The path of the file.
        path: PathBuf,
        /// The first error in the content.
        source: ParseError,
    },
}

/// Reads a maze file in any [`Format`](crate::Format).
///
/// # Errors
/// Returns an error if the file is unreadable, too large or not a valid maze. The error contains
/// the path.
pub fn read_maze(path: &Path) -> Result<Maze, ReadError> {
    parse_maze(&read_content(path)?)
        .map_err(|source| ReadError::Parse { path: path.into(), source })
}

/// Reads the content of a maze file. The result can be passed to
/// [`Format::detect`](crate::Format::detect) and [`Format::read`](crate::Format::read).
///
/// # Errors
/// Returns an error if the file is unreadable or larger than [`MAX_FILE_BYTES`]. The error contains
/// the path.
pub fn read_content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    read_content_from(file, path)
}

/// Reads the content of a maze file from an open reader, such as standard input. `path` identifies
/// the reader in error messages.
///
/// # Errors
/// See [`read_content`].
pub fn read_content_from(reader: impl Read, path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut content = Vec::new();
    let read = reader.take(MAX_FILE_BYTES + 1).read_to_end(&mut content);
    read.map_err(|source| ReadError::Io { path: path.into(), source })?;
    if content.len() as u64 > MAX_FILE_BYTES {
        let source = io::Error::other(format!("the file is larger than {MAX_FILE_BYTES} bytes"));
        return Err(ReadError::Io { path: path.into(), source });
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use mmsim_maze::{Cell, CellSet, MazeSize, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::error::{Location, ParseErrorKind};

    #[test]
    fn files_that_are_not_mazes_are_errors() {
        let error = |content: &[u8]| parse_maze(content).unwrap_err().to_string();
        insta::assert_snapshot!(error(b""), @"line 1, column 1: expected a maze, found an empty file");
        insta::assert_snapshot!(error(b" \r\n\n\t "), @"line 1, column 1: expected a maze, found only blanks");
        insta::assert_snapshot!(error(b"\x7fELF\x02\x01\x01\x00\x00\xff\xfe\n\x00"), @r"line 1, column 1: expected a maze drawn with printable characters, found '\u{7f}'");
        insta::assert_snapshot!(error(b"# A README\n\nSome words.\n"), @r##"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "# A README""##);
        insta::assert_snapshot!(error(b"{\n  \"maze\": 1\n}\n"), @r#"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "{""#);
        insta::assert_snapshot!(error(b"hello\n"), @r#"line 1, column 1: expected a row of posts and walls such as "o---o---o", found "hello""#);
    }

    #[test]
    fn all_gaps_and_contradictions_are_reported() {
        let errors = |content: &str| -> Vec<(ParseErrorKind, Option<Cell>)> {
            let errors = Format::detect(content.as_bytes()).read(content.as_bytes()).unwrap_err();
            errors.into_iter().map(|error| (error.kind, error.cell)).collect()
        };
        let gap = (ParseErrorKind::OpenPerimeter, None);
        let unreadable = (ParseErrorKind::Unreadable, None);
        assert_eq!(errors("o   o---o\n| S .    \no---o---o\n"), [gap, gap]);
        assert_eq!(errors("o   o---o\n| S .    \no--- ---o\n"), [gap, gap, unreadable]);
        let at = |x, y| Some(Cell::new(x, y));
        assert_eq!(
            errors("2\n1,6\n4,5\n"),
            [
                (ParseErrorKind::Contradiction, at(1, 1)),
                (ParseErrorKind::Contradiction, at(1, 1)),
                (ParseErrorKind::OpenPerimeter, at(1, 0)),
                (ParseErrorKind::OpenPerimeter, at(1, 1)),
            ]
        );
    }

    fn any_maze() -> impl Strategy<Value = Maze> {
        let rows = prop::array::uniform32(any::<u32>());
        let cells = prop::collection::vec((any::<u8>(), any::<u8>()), 1..6);
        (1usize..=32, 1usize..=32, rows, rows, cells).prop_map(
            |(width, height, north, east, cells)| {
                let size = MazeSize::new(width, height).unwrap();
                let mut cells =
                    cells.into_iter().map(|(x, y)| Cell::new(x % size.width(), y % size.height()));
                let start = cells.next().unwrap();
                let walls = Walls::from_rows(size, north, east);
                Maze::new(walls, start, cells.collect::<CellSet>()).unwrap()
            },
        )
    }

    /// Generates mazes. About half of them have an arbitrary size, start and goal. The rest are
    /// square, often 16×16, and have the default start and goal, so that most formats support them.
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

    /// Reads the content in every format and checks the resulting mazes and errors.
    fn check(content: &[u8]) {
        let detected = Format::detect(content);
        assert_eq!(parse_maze(content), detected.parse(content));
        for format in Format::ALL {
            match format.read(content) {
                Ok(parsed) => {
                    assert_eq!(format.parse(content).as_ref(), Ok(&parsed.maze));
                    assert!(parsed.unknown_walls.is_empty() || format == Format::Maze);
                    assert!(parsed.ambiguous_encoding.is_none() || format == Format::Hex);
                    check_written(&parsed.maze);
                }
                Err(errors) => {
                    assert_eq!(format.parse(content).as_ref().err(), errors.first());
                    for error in &errors {
                        check_error(format, error, content);
                    }
                }
            }
        }
        check_line_ends(content, detected);
    }

    /// Writes a maze in every format that supports the maze. Checks that the format is detected and
    /// that reading returns the same maze.
    fn check_written(maze: &Maze) {
        for format in Format::ALL {
            if let Ok(content) = format.write(maze) {
                assert_eq!(Format::detect(&content), format);
                assert_eq!(parse_maze(&content).as_ref(), Ok(maze), "{format}");
            }
        }
    }

    /// Checks that an error has a one-line message and a location in the file, or just past the end
    /// of a line or of the file. In a drawing, every line is treated as if it were as long as the
    /// longest one, because trailing blanks are optional.
    fn check_error(format: Format, error: &ParseError, content: &[u8]) {
        assert!(!error.to_string().contains(char::is_control), "{error:?}");
        let Location::Text { line, column } = error.location else {
            let Location::Byte(byte) = error.location else { panic!("{error:?}") };
            let area = MazeSize::CLASSIC.area();
            assert!(format == Format::Maz && (1..=area + 1).contains(&byte), "{error}");
            return;
        };
        let text = decode_text(content);
        let lengths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        assert!((1..=lengths.len() + 1).contains(&line), "{error} in {} lines", lengths.len());
        let length = match format {
            Format::Text | Format::Maze | Format::Oshwdem => lengths.iter().max(),
            _ => lengths.get(line - 1),
        };
        assert!((1..=length.map_or(0, |&length| length) + 1).contains(&column), "{error}");
    }

    /// Checks that neither the line endings nor a byte order mark affects the detected format or
    /// the result.
    fn check_line_ends(content: &[u8], format: Format) {
        let Ok(text) = str::from_utf8(content) else { return };
        if format == Format::Maz || text.contains(['\r', '\u{feff}']) {
            return;
        }
        for line_end in ["\r\n", "\r"] {
            let same = format!("\u{feff}{}", text.replace('\n', line_end));
            assert_eq!(Format::detect(same.as_bytes()), format);
            assert_eq!(format.read(same.as_bytes()), format.read(content));
        }
    }

    proptest! {
        #[test]
        fn written_mazes_read_back(maze in likely_maze()) {
            check_written(&maze);
        }

        #[test]
        fn drawings_parse_from_files_and_from_strings(maze in any_maze()) {
            let text = maze.to_string();
            let parsed = Format::Text.read(text.as_bytes());
            prop_assert_eq!(parsed, Ok(ParsedMaze::from(maze.clone())));
            prop_assert_eq!(text.parse(), Ok(maze));
        }

        #[test]
        fn line_ends_and_trailing_blanks_are_ignored(
            maze in any_maze(),
            ends in prop::collection::vec(0usize..5, 70),
        ) {
            let mut text = String::new();
            for (line, end) in maze.to_string().lines().zip(ends.iter().cycle()) {
                text += line;
                text += ["\n", "\r\n", "  \t\n", "\r\n  \n\n", "\r"][*end];
            }
            prop_assert_eq!(parse_maze(text.as_bytes()), Ok(maze));
        }

        #[test]
        fn any_bytes_are_a_maze_or_have_located_errors(
            content in prop::collection::vec(any::<u8>(), 0..300),
        ) {
            check(&content);
        }

        #[test]
        fn any_table_is_a_maze_or_has_located_errors(
            content in "([0-9a-f]{1,2}[,; \n.]){1,60}",
        ) {
            check(content.as_bytes());
        }

        #[test]
        fn a_damaged_file_is_a_maze_or_has_located_errors(
            maze in likely_maze(),
            format in any::<prop::sample::Index>(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
            cut in any::<prop::sample::Index>(),
        ) {
            let format = Format::ALL[format.index(Format::ALL.len())];
            let mut content = format.write(&maze).unwrap_or_else(|_| maze.to_string().into());
            for (index, byte) in damage {
                let index = index.index(content.len());
                content[index] = byte;
            }
            check(&content);
            content.truncate(cut.index(content.len()));
            check(&content);
        }
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = |name: &str| {
            let error = read_maze(&folder.path().join(name)).unwrap_err().to_string();
            error.replace(&*folder.path().to_string_lossy(), "FOLDER").replace('\\', "/")
        };
        fs::write(folder.path().join("maze.txt"), "o---o\n| S |\no-- o\n").unwrap();
        fs::write(folder.path().join("large"), vec![b' '; (1 << 20) + 1]).unwrap();
        insta::assert_snapshot!(error("maze.txt"), @r#"FOLDER/maze.txt: line 3, column 2: expected "---" or three spaces between posts, found "-- ""#);
        insta::assert_snapshot!(error("large"), @"cannot read FOLDER/large: the file is larger than 1048576 bytes");
        assert!(error("missing").starts_with("cannot read FOLDER/missing: "));
        assert!(error("").starts_with("cannot read "), "a folder is not a file");
    }
}
