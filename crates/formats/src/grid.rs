//! A parser for mazes drawn as text.

use crate::error::{Location, ParseError, ParseErrorKind, quoted};
use crate::rows::MAX_SIDE;

type Result<T = (), E = ParseError> = std::result::Result<T, E>;

/// A drawn maze. Rows are counted from the top and columns from the left.
#[derive(Default)]
pub(crate) struct Grid {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// `below[row][column]` is true if the cell has a wall below it.
    pub(crate) below: Vec<Vec<bool>>,
    /// `right[row][column]` is true if the cell has a wall to its right.
    pub(crate) right: Vec<Vec<bool>>,
    /// The marks drawn inside cells.
    pub(crate) cell_marks: Vec<Mark>,
    /// The marks drawn in place of posts. The post in the upper left corner is (0, 0).
    pub(crate) post_marks: Vec<Mark>,
    /// The locations of unknown walls.
    pub(crate) unknown: Vec<Location>,
}

/// The meaning of a dot in place of an inner wall.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dots {
    /// A dot means a wall, like any other character except a blank.
    Wall,
    /// A dot means an unknown wall, which is read as open.
    Unknown,
}

/// Text drawn inside a cell or in place of a post, such as `S` for the start.
pub(crate) struct Mark {
    pub(crate) row: usize,
    pub(crate) column: usize,
    /// The text of the mark, without surrounding blanks.
    pub(crate) text: String,
    location: Location,
}

impl Mark {
    pub(crate) fn error(&self, expected: &str) -> ParseError {
        ParseError::at(self.location, expected, quoted(&self.text))
    }
}

/// Parses the drawing in `text`, which starts at line `first_line` of the file.
///
/// # Errors
/// Returns an error for each gap in the outer wall. The parser stops at the first error that is not
/// a gap, and returns this error last.
pub(crate) fn parse(text: &str, first_line: usize, dots: Dots) -> Result<Grid, Vec<ParseError>> {
    let (grid, errors) = read(text, first_line, dots)?;
    if errors.is_empty() { Ok(grid) } else { Err(errors) }
}

/// Returns true if the drawing has unknown walls. The drawing may contain errors.
pub(crate) fn has_unknown(text: &str) -> bool {
    read(text, 1, Dots::Unknown).is_ok_and(|(grid, _)| !grid.unknown.is_empty())
}

/// Reads the drawing until the first error that is not a gap in the outer wall. Returns the drawing
/// and all errors found.
fn read(text: &str, first_line: usize, dots: Dots) -> Result<(Grid, Vec<ParseError>)> {
    let lines = drawing_lines(text, first_line)?;
    let pitches = pitches(&lines[0])?;
    // If posts or outer walls are dots, known inner walls may also be dots.
    let is_dotted = lines.iter().take(2).any(|line| line.at(0) == '.');
    let dots = if is_dotted { Dots::Wall } else { dots };
    let first = read_with(&lines, pitches[0], dots);
    if first.1.is_empty() {
        return Ok(first);
    }
    // If posts and walls are the same character, the first pitch that gives a maze is used.
    let mut others = pitches.iter().skip(1).map(|&other| read_with(&lines, other, dots));
    Ok(others.find(|(_, errors)| errors.is_empty()).unwrap_or(first))
}

/// Reads a drawing with a post every `pitch` characters. Returns the drawing and all errors found.
fn read_with(
    lines: &[Line],
    (pitch, columns): (usize, usize),
    dots: Dots,
) -> (Grid, Vec<ParseError>) {
    let grid = Grid { rows: lines.len() / 2, columns, ..Grid::default() };
    let mut reader = Reader { grid, gaps: Vec::new(), pitch, post: lines[0].at(0), dots };
    let read = (0..).zip(lines).try_for_each(|(index, line)| reader.read_line(line, index));
    (reader.grid, reader.gaps.into_iter().chain(read.err()).collect())
}

impl Grid {
    /// Returns the row and column of every cell.
    pub(crate) fn cells(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.columns;
        (0..self.rows).flat_map(move |row| (0..columns).map(move |column| (row, column)))
    }
}

struct Reader {
    grid: Grid,
    /// The errors for missing outer walls.
    gaps: Vec<ParseError>,
    /// The distance between adjacent posts, in characters.
    pitch: usize,
    post: char,
    dots: Dots,
}

impl Reader {
    fn read_line(&mut self, line: &Line, index: usize) -> Result {
        let row = index / 2;
        if index.is_multiple_of(2) {
            let walls = self.read_posts(line, row)?;
            if row > 0 {
                self.grid.below.push(walls);
            }
        } else {
            let walls = self.read_cells(line, row)?;
            self.grid.right.push(walls);
        }
        let width = self.grid.columns * self.pitch + 1;
        if line.characters.len() > width {
            let expected = format!("the end of the line after {} cells", self.grid.columns);
            return Err(line.error(width, &expected, &quoted(&line.rest(width))));
        }
        Ok(())
    }

    /// Reads the posts above row `row` and the walls between them.
    fn read_posts(&mut self, line: &Line, row: usize) -> Result<Vec<bool>> {
        for column in 0..=self.grid.columns {
            let at = column * self.pitch;
            match line.at(at) {
                found if found == self.post => {}
                ' ' | '-' | '|' => {
                    let expected = format!("a post {:?}", self.post);
                    return Err(line.error(at, &expected, &quoted(&line.rest(at))));
                }
                mark => {
                    let (text, location) = (mark.into(), line.location(at));
                    self.grid.post_marks.push(Mark { row, column, text, location });
                }
            }
        }
        let (length, outer) = (self.pitch - 1, row == 0 || row == self.grid.rows);
        (0..self.grid.columns)
            .map(|column| self.read_wall(line, column * self.pitch + 1, length, outer))
            .collect()
    }

    /// Reads the cells of row `row` and the wall to the right of each cell.
    fn read_cells(&mut self, line: &Line, row: usize) -> Result<Vec<bool>> {
        self.read_wall(line, 0, 1, true)?;
        let columns = self.grid.columns;
        let mut read_cell = |column| {
            let (at, right) = (column * self.pitch + 1, (column + 1) * self.pitch);
            let text: String = line.text(at, self.pitch - 1).trim().into();
            if !text.is_empty() {
                self.grid.cell_marks.push(Mark { row, column, text, location: line.location(at) });
            }
            self.read_wall(line, right, 1, column + 1 == columns)
        };
        (0..columns).map(&mut read_cell).collect()
    }

    /// Returns true if the `length` characters from index `from` mean a wall. Blanks mean an
    /// opening. With [`Dots::Unknown`], a dot (alone or between blanks) means an unknown wall.
    /// Other characters mean a wall. Adds an error to `gaps` if an outer wall is missing.
    fn read_wall(&mut self, line: &Line, from: usize, length: usize, outer: bool) -> Result<bool> {
        let drawn = line.text(from, length);
        let is_unknown = self.dots == Dots::Unknown && [".", " . "].contains(&&drawn[..]);
        let blanks = drawn.matches(' ').count();
        if !is_unknown && (1..length).contains(&blanks) && from < line.characters.len() {
            let expected = match length {
                2 => r#""--" or two spaces between posts"#,
                _ => r#""---" or three spaces between posts"#,
            };
            return Err(line.error(from, expected, &quoted(&drawn)));
        }
        let is_wall = blanks == 0 && !is_unknown;
        if outer && !is_wall {
            let found: String = line.characters.iter().skip(from).take(length).collect();
            let gap = line.error(from, "the outer wall", &quoted(&found));
            self.gaps.push(gap.with_kind(ParseErrorKind::OpenPerimeter));
        } else if is_unknown {
            self.grid.unknown.push(line.location(from + length / 2));
        }
        Ok(is_wall)
    }
}

/// A line of the drawing without trailing blanks, with its line number in the file.
struct Line {
    number: usize,
    characters: Vec<char>,
}

impl Line {
    /// Returns the character at `index`, or a blank if the line is too short, because trailing
    /// blanks are optional.
    fn at(&self, index: usize) -> char {
        self.characters.get(index).copied().unwrap_or(' ')
    }

    fn text(&self, from: usize, length: usize) -> String {
        (from..from + length).map(|index| self.at(index)).collect()
    }

    fn rest(&self, from: usize) -> String {
        self.characters.iter().skip(from).collect()
    }

    const fn location(&self, index: usize) -> Location {
        Location::Text { line: self.number, column: index + 1 }
    }

    fn error(&self, index: usize, expected: &str, found: &str) -> ParseError {
        ParseError::at(self.location(index), expected, found)
    }
}

/// Returns the lines of the drawing. Rows of posts alternate with rows of cells, starting and
/// ending with a row of posts. Lines after the drawing are ignored.
fn drawing_lines(text: &str, first_line: usize) -> Result<Vec<Line>> {
    let mut following = (first_line..)
        .zip(text.lines())
        .map(|(number, content)| Line { number, characters: content.trim_end().chars().collect() })
        .filter(|line| !line.characters.is_empty())
        .peekable();
    let mut lines: Vec<Line> = Vec::new();
    while let Some(line) = following.next() {
        if lines.len() % 2 == 1 && !continues(&line, &lines, following.peek()) {
            break;
        }
        let unprintable = |c: &char| c.is_control() || *c == char::REPLACEMENT_CHARACTER;
        if let Some(index) = line.characters.iter().position(unprintable) {
            let found = match line.at(index) {
                '\t' => "a tab".into(),
                char::REPLACEMENT_CHARACTER => "invalid UTF-8".into(),
                character => format!("{character:?}"),
            };
            return Err(line.error(index, "a maze drawn with printable characters", &found));
        }
        if lines.is_empty() {
            pitches(&line)?;
        }
        if lines.len() > 2 * MAX_SIDE {
            return Err(line.error(0, "at most 32 rows of cells", "one more"));
        }
        lines.push(line);
    }
    let after = lines.last().map_or(first_line, |last| last.number + 1);
    match lines.len() {
        0 => Err(ParseError::new(first_line, 1, "a maze", "the end of the file")),
        1 => Err(ParseError::new(after, 1, "a row of cells between outer walls", "none")),
        count if count % 2 == 0 => {
            Err(ParseError::new(after, 1, "a row of posts", "the end of the file"))
        }
        _ => Ok(lines),
    }
}

/// Returns true if `line`, which follows a row of posts, is a row of cells rather than text after
/// the maze.
///
/// A line is a row of cells if it starts with `|` or with the same character as the first row of
/// cells. A line that starts with a blank, or is as long as a row of posts, is also a row of cells
/// if the next line is a row of posts. Looking at the next line prevents a maze with a gap in its
/// outer wall from being read as a smaller maze.
fn continues(line: &Line, lines: &[Line], next: Option<&Line>) -> bool {
    let (posts, wall) = (&lines[0], lines.get(1).map_or('|', |cells| cells.at(0)));
    let is_as_long = |line: &Line| line.characters.len() == posts.characters.len();
    let is_posts = |next: &Line| is_as_long(next) && next.at(0) == posts.at(0);
    let is_row = match line.at(0) {
        ' ' => next.is_some_and(is_posts),
        first => first == '|' || first == wall || is_as_long(line) && next.is_some_and(is_posts),
    };
    lines.len() == 1 || is_row
}

/// Infers the distance between adjacent posts (in characters) and the number of columns from the
/// first line. Returns several candidates if posts and walls are drawn with the same character.
fn pitches(line: &Line) -> Result<Vec<(usize, usize)>> {
    let post = line.at(0);
    let pitches = match line.characters.iter().skip(1).position(|&c| c == post) {
        Some(0) if line.characters.iter().all(|&c| c == post) => vec![4, 2, 3],
        Some(between @ 1..=3) => vec![between + 1],
        _ => {
            let expected = r#"a row of posts and walls such as "o---o---o""#;
            return Err(line.error(0, expected, &quoted(&line.rest(0))));
        }
    };
    let measured = |&pitch: &usize| measure(line, pitch).map(|columns| (pitch, columns));
    let possible: Vec<_> = pitches.iter().flat_map(measured).collect();
    if possible.is_empty() { measured(&pitches[0]).map(|one| vec![one]) } else { Ok(possible) }
}

/// Returns the number of columns of a maze whose first line is `line`.
fn measure(line: &Line, pitch: usize) -> Result<usize> {
    let last = line.characters.len() - 1;
    if !last.is_multiple_of(pitch) || last == 0 {
        let at = last - last % pitch;
        let expected = format!("a post {:?} every {pitch} columns", line.at(0));
        return Err(line.error(at + 1, &expected, &quoted(&line.rest(at + 1))));
    }
    if last / pitch > MAX_SIDE {
        let found = format!("{} cells", last / pitch);
        return Err(line.error(MAX_SIDE * pitch + 1, "at most 32 cells per row", &found));
    }
    Ok(last / pitch)
}
