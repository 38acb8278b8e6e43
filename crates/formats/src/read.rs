//! Reading mazes from the content of files, and from files.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mmsim_maze::Maze;

use crate::encoding::{Bits, Encoding, Rows};
use crate::error::{Location, ParseError, ParseErrorKind, quoted};
use crate::parsed_maze::ParsedMaze;
use crate::{cells, drawing, numbers};

/// The encodings of numbers that a file may have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice {
    /// The meaning of the bits, or `None` if it is unknown.
    pub bits: Option<Bits>,
    /// The order of the numbers, or `None` if it is unknown.
    pub rows: Option<Rows>,
}

impl Choice {
    /// Returns true if the choice includes an encoding.
    pub(crate) fn allows(self, encoding: Encoding) -> bool {
        self.bits.is_none_or(|bits| bits == encoding.bits)
            && self.rows.is_none_or(|rows| rows == encoding.rows)
    }

    /// Reads a maze from the content of a file.
    ///
    /// # Errors
    /// Returns an error for each contradiction between adjacent cells and for each gap in the outer
    /// wall, or the first error of another kind.
    ///
    /// ```
    /// use mmsim_formats::{Choice, ParseErrorKind};
    /// let errors = Choice::default().read(b"o   o\n| S |\no   o\n").unwrap_err();
    /// assert_eq!(errors.len(), 2, "two gaps in the outer wall");
    ///
    /// let digits = b"b93\neee\n";
    /// let error = Choice::default().read(digits).unwrap_err().remove(0);
    /// assert_eq!(error.kind, ParseErrorKind::Ambiguous);
    /// let choice = Choice { rows: Some("north".parse()?), ..Choice::default() };
    /// assert!(choice.read(digits).is_ok());
    /// # Ok::<(), mmsim_formats::EncodingError>(())
    /// ```
    pub fn read(self, content: &[u8]) -> Result<ParsedMaze, Vec<ParseError>> {
        if let Some(parsed) = numbers::parse_bytes(content, self) {
            return parsed;
        }
        let text = String::from_utf8_lossy(content).replace("\r\n", "\n").replace('\r', "\n");
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        if let Some(parsed) = cells::parse(text) {
            return parsed;
        }
        match (numbers::parse_text(text, self), drawing::parse(text)) {
            // Digits may also be the posts and walls of a drawing.
            (Some(Err(errors)), drawn) if errors[0].kind != ParseErrorKind::Ambiguous => {
                drawn.filter(Result::is_ok).unwrap_or(Err(errors))
            }
            (Some(parsed), _) | (None, Some(parsed)) => parsed,
            (None, None) => {
                let first = text.lines().find(|line| !line.trim().is_empty());
                let found = first.map_or("nothing".into(), quoted);
                let expected = "a maze: a drawing, a number for each cell, or a line for each cell";
                let error = ParseError::new(Location::FIRST, expected, found);
                Err(ParseError { kind: ParseErrorKind::NotAMaze, ..error }.into())
            }
        }
    }
}

/// Reads a maze from the content of a file.
///
/// # Errors
/// Returns the first error in the content.
///
/// ```
/// let error = mmsim_formats::parse_maze(b"o---o\n| S |\no-- o\n").unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     r#"line 3, column 2: expected a wall or blanks, found "-- ""#
/// );
/// ```
pub fn parse_maze(content: &[u8]) -> Result<Maze, ParseError> {
    let parsed = Choice::default().read(content);
    parsed.map(|parsed| parsed.maze).map_err(|mut errors| errors.swap_remove(0))
}

/// The maximum size of a maze file, in bytes. The largest maze (32×32) drawn as text takes only
/// 8,385 bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 20;

/// An error while reading a file or folder.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file or folder could not be opened or read, or the file is too large.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The path of the file or folder.
        path: PathBuf,
        /// The cause.
        source: Arc<io::Error>,
    },
    /// The content of the file is not a valid maze.
    #[error("{}: {}", path.display(), errors[0])]
    Parse {
        /// The path of the file.
        path: PathBuf,
        /// The errors in the content, at least one.
        errors: Vec<ParseError>,
    },
}

impl ReadError {
    /// Returns the mazes that the numbers of an ambiguous file could mean.
    pub fn readings(&self) -> &[ParsedMaze] {
        match self {
            Self::Parse { errors, .. } => &errors[0].readings,
            Self::Io { .. } => &[],
        }
    }

    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.into(), source: Arc::new(source) }
    }
}

/// Reads a maze file.
///
/// # Errors
/// Returns an error if the file is unreadable, too large or not a valid maze. The error contains
/// the path.
pub fn read_maze(path: &Path) -> Result<Maze, ReadError> {
    let parsed = Choice::default().read(&read_content(path)?);
    let error = |errors| ReadError::Parse { path: path.into(), errors };
    parsed.map(|parsed| parsed.maze).map_err(error)
}

/// Reads the content of a maze file, for [`Choice::read`].
///
/// # Errors
/// Returns an error if the file is unreadable or larger than [`MAX_FILE_BYTES`]. The error contains
/// the path.
pub fn read_content(path: &Path) -> Result<Vec<u8>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::io(path, source))?;
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
    read.map_err(|source| ReadError::io(path, source))?;
    if content.len() as u64 > MAX_FILE_BYTES {
        let message = format!("the file is larger than {MAX_FILE_BYTES} bytes");
        let source = io::Error::new(io::ErrorKind::FileTooLarge, message);
        return Err(ReadError::io(path, source));
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Walls};
    use proptest::prelude::*;
    use proptest::sample::{Index, select};

    use super::*;
    use crate::format::Format;

    #[test]
    fn files_that_are_not_mazes_are_errors() {
        let error = |content: &[u8]| {
            let error = parse_maze(content).unwrap_err();
            assert_eq!(error.kind, ParseErrorKind::NotAMaze);
            error.to_string()
        };
        insta::assert_snapshot!(error(b""), @"line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found nothing");
        insta::assert_snapshot!(error(b"# A README\n\nSome words.\n"), @r##"line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found "# A README""##);
        for other in [
            &b" \r\n\n\t "[..],
            b"\x7fELF\x02\x01\x01\x00\x00\xff\xfe\n\x00",
            b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR",
            b"{\n  \"maze\": 1\n}\n",
            b"hello\n",
            b"17\n",
            b"import sys\nprint(\"hello\")\nprint(\"3\")\nprint(input())\n",
            b"o---o\n|   |\n",
            b"1,2,3\n4,5,6\n7,8,9\n",
            b"1,1,1\n1,1,1\n1,1,1\n",
            b"0\n",
            b"0x\n",
            b"{0x}\n",
            b"9553\n0x\naaaa\n",
        ] {
            error(other);
        }
        assert_eq!(parse_maze(&[b'\n'; 256]).unwrap_err().kind, ParseErrorKind::NotAMaze);
    }

    #[test]
    fn all_gaps_and_contradictions_are_reported() {
        let errors = |content: &str| -> Vec<(ParseErrorKind, Option<Cell>)> {
            let errors = Choice::default().read(content.as_bytes()).unwrap_err();
            errors.into_iter().map(|error| (error.kind, error.cell)).collect()
        };
        let gap = (ParseErrorKind::OpenPerimeter, None);
        let unreadable = (ParseErrorKind::Unreadable, None);
        assert_eq!(errors("o   o---o\n| S .    \no---o---o\n"), [gap, gap]);
        assert_eq!(errors("o   o---o\n| S .    \no--- ---o\n"), [gap, gap]);
        assert_eq!(errors("o   o---o\n| S .    \no-- o---o\n"), [gap, gap, unreadable]);
        let at = |x, y| Some(Cell::new(x, y));
        assert_eq!(
            errors("2\n1,6\n4,5\n"),
            [
                (ParseErrorKind::Contradiction, at(1, 1)),
                (ParseErrorKind::OpenPerimeter, at(1, 0)),
                (ParseErrorKind::Contradiction, at(1, 1)),
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

    /// Returns a maze with the default goal, and the start (0, 0) open only to the north.
    fn unmarked(maze: &Maze) -> Maze {
        let mut walls = maze.walls().clone();
        walls.set(Cell::new(0, 0), Heading::North, false);
        walls.set(Cell::new(0, 0), Heading::East, true);
        Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap()
    }

    /// Generates mazes, half of them with the default start and goal, which most formats require.
    fn likely_maze() -> impl Strategy<Value = Maze> {
        (any_maze(), any::<bool>()).prop_map(
            |(maze, is_marked)| {
                if is_marked { maze } else { unmarked(&maze) }
            },
        )
    }

    /// Checks that a maze is the same after writing and reading it in every format.
    fn check_written(maze: &Maze) {
        for format in Format::ALL {
            if let Ok(content) = format.write(maze) {
                let parsed = Choice::default().read(&content);
                let parsed =
                    parsed.unwrap_or_else(|errors| panic!("{format:?}: {}\n{maze}", errors[0]));
                assert_eq!(parsed.maze, *maze, "{format:?}");
                assert_eq!(parsed.notes, [], "{format:?}");
            }
        }
    }

    /// Reads the content, and checks the resulting maze or errors. A location of an error is in the
    /// file, or just past the end of a line or of the file.
    fn check(content: &[u8]) {
        let parsed = Choice::default().read(content);
        let text = String::from_utf8_lossy(content);
        if !text.contains(['\r', '\u{feff}']) && text.contains('\n') && content.len() != 256 {
            for line_end in ["\r\n", "\r"] {
                let same = format!("\u{feff}{}", text.replace('\n', line_end));
                let same = Choice::default().read(same.as_bytes());
                assert_eq!(same.map(|it| it.maze), parsed.clone().map(|it| it.maze));
            }
        }
        let errors = match parsed {
            Ok(parsed) => return check_written(&parsed.maze),
            Err(errors) => errors,
        };
        assert_eq!(parse_maze(content).as_ref().err(), errors.first());
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let lengths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
        for error in &errors {
            let first = error.to_string().lines().next().map(str::to_string).unwrap();
            assert!(!first.contains(char::is_control), "{error:?}");
            match error.location {
                Location::Byte(byte) => assert!((1..=content.len() + 1).contains(&byte), "{error}"),
                Location::Text { line, column } => {
                    assert!((1..=lengths.len() + 1).contains(&line), "{error}");
                    // The blanks at the ends of the lines of a drawing may be missing.
                    let length = lengths.iter().max().map_or(0, |&length| length);
                    assert!((1..=length + 1).contains(&column), "{error} in {text}");
                }
            }
        }
    }

    /// The look of a drawing.
    #[derive(Debug)]
    struct Style {
        pitch: usize,
        /// The characters of posts, and of walls above and beside a cell.
        characters: (char, char, char),
        indent: usize,
        title: &'static str,
        below: &'static str,
        /// Whether a row of text stands to the right of the drawing.
        is_labelled: bool,
        lower_case: bool,
        /// Characters that replace posts, and that are put into cells without a mark.
        posts: Vec<(Index, char)>,
        cells: Vec<(Index, &'static str)>,
    }

    fn any_style() -> impl Strategy<Value = Style> {
        let characters = [
            ('o', '-', '|'),
            ('+', '-', '|'),
            ('+', '=', '!'),
            ('.', '-', '|'),
            ('·', '─', '│'),
            ('#', '#', '#'),
            (' ', '_', '|'),
            ('*', '~', ':'),
            ('o', '-', 'I'),
            ('█', '█', '█'),
        ];
        let post = (any::<Index>(), select(vec!['.', 'A', 'G', ' ', '+', '|', '-', 'x']));
        let cell = (any::<Index>(), select(vec!["7", "|", "x", "12", "F", "*", "^", "255"]));
        (
            2usize..=9,
            select(characters.to_vec()),
            0usize..4,
            select(vec!["", "Japan 1987\n", "My maze\n=======\n\n", "16\n", "; a comment\n"]),
            select(vec!["", "\nofficial: 2 goals\n", "the same again\n| and more\n"]),
            any::<(bool, bool)>(),
            prop::collection::vec(post, 0..3),
            prop::collection::vec(cell, 0..3),
        )
            .prop_map(
                |(
                    pitch,
                    characters,
                    indent,
                    title,
                    below,
                    (is_labelled, lower_case),
                    posts,
                    cells,
                )| {
                    Style {
                        pitch,
                        characters,
                        indent,
                        title,
                        below,
                        is_labelled,
                        lower_case,
                        posts,
                        cells,
                    }
                },
            )
    }

    /// Draws a maze in a style.
    fn drawn(maze: &Maze, style: &Style) -> String {
        let (post, above, beside) = style.characters;
        let (width, height) = (usize::from(maze.size().width()), usize::from(maze.size().height()));
        let mut grid = vec![vec![' '; width * style.pitch + 1]; 2 * height + 1];
        for cell in maze.size().cells() {
            let (left, row) =
                (usize::from(cell.x) * style.pitch, 2 * (height - 1 - usize::from(cell.y)) + 1);
            let centre = left + style.pitch / 2;
            let mut mark = String::new();
            mark += if maze.start().cell == cell { "S" } else { "" };
            mark += if maze.goals().contains(cell) { "G" } else { "" };
            if style.lower_case {
                mark = mark.to_lowercase();
            }
            let first = left + 1 + (style.pitch - 1).saturating_sub(mark.len()) / 2;
            mark.chars().zip(first..left + style.pitch).for_each(|(c, at)| grid[row][at] = c);
            for heading in Heading::ALL {
                let has = maze.walls().has(cell, heading);
                match heading {
                    Heading::North if has => {
                        grid[row - 1][left + 1..left + style.pitch].fill(above);
                    }
                    Heading::South if has => {
                        grid[row + 1][left + 1..left + style.pitch].fill(above);
                    }
                    Heading::East if has => grid[row][left + style.pitch] = beside,
                    Heading::West if has => grid[row][left] = beside,
                    _ => {}
                }
            }
            for (row, at) in [
                (row - 1, left),
                (row + 1, left),
                (row - 1, left + style.pitch),
                (row + 1, left + style.pitch),
            ] {
                grid[row][at] = post;
            }
            let _ = centre;
        }
        for (index, text) in &style.cells {
            let index = index.index(width * height);
            let (row, left) = (2 * (index / width) + 1, index % width * style.pitch);
            if grid[row][left + 1..left + style.pitch].iter().all(|c| *c == ' ') {
                text.chars()
                    .zip(left + 1..left + style.pitch)
                    .for_each(|(c, at)| grid[row][at] = c);
            }
        }
        // Blocks have no posts to decorate, and most posts must be plain.
        let decorated = if post == above { 0 } else { (width + 1) * (height + 1) / 8 };
        for (index, character) in style.posts.iter().take(decorated) {
            let index = index.index((width + 1) * (height + 1));
            grid[2 * (index / (width + 1))][index % (width + 1) * style.pitch] = *character;
        }
        let mut text = style.title.to_string();
        for (row, line) in grid.into_iter().enumerate() {
            let line: String = line.into_iter().collect();
            let label =
                if style.is_labelled && row % 2 == 1 { format!("  {row}") } else { String::new() };
            let indent = " ".repeat(style.indent);
            text.extend([&indent, &line, &label, "\n"]);
        }
        text + style.below
    }

    proptest! {
        /// With two columns a cell, a mark of start and goal does not fit.
        #[test]
        fn decorated_drawings_are_equal_or_ambiguous(maze in any_maze(), style in any_style()) {
            // In a tiny drawing, decoration may outweigh the rest.
            let size = maze.size();
            prop_assume!(size.width().min(size.height()) > 3);
            let goals: CellSet = maze.goals().iter().filter(|goal| *goal != maze.start().cell).collect();
            let maze = if style.pitch == 2 { Maze::new(maze.walls().clone(), maze.start().cell, goals).unwrap() } else { maze };
            let maze = if maze.goals().contains(maze.start().cell) && style.pitch == 2 { return Ok(()) } else { maze };
            let text = drawn(&maze, &style);
            // Without posts, a row without walls between its cells is a blank line.
            if style.characters.0 == ' ' && text.trim_end().lines().skip(1).any(|line| line.trim().is_empty()) {
                return Ok(());
            }
            match Choice::default().read(text.as_bytes()) {
                Ok(parsed) => prop_assert_eq!(parsed.maze.to_string(), maze.to_string(), "{}", text),
                Err(errors) => prop_assert!(errors[0].expected.contains("wide"), "{}\n{text}", errors[0]),
            }
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
            let parsed = Choice::default().read(text.as_bytes());
            prop_assert_eq!(parsed.map(|parsed| parsed.maze), Ok(maze.clone()));
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
        insta::assert_snapshot!(error("maze.txt"), @r#"FOLDER/maze.txt: line 3, column 2: expected a wall or blanks, found "-- ""#);
        insta::assert_snapshot!(error("large"), @"cannot read FOLDER/large: the file is larger than 1048576 bytes");
        assert!(error("missing").starts_with("cannot read FOLDER/missing: "));
        assert!(error("").starts_with("cannot read "), "a folder is not a file");
    }
}
