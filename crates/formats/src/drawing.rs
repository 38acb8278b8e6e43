//! Mazes drawn as text: posts at a regular distance, and walls between them.
//!
//! Only the places between two posts are read as walls, and only `S`, `G` and both, in either case,
//! as marks of cells. The rest of a drawing may be anything, and becomes a note.

use std::ops::Range;

use mmsim_maze::{Cell, CellSet, Heading, Maze, Symmetry, Walls};

use crate::error::{Location, Note, NoteKind, ParseError, ParseErrorKind, quoted};
use crate::parsed_maze::{MAX_SIDE, Notation, ParsedMaze, maze, size};

/// The maximum distance between adjacent posts in characters.
const MAX_PITCH: usize = 32;

/// The maximum number of lines that are tried as the upper outer wall.
const MAX_TOPS: usize = 64;

/// Reads the drawing in `text`. Returns `None` if `text` has no grid of posts and walls.
pub(crate) fn parse(text: &str) -> Option<Result<ParsedMaze, Vec<ParseError>>> {
    let line = |(number, text)| Line { number, characters: str::trim_end(text).chars().collect() };
    let lines = (1..).zip(text.lines()).map(line);
    let lines: Vec<Line> = lines.filter(|line| !line.characters.is_empty()).collect();
    let is_rotated = lines.first()?.text(&(0..7)) == "OSHWDEM";
    let lines = &lines[usize::from(is_rotated)..];
    Some(find(lines)?.map_err(Vec::from).and_then(|frame| {
        let title = &lines[..lines.len() - frame.lines.len()];
        let mut notes =
            title.iter().map(|line| line.ignored(&(0..line.characters.len()))).collect();
        let maze = frame.read(is_rotated, &mut notes)?;
        Ok(ParsedMaze { maze, notation: Notation::Drawing, encodings: Vec::new(), notes })
    }))
}

/// A line that is not blank, without trailing blanks, with its line number in the file.
struct Line {
    number: usize,
    characters: Vec<char>,
}

impl Line {
    /// Returns the character at `index`, or a blank beyond the end of the line.
    fn at(&self, index: usize) -> char {
        self.characters.get(index).copied().unwrap_or(' ')
    }

    /// Returns the post at `index`. The corners, crossings and lines of boxes count as equal.
    fn post(&self, index: usize) -> char {
        let post = self.at(index);
        if ('─'..='╿').contains(&post) { '┼' } else { post }
    }

    fn text(&self, span: &Range<usize>) -> String {
        span.clone().map(|index| self.at(index)).collect()
    }

    const fn location(&self, index: usize) -> Location {
        Location::Text { line: self.number, column: index + 1 }
    }

    fn error(&self, span: &Range<usize>, expected: &str) -> ParseError {
        let end = span.end.min(self.characters.len()).max(span.start);
        ParseError::new(self.location(span.start), expected, quoted(&self.text(&(span.start..end))))
    }

    fn ignored(&self, span: &Range<usize>) -> Note {
        Note::ignored(self.location(span.start), self.text(span).trim())
    }
}

/// What stands in the place of a wall.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Blank,
    /// A wall drawn with one character, or with several.
    Wall(Option<char>),
    /// A dot, alone or in the middle of blanks.
    Dot,
    /// A wall to some readers and an opening to others.
    Partial,
}

/// The position of a drawing in a file. A drawing has an odd number of rows and columns: posts where
/// the numbers of both are even, counted from 0, cells where both are odd, and walls between them.
#[derive(Clone, Copy, Default)]
struct Frame<'a> {
    /// The lines from the upper outer wall on.
    lines: &'a [Line],
    /// The index of the first character.
    left: usize,
    /// The distance between adjacent posts in characters.
    pitch: usize,
    last_row: usize,
    last_column: usize,
    /// The most frequent character of the posts.
    post: char,
    /// The share of posts with other characters, in per mille.
    post_faults: usize,
    /// The share of irregular walls, in per mille.
    faults: usize,
    /// True if dots are walls, because outer walls or most posts are dots.
    is_dotted: bool,
}

/// Counts equal items, of which there are few.
fn counts<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<(T, usize)> {
    let mut counts: Vec<(T, usize)> = Vec::new();
    for item in items {
        match counts.iter_mut().find(|(counted, _)| *counted == item) {
            Some((_, count)) => *count += 1,
            None => counts.push((item, 1)),
        }
    }
    counts
}

/// Finds the drawing that has the fewest irregularities. Among equals, returns the first one with the
/// widest cells.
fn find(lines: &[Line]) -> Option<Result<Frame<'_>, ParseError>> {
    let mut found: Vec<Frame> = Vec::new();
    // No line with a bar is above the drawing.
    let title = lines.iter().take_while(|line| !line.characters.contains(&'|')).count();
    for top in 0..lines.len().min(title + 1).min(MAX_TOPS) {
        let is_repeated = lines[..top].iter().any(|line| line.characters == lines[top].characters);
        for frame in frames(&lines[top..]).filter(|frame| !is_repeated && frame.is_maze()) {
            let are_walls_posts = frame.post == lines[top].at(frame.left + 1);
            if frame.faults == 0 && frame.has_posts() && !are_walls_posts {
                return Some(Ok(frame));
            }
            found.push(frame);
        }
        if found.iter().any(|frame| frame.faults == 0 || frame.has_posts()) {
            break;
        }
    }
    let rank = |it: &&Frame| it.faults + if it.faults > 0 { 300 } else { 0 } + it.post_faults;
    let &frame = found.iter().min_by_key(rank)?;
    let is_rival = |rival: &&Frame| {
        let is_clean = frame.faults + rival.faults == 0;
        is_clean && rival.pitch != frame.pitch && rival.post_faults <= frame.post_faults + 100
    };
    Some(found.iter().find(is_rival).map_or(Ok(frame), |rival| {
        let expected = format!("cells {} characters wide", frame.pitch - 1);
        let found = format!("walls and posts that also fit cells {} wide", rival.pitch - 1);
        Err(ParseError::new(frame.lines[0].location(frame.left), expected, found))
    }))
}

/// Returns the possible positions of a drawing whose upper outer wall is in the first line, widest
/// cells first.
fn frames(lines: &[Line]) -> impl Iterator<Item = Frame<'_>> {
    let top = &lines[0].characters;
    let (end, blanks) = (top.len(), top.iter().take_while(|c| c.is_whitespace()).count());
    let has_space = lines.len() > 2 && end <= blanks + (MAX_SIDE + 1) * MAX_PITCH;
    let lefts = (blanks.saturating_sub(1)..=blanks).rev().filter(move |_| has_space);
    let pitches = move |left| (2..=MAX_PITCH.min(end - left)).rev().map(move |pitch| (left, pitch));
    lefts.flat_map(pitches).flat_map(|(left, pitch)| Frame::at(lines, left, pitch))
}

impl<'a> Frame<'a> {
    /// Returns the possible numbers of columns, as positions, of a drawing whose upper outer wall is
    /// in the first line.
    fn at(lines: &'a [Line], left: usize, pitch: usize) -> impl Iterator<Item = Self> {
        let (end, post) = (lines[0].characters.len(), lines[0].at(left));
        let frame = Self { lines, left, pitch, post, ..Self::default() };
        let wall = move |cell| frame.place(0, 2 * cell + 1);
        let drawn = (0..end).take_while(|&cell| matches!(wall(cell), Place::Wall(Some(_)))).count();
        // A line whose posts are alike may lack walls.
        let posts = (left..end).step_by(pitch);
        let are_equal = post != ' ' && posts.clone().all(|at| lines[0].at(at) == post);
        let is_whole = are_equal && (end - 1 - left).is_multiple_of(pitch);
        let whole = if is_whole { posts.count() - 1 } else { drawn };
        let columns = [drawn, whole].into_iter().take(1 + usize::from(whole > drawn));
        // If each wall contains a post, the cells are narrower.
        let has_post = move |cell| lines[0].text(&frame.span(2 * cell + 1)).contains(post);
        let is_wide = move |cell| wall(cell) != Place::Wall(None) || !has_post(cell);
        let columns = columns.filter(move |&columns| (0..columns).any(is_wide));
        columns.filter_map(move |columns| Self { last_column: 2 * columns, ..frame }.measured())
    }

    /// Returns the indices of the characters in a column.
    const fn span(&self, column: usize) -> Range<usize> {
        let post = self.left + column / 2 * self.pitch;
        if column.is_multiple_of(2) { post..post + 1 } else { post + 1..post + self.pitch }
    }

    const fn right(&self) -> usize {
        self.span(self.last_column).start
    }

    /// Returns all rows and columns.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let Self { last_row, last_column, .. } = *self;
        (0..=last_row).flat_map(move |row| (0..=last_column).map(move |column| (row, column)))
    }

    const fn is_outer(&self, row: usize, column: usize) -> bool {
        row.is_multiple_of(self.last_row) || column.is_multiple_of(self.last_column)
    }

    /// Counts the rows of cells, each with a line of posts below it, and measures posts and walls.
    /// Returns `None` if there are no cells, or if the upper outer wall continues to the right.
    /// Counts at most one row of cells too many.
    fn measured(mut self) -> Option<Self> {
        let [top, cells, ..] = self.lines else { return None };
        let pairs = self.lines[1..].chunks_exact(2).take(MAX_SIDE + 1);
        self.last_row = 2 * pairs.take_while(|it| self.is_cells(&it[0], Some(&it[1]))).count();
        let posts = self.places().filter(|(row, column)| (row | column) % 2 == 0);
        let posts = posts.map(|(row, column)| self.lines[row].post(self.span(column).start));
        let (post, count) = counts(posts).into_iter().max_by_key(|(_, count)| *count)?;
        let posts = (self.last_row / 2 + 1) * (self.last_column / 2 + 1);
        (self.post, self.post_faults) = (post, (1000 * (posts - count)).div_ceil(posts));
        self.is_dotted = [top.at(self.left + 1), cells.at(self.left), post].contains(&'.');
        let is_whole = self.last_row > 0 && top.at(self.right() + 1) == ' ';
        is_whole.then(|| Self { faults: self.faults(), ..self })
    }

    /// Returns true if a line is a row of cells rather than text. The line below decides about a
    /// line without a west wall, so that a maze with a gap in its outer wall is not read as a
    /// smaller maze.
    fn is_cells(&self, line: &Line, below: Option<&Line>) -> bool {
        let (left, right) = (self.left, self.right());
        let is_same = |at| line.at(at) == self.lines[1].at(at) && line.at(at) != ' ';
        let has_wall = |at| line.at(at) == '|' || is_same(at);
        let is_as_long = line.characters.len() == right + 1;
        let is_above_posts = below.is_some_and(|below| self.is_posts(below));
        is_above_posts && (has_wall(left) || line.at(left) == ' ' || is_as_long)
            || has_wall(left) && (has_wall(right) || is_as_long)
    }

    /// Returns true if a line looks like a line of posts and walls.
    fn is_posts(&self, line: &Line) -> bool {
        let is_same = |at| line.at(at) == self.lines[0].at(at) && line.at(at) != ' ';
        let is_post = |at| is_same(at) || !line.at(at).is_alphanumeric() && line.at(at) != ' ';
        let cells = self.last_column / 2;
        let posts = (0..=cells).filter(|post| is_post(self.span(2 * post).start)).count();
        let walls = || (0..cells).map(|cell| self.place_in(line, 2 * cell + 1));
        let clean = walls().filter(|&place| place != Place::Partial).count();
        let has_wall = || walls().any(|place| place == self.place(0, 1));
        is_same(self.left) && is_same(self.right())
            || 2 * clean >= cells && (2 * posts > cells || has_wall())
    }

    fn place(&self, row: usize, column: usize) -> Place {
        self.place_in(&self.lines[row], column)
    }

    /// Returns what stands in the place of a wall.
    fn place_in(&self, line: &Line, column: usize) -> Place {
        let Range { start, end } = self.span(column);
        let is_blank = |index: &usize| line.at(*index) == ' ';
        let before = (start..end).take_while(is_blank).count();
        let after = (start..end).rev().take_while(is_blank).count();
        if before == end - start {
            return Place::Blank;
        }
        let mut drawn = start + before..end - after;
        let first = line.at(drawn.start);
        let is_partial = before != after || drawn.clone().any(|at| is_blank(&at));
        let is_dot = drawn.len() == 1 && first == '.' && !self.is_dotted;
        let is_plain = before == 0 && drawn.all(|at| line.at(at) == first);
        match (is_partial, is_dot) {
            (true, _) => Place::Partial,
            (_, true) => Place::Dot,
            _ => Place::Wall(is_plain.then_some(first)),
        }
    }

    /// Returns the share of irregular walls in per mille: gaps, partly blank walls, and walls drawn
    /// in an unusual way for their direction, either among the inner or among the outer walls.
    fn faults(&self) -> usize {
        let walls = self.places().filter(|(row, column)| (row + column) % 2 == 1);
        let walls = counts(walls.filter_map(|(row, column)| {
            let is_outer = self.is_outer(row, column);
            let drawn = match self.place(row, column) {
                Place::Blank | Place::Dot if !is_outer => return None,
                Place::Wall(drawn) => drawn,
                _ => None,
            };
            Some((is_outer, row % 2 == 0, drawn))
        }));
        let usual = |kind| {
            let drawn = walls.iter().filter(|(key, _)| (key.0, key.1) == kind && key.2.is_some());
            drawn.map(|(_, count)| *count).max().unwrap_or(0)
        };
        let kinds = [(false, false), (false, true), (true, false), (true, true)];
        let usual: usize = kinds.into_iter().map(usual).sum();
        let drawn = walls.iter().map(|(_, count)| count).sum::<usize>();
        (1000 * (drawn - usual)).div_ceil((self.last_row + 1) * (self.last_column + 1) / 2)
    }

    /// Returns true if all posts are drawn with the same character.
    const fn has_posts(&self) -> bool {
        self.post_faults == 0 && self.post != ' '
    }

    /// Returns true if the drawing is a maze, perhaps with errors, rather than other text.
    fn is_maze(&self) -> bool {
        let Self { faults, post_faults, .. } = *self;
        let mut cells = self.lines[..self.last_row].iter().skip(1).step_by(2);
        let is_blank = |line: &Line| line.text(&(self.left..self.right())).contains(' ');
        let is_table = self.lines[0].at(self.left).is_ascii_hexdigit() && !cells.any(is_blank);
        let is_clear = post_faults <= 250 && faults <= 500 && self.post != ' ';
        !is_table && (faults == 0 || post_faults <= 500 && faults <= 250 || is_clear)
    }

    /// Reads the maze, and adds notes.
    ///
    /// # Errors
    /// Returns an error for each gap in the outer wall and for each wall that is not clear.
    #[allow(clippy::cast_possible_truncation)]
    fn read(&self, is_rotated: bool, notes: &mut Vec<Note>) -> Result<Maze, Vec<ParseError>> {
        let Self { lines, last_row, last_column, .. } = *self;
        let size = size(lines[0].location(self.left), last_column / 2, last_row / 2)?;
        let mut walls = Walls::open(size);
        let (mut start, mut goals, mut errors) = (None, CellSet::EMPTY, Vec::new());
        for (row, column) in self.places() {
            let (line, span) = (&lines[row], self.span(column));
            // The cell to the lower right, if the place is above or in a row of cells.
            let y = size.height().saturating_sub((row / 2 + 1) as u8);
            let here = Cell { x: (column / 2) as u8, y };
            let mut characters = span.clone().map(|index| line.at(index));
            if characters.clone().any(|c| c.is_control() || c == char::REPLACEMENT_CHARACTER) {
                return Err(line.error(&span, "a maze drawn with printable characters").into());
            }
            let is_outer = self.is_outer(row, column);
            match (row % 2, column % 2) {
                (0, 0) if is_rotated && !is_outer && line.at(span.start) == 'B' => {
                    for (x, y) in [(1, 0), (0, 0), (1, 1), (0, 1)] {
                        goals.insert(Cell::new(here.x - x, here.y + y));
                    }
                }
                (0, 0) if [self.post, ' '].contains(&line.post(span.start)) => {}
                (1, 1) if characters.all(|c| c == ' ') => {}
                (1, 1) => {
                    let text = line.text(&span).to_uppercase();
                    let has = |mark| text.split(|c: char| !c.is_alphabetic()).any(|it| it == mark);
                    let is_start = has("S") || has("SG") || is_rotated && has("A");
                    let is_goal = has("G") || has("SG");
                    if is_start && start.replace(here).is_some() {
                        errors.push(line.error(&span, "one start"));
                    }
                    if is_goal {
                        goals.insert(here);
                    }
                    if !is_start && !is_goal || !text.trim().chars().all(char::is_alphabetic) {
                        notes.push(line.ignored(&span));
                    }
                }
                (0, 0) => notes.push(line.ignored(&span)),
                _ => match self.place(row, column) {
                    Place::Blank | Place::Dot if is_outer => {
                        let error = line.error(&span, "the outer wall");
                        errors.push(ParseError { kind: ParseErrorKind::OpenPerimeter, ..error });
                    }
                    Place::Partial => errors.push(line.error(&span, "a wall or blanks")),
                    Place::Dot => {
                        let at = line.location(span.start + span.len() / 2);
                        let (kind, text) = (NoteKind::UnknownWall, "unknown wall, read as open");
                        notes.push(Note::new(kind, at, text));
                    }
                    Place::Wall(_) if !is_outer => {
                        let heading = if row % 2 == 0 { Heading::North } else { Heading::West };
                        walls.set(here, heading, true);
                    }
                    Place::Wall(_) | Place::Blank => {}
                },
            }
        }
        if let [last] = &lines[last_row + 1..]
            && self.is_cells(last, None)
        {
            let found = "the end of the file";
            let end = Location::Text { line: last.number + 1, column: 1 };
            errors.push(ParseError::new(end, "a row of posts", found));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        for line in &lines[..=last_row] {
            let beside = [0..self.left, self.right() + 1..line.characters.len()];
            let beside = beside.iter().filter(|span| !line.text(span).trim().is_empty());
            notes.extend(beside.map(|span| line.ignored(span)));
        }
        let maze = maze(walls, start, goals)?;
        // In a drawing of OSHWDEM, north is on the right.
        Ok(if is_rotated { maze.transformed(Symmetry::Anticlockwise) } else { maze })
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Maze, MazeSize};

    use crate::error::{Location, NoteKind, ParseError};
    use crate::read::{Choice, parse_maze};

    const MAZE: &str = "\
o---o---o---o
|     G   G |
o   o---o   o
| S |       |
o---o---o---o
";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        parse_maze(text.as_bytes())
    }

    fn notes(text: &str) -> Vec<String> {
        let parsed = Choice::default().read(text.as_bytes()).unwrap();
        parsed.notes.iter().map(ToString::to_string).collect()
    }

    fn error(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn variations_are_equal() {
        let maze = parse(MAZE).unwrap();
        assert_eq!(maze.to_string(), MAZE);
        assert_eq!(*maze.goals(), [Cell::new(1, 1), Cell::new(2, 1)].into_iter().collect());
        for (what, text) in [
            ("plus signs", MAZE.replace('o', "+")),
            ("dots", MAZE.replace('o', ".")),
            ("a post outside ASCII", MAZE.replace('o', "·")),
            ("other walls", MAZE.replace('-', "=").replace('|', "!")),
            ("walls of several kinds", MAZE.replace("| S", "I S")),
            ("carriage returns", MAZE.replace('\n', "\r\n")),
            ("blank lines", MAZE.replace('\n', "\n\n")),
            ("blank lines first", "\n \n".to_string() + MAZE),
            ("no last line end", MAZE.trim_end().to_string()),
            ("a byte order mark", "\u{feff}".to_string() + MAZE),
            ("text after it", MAZE.to_string() + "\nofficial: 2 goals\n| and more\n"),
            ("text right after it", MAZE.to_string() + "official\n"),
            ("another maze after it", MAZE.to_string() + "the same again\n" + MAZE),
            ("text with bars in it", MAZE.to_string() + "  source: a|b\n  c|d\n"),
            ("text with blanks before it", MAZE.to_string() + "\n  official\no, and more\n"),
            ("two columns a cell", "+-+-+-+\n|  G G|\n+ +-+ +\n|S|   |\n+-+-+-+\n".to_string()),
            (
                "three columns a cell",
                "+--+--+--+\n|   G  G |\n+  +--+  +\n|S |     |\n+--+--+--+\n".to_string(),
            ),
        ] {
            assert_eq!(parse(&text).as_ref(), Ok(&maze), "{what}");
        }
    }

    #[test]
    fn start_and_goal_are_optional() {
        let maze = parse(&MAZE.replace(['S', 'G'], " ")).unwrap();
        assert_eq!(maze.start().cell, Cell::new(0, 0));
        assert_eq!(*maze.goals(), MazeSize::new(3, 2).unwrap().central_cells());
    }

    #[test]
    fn posts_and_walls_may_look_alike() {
        let maze = parse(&MAZE.replace(['o', '-', '|'], "#")).unwrap();
        assert_eq!(Ok(&maze), parse(MAZE).as_ref());
        let narrow = parse("#######\n#  G G#\n# ### #\n#S#   #\n#######\n").unwrap();
        assert_eq!(narrow, maze);
        let digits = parse(&MAZE.replace(['o', '-', '|'], "1"));
        assert_eq!(digits, Ok(maze));
    }

    #[test]
    fn trailing_blanks_may_be_missing_but_walls_may_not() {
        let text = "o---o---o\n|       |\no   o   o\n|   |   |\no---o---o\n";
        assert!(parse(text).is_ok());
        insta::assert_snapshot!(
            error(&text.replace("|       |", "|")),
            @"line 2, column 9: expected the outer wall, found the end of the line"
        );
        assert!(parse(&text.replace("o   o   o", "o   o")).is_ok(), "a post is no wall");
    }

    #[test]
    fn errors_name_location_expected_and_found() {
        let replaced = |from: &str, to: &str| error(&MAZE.replacen(from, to, 1));
        insta::assert_snapshot!(replaced("o---o   o", "o-- o   o"), @r#"line 3, column 6: expected a wall or blanks, found "-- ""#);
        insta::assert_snapshot!(replaced("G   G", "G   S"), @r#"line 4, column 2: expected one start, found " S ""#);
        insta::assert_snapshot!(replaced("| S |       |", "| S |       "), @"line 4, column 13: expected the outer wall, found the end of the line");
        insta::assert_snapshot!(replaced("| S |       |", "  S |       |"), @r#"line 4, column 1: expected the outer wall, found " ""#);
        insta::assert_snapshot!(replaced("|     G   G |", "      G   G |"), @r#"line 2, column 1: expected the outer wall, found " ""#);
        insta::assert_snapshot!(replaced("o---o---o---o", "o---o   o---o"), @r#"line 1, column 6: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(replaced("G   G", "G \t G"), @r#"line 2, column 9: expected a maze drawn with printable characters, found "\t""#);
        insta::assert_snapshot!(replaced("| S |       |\no---o---o---o\n", ""), @r#"line 3, column 2: expected the outer wall, found "   ""#);
    }

    /// If the outer wall has a gap, the lines above the gap may look like a complete, smaller maze.
    #[test]
    fn every_gap_is_reported_at_its_own_location() {
        let text = "o---o---o\n|       |\no---o---o\n|       |\no---o---o\n  official: 2\n";
        let locations = |first: &str, second: &str| -> Vec<String> {
            let row = "|       |\n";
            let text = text.replacen(row, "ROW", 1).replacen(row, second, 1).replace("ROW", first);
            let errors = Choice::default().read(text.as_bytes()).unwrap_err();
            errors.iter().map(|error| error.location.to_string()).collect()
        };
        let (row, bare) = ("|       |\n", "  S\n");
        let at = |line: usize| [1, 9].map(|column| format!("line {line}, column {column}"));
        assert_eq!(locations(row, bare), at(4));
        assert_eq!(locations(bare, row), at(2));
        let start = "line 4, column 2".to_string();
        let at_4 = [at(4)[0].clone(), start, at(4)[1].clone()];
        assert_eq!(locations(bare, bare), [at(2).to_vec(), at_4.to_vec()].concat());
    }

    #[test]
    fn a_truncated_maze_is_an_error() {
        let lines = |count: usize| MAZE.split_inclusive('\n').take(count).collect::<String>();
        insta::assert_snapshot!(error(&lines(1)), @r#"line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found "o---o---o---o""#);
        insta::assert_snapshot!(error(&lines(2)), @r#"line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found "o---o---o---o""#);
        insta::assert_snapshot!(error(&lines(3)), @r#"line 3, column 2: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(error(&lines(4)), @r#"line 3, column 2: expected the outer wall, found "   ""#);
        for end in 1..MAZE.trim_end().len() - 1 {
            assert!(parse(&MAZE[..end]).is_err(), "cut after {end} bytes");
        }
    }

    #[test]
    fn more_than_32_cells_are_an_error() {
        let line = "o".to_string() + &"---o".repeat(33);
        let wide = format!("{line}\n|{}|\n{line}\n", " ".repeat(131));
        insta::assert_snapshot!(error(&wide), @"line 1, column 1: expected at most 32x32 cells, found 33x1");
        let high = "o---o\n|   |\n".repeat(33) + "o---o\n";
        insta::assert_snapshot!(error(&high), @"line 1, column 1: expected at most 32x32 cells, found 1x33");
    }

    const PARTLY_KNOWN: &str = "\
+---+---+---+
|   .   . G |
+   + . +   +
| S |   |   |
+---+---+---+
";

    #[test]
    fn unknown_walls_are_open_and_noted() {
        let parsed = Choice::default().read(PARTLY_KNOWN.as_bytes()).unwrap();
        insta::assert_snapshot!(parsed.maze, @"
        o---o---o---o
        |         G |
        o   o   o   o
        | S |   |   |
        o---o---o---o
        ");
        let location = |line, column| Location::Text { line, column };
        let unknown = parsed.notes.iter().map(|note| (note.kind, note.location));
        let places = [location(2, 5), location(2, 9), location(3, 7)];
        assert!(unknown.eq(places.map(|place| (NoteKind::UnknownWall, place))));
        let narrow = "+-+-+-+\n|S. .G|\n+ +.+ +\n| | | |\n+-+-+-+\n";
        assert_eq!(notes(narrow).len(), 3);
    }

    #[test]
    fn dots_that_are_posts_or_walls_are_known() {
        let plain = PARTLY_KNOWN.replace('.', " ");
        for dotted in ["+", "|", "+-|"] {
            let text = plain.replace(|c| dotted.contains(c), ".");
            assert_eq!(parse(&text), parse(&plain), "{text}");
            assert_eq!(notes(&text), [""; 0], "{text}");
        }
    }

    #[test]
    fn an_outer_wall_cannot_be_unknown() {
        let text = PARTLY_KNOWN.replacen("|   |\n", "|   .\n", 1);
        insta::assert_snapshot!(error(&text), @r#"line 4, column 13: expected the outer wall, found ".""#);
    }

    /// Walls stand between posts, and marks in cells. The rest is decoration.
    #[test]
    fn decoration_is_noted() {
        let maze = parse(MAZE).unwrap();
        let replaced = |from: &str, to: &str| {
            let text = MAZE.replacen(from, to, 1);
            assert_eq!(parse(&text).as_ref(), Ok(&maze), "{text}");
            notes(&text).join("; ")
        };
        insta::assert_snapshot!(replaced("S |       |\no", "S |       |\n."), @r#"line 5, column 1: ignored ".""#);
        insta::assert_snapshot!(replaced("o   o---o", "o   A---o"), @r#"line 3, column 5: ignored "A""#);
        assert_eq!(replaced("o   o---o", "o    ---o"), "");
        insta::assert_snapshot!(replaced("| S |", "|S 0|"), @r#"line 4, column 2: ignored "S 0""#);
        for top in ["o-0-o-1-o-2-o", "o 0 o 1 o 2 o", "o-=-o-=-o-=-o", "o - o - o - o"] {
            assert_eq!(replaced("o---o---o---o\n|     G", &format!("{top}\n|     G")), "", "{top}");
        }
        insta::assert_snapshot!(replaced("| S |  ", "| S | 7"), @r#"line 4, column 6: ignored "7""#);
        insta::assert_snapshot!(replaced("| S |  ", "| S | |"), @r#"line 4, column 6: ignored "|""#);
        insta::assert_snapshot!(replaced("| S |", "| s |"), @"");
        insta::assert_snapshot!(replaced("o---o---o---o\n|     G", "Japan 1987\n\no---o---o---o\n|     G"), @r#"line 1, column 1: ignored "Japan 1987""#);
        insta::assert_snapshot!(replaced("S |       |\no", "S |       |  row 1\no"), @r#"line 4, column 14: ignored "row 1""#);
        let rows = MAZE.lines().zip(["   ", " 1 ", "   ", " 0 ", "   "]);
        let labels: String = rows.flat_map(|(line, row)| [row, line, "\n"]).collect();
        assert_eq!(parse(&labels).as_ref(), Ok(&maze), "{labels}");
        let boxes = "┌───┬───┬───┐\n│     G   G │\n├   ╶───┐   ┤\n│ S │       │\n└───┴───┴───┘\n";
        assert_eq!(parse(&boxes.replace("╶───┐", "o───o")).as_ref(), Ok(&maze));
    }

    #[test]
    fn the_first_of_two_adjacent_mazes_is_read() {
        let two = "o---o---o   o---o\n|       |   |   |\no---o---o   o---o\n";
        insta::assert_snapshot!(parse(two).unwrap(), @"
        o---o---o
        |SG   G |
        o---o---o
        ");
    }

    #[test]
    fn drawings_that_fit_two_mazes_are_errors() {
        insta::assert_snapshot!(error("#########\n#       #\n#########\n"), @"line 1, column 1: expected cells 7 characters wide, found walls and posts that also fit cells 3 wide");
        insta::assert_snapshot!(error(&MAZE.replacen("o---o", "o-- o", 1)), @r#"line 1, column 2: expected a wall or blanks, found "-- ""#);
    }

    const GENERATED: &str = "\
OSHWDEM Maze Generator v1.2 R42263
+---+---+---+---+---+
| A |               |
+   +   +---+---+   +
|   |   |       |   |
+   +   +   B   +   +
|       |       |   |
+   +   +---+   +---+
|   |       |       |
+   +   +---+---+   +
|   |               |
+---+---+---+---+---+
";

    #[test]
    fn drawings_of_oshwdem_are_rotated() {
        insta::assert_snapshot!(parse(GENERATED).unwrap(), @"
        o---o---o---o---o---o
        |           |       |
        o   o---o---o   o   o
        |   | G   G     |   |
        o   o   o   o---o   o
        |   | G   G |   |   |
        o   o---o---o   o   o
        |                   |
        o---o---o   o---o---o
        | S                 |
        o---o---o---o---o---o
        ");
        assert_eq!(notes(GENERATED), [""; 0]);
        let posts = "OSHWDEMO\n|      |\nOSHWDEMO\n";
        assert!(parse(posts).is_err(), "a first line that begins with OSHWDEM is a title");
        insta::assert_snapshot!(error(&GENERATED.replacen("|   |   |", "| A |   |", 1)), @r#"line 5, column 2: expected one start, found " A ""#);
    }
}
