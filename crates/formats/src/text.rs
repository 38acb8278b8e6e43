//! Mazes drawn as text: with north at the top, with or without unknown walls, and the rotated drawings
//! of the OSHWDEM maze generator.

use mmsim_maze::{CellSet, Heading, Maze, Walls};

use crate::error::ParseError;
use crate::grid::{self, Dots};
use crate::parsed_maze::{ParsedMaze, cell, maze, size};

/// Reads a drawing. Unknown walls are read as open.
pub(crate) fn parse(text: &str, dots: Dots) -> Result<ParsedMaze, Vec<ParseError>> {
    let grid = grid::parse(text, 1, dots)?;
    if let Some(mark) = grid.post_marks.first() {
        return Err(mark.error("the same character for all posts").into());
    }
    let cell = |row: usize, column: usize| cell(column, grid.rows - 1 - row);
    let mut walls = Walls::open(size(grid.columns, grid.rows)?);
    for (row, column) in grid.cells() {
        walls.set(cell(row, column), Heading::South, grid.below[row][column]);
        walls.set(cell(row, column), Heading::East, grid.right[row][column]);
    }
    let (mut start, mut goals) = (None, CellSet::EMPTY);
    for mark in &grid.cell_marks {
        if !["S", "G", "SG"].contains(&mark.text.as_str()) {
            return Err(mark.error(r#""S", "G" or nothing in a cell"#).into());
        }
        let cell = cell(mark.row, mark.column);
        if mark.text.contains('S') && start.replace(cell).is_some() {
            return Err(mark.error("one start").into());
        }
        if mark.text.contains('G') {
            goals.insert(cell);
        }
    }
    let maze = maze(walls, start, goals)?;
    Ok(ParsedMaze { unknown_walls: grid.unknown, ..maze.into() })
}

/// Reads a drawing of the OSHWDEM maze generator, which is rotated: the cell in row r and column c of
/// the file has x = r and y = c. In the file, north is on the right, east at the bottom, south on the
/// left and west at the top.
pub(crate) fn parse_oshwdem(text: &str) -> Result<Maze, Vec<ParseError>> {
    let title = text.lines().position(|line| !line.trim().is_empty()).unwrap_or(0);
    let drawing: usize = text.split_inclusive('\n').take(title + 1).map(str::len).sum();
    let grid = grid::parse(&text[drawing..], title + 2, Dots::Wall)?;
    let mut walls = Walls::open(size(grid.rows, grid.columns)?);
    for (row, column) in grid.cells() {
        walls.set(cell(row, column), Heading::East, grid.below[row][column]);
        walls.set(cell(row, column), Heading::North, grid.right[row][column]);
    }
    let mut start = None;
    for mark in &grid.cell_marks {
        if mark.text != "A" {
            return Err(mark.error(r#""A" or nothing in a cell"#).into());
        }
        if start.replace(cell(mark.row, mark.column)).is_some() {
            return Err(mark.error("one start").into());
        }
    }
    let mut goals = CellSet::EMPTY;
    for mark in &grid.post_marks {
        if mark.text != "B" {
            return Err(mark.error("a post, or \"B\" in the middle of the goal").into());
        }
        if !goals.is_empty() {
            return Err(mark.error("one goal").into());
        }
        let inner = (1..grid.rows).contains(&mark.row) && (1..grid.columns).contains(&mark.column);
        if !inner {
            return Err(mark.error("the goal at a post inside the maze").into());
        }
        for (up, left) in [(1, 1), (1, 0), (0, 1), (0, 0)] {
            goals.insert(cell(mark.row - up, mark.column - left));
        }
    }
    Ok(maze(walls, start, goals)?)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, Maze, MazeSize};

    use crate::error::{Location, ParseError};
    use crate::format::Format;

    const MAZE: &str = "\
o---o---o---o
|     G   G |
o   o---o   o
| S |       |
o---o---o---o
";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Text, "{text}");
        Format::Text.parse(text.as_bytes())
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
        insta::assert_snapshot!(
            error(&text.replace("o   o   o", "o   o")),
            @r#"line 3, column 9: expected a post 'o', found the end of the line"#
        );
    }

    #[test]
    fn errors_name_location_expected_and_found() {
        let replaced = |from: &str, to: &str| error(&MAZE.replacen(from, to, 1));
        insta::assert_snapshot!(replaced("o---o   o", "o-- o   o"), @r#"line 3, column 6: expected "---" or three spaces between posts, found "-- ""#);
        insta::assert_snapshot!(replaced("o   o---", "o   ----"), @r#"line 3, column 5: expected a post 'o', found "----o   o""#);
        insta::assert_snapshot!(replaced("o   o---", "o   x---"), @r#"line 3, column 5: expected the same character for all posts, found "x""#);
        insta::assert_snapshot!(replaced("| S |", "| s |"), @r#"line 4, column 2: expected "S", "G" or nothing in a cell, found "s""#);
        insta::assert_snapshot!(replaced("G   G", "G   S"), @r#"line 4, column 2: expected one start, found "S""#);
        insta::assert_snapshot!(replaced("| S |       |", "| S |       "), @"line 4, column 13: expected the outer wall, found the end of the line");
        insta::assert_snapshot!(replaced("| S |       |", "  S |       |"), @r#"line 4, column 1: expected the outer wall, found " ""#);
        insta::assert_snapshot!(replaced("|     G   G |", "      G   G |"), @r#"line 2, column 1: expected the outer wall, found " ""#);
        insta::assert_snapshot!(replaced("| S |       |", "| S |       |   |"), @r#"line 4, column 14: expected the end of the line after 3 cells, found "   |""#);
        insta::assert_snapshot!(replaced("o---o---o---o", "o---o---o---"), @r#"line 1, column 10: expected a post 'o' every 4 columns, found "---""#);
        insta::assert_snapshot!(replaced("o---o---o---o", "o---o   o---o"), @r#"line 1, column 6: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(replaced("G   G", "G \t G"), @"line 2, column 9: expected a maze drawn with printable characters, found a tab");
        insta::assert_snapshot!(replaced("| S |       |\no---o---o---o\n", ""), @r#"line 3, column 2: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(replaced("o---o---o---o\n|", "o---o---o---o\n\n\nnot |"), @r#"line 4, column 13: expected the outer wall, found " ""#);
    }

    /// If the outer wall has a gap, the lines above the gap may look like a complete, smaller maze.
    #[test]
    fn every_gap_is_reported_at_its_own_location() {
        let text = "o---o---o\n|       |\no---o---o\n|       |\no---o---o\n  official: 2\n";
        let locations = |first: &str, second: &str| -> Vec<String> {
            let row = "|       |\n";
            let text = text.replacen(row, "ROW", 1).replacen(row, second, 1).replace("ROW", first);
            let errors = Format::Text.read(text.as_bytes()).unwrap_err();
            errors.iter().map(|error| error.location.to_string()).collect()
        };
        let (row, bare) = ("|       |\n", "  S\n");
        let at = |line: usize| [1, 9].map(|column| format!("line {line}, column {column}"));
        assert_eq!(locations(row, bare), at(4));
        assert_eq!(locations(bare, row), at(2));
        assert_eq!(locations(bare, bare), [at(2), at(4)].concat());
    }

    #[test]
    fn a_truncated_maze_is_an_error() {
        let lines = |count: usize| MAZE.split_inclusive('\n').take(count).collect::<String>();
        insta::assert_snapshot!(error(&lines(1)), @"line 2, column 1: expected a row of cells between outer walls, found none");
        insta::assert_snapshot!(error(&lines(2)), @"line 3, column 1: expected a row of posts, found the end of the file");
        insta::assert_snapshot!(error(&lines(3)), @r#"line 3, column 2: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(error(&lines(4)), @"line 5, column 1: expected a row of posts, found the end of the file");
        for end in 1..MAZE.trim_end().len() {
            assert!(parse(&MAZE[..end]).is_err(), "cut after {end} bytes");
        }
    }

    #[test]
    fn more_than_32_cells_are_an_error() {
        let wide = "o".to_string() + &"---o".repeat(33);
        insta::assert_snapshot!(error(&wide), @"line 1, column 130: expected at most 32 cells per row, found 33 cells");
        let high = "o---o\n|   |\n".repeat(33) + "o---o\n";
        insta::assert_snapshot!(error(&high), @"line 66, column 1: expected at most 32 rows of cells, found one more");
    }

    const PARTLY_KNOWN: &str = "\
+---+---+---+
|   .   . G |
+   + . +   +
| S |   |   |
+---+---+---+
";

    #[test]
    fn unknown_walls_are_open_and_located() {
        assert_eq!(Format::detect(PARTLY_KNOWN.as_bytes()), Format::Maze);
        let parsed = Format::Maze.read(PARTLY_KNOWN.as_bytes()).unwrap();
        insta::assert_snapshot!(parsed.maze, @"
        o---o---o---o
        |         G |
        o   o   o   o
        | S |   |   |
        o---o---o---o
        ");
        let location = |line, column| Location::Text { line, column };
        assert_eq!(parsed.unknown_walls, [location(2, 5), location(2, 9), location(3, 7)]);
        let narrow = "+-+-+-+\n|S. .G|\n+ +.+ +\n| | | |\n+-+-+-+\n";
        assert_eq!(Format::detect(narrow.as_bytes()), Format::Maze);
        assert_eq!(Format::Maze.read(narrow.as_bytes()).unwrap().unknown_walls.len(), 3);
    }

    #[test]
    fn a_drawing_without_unknown_walls_is_text() {
        let known = PARTLY_KNOWN.replace('.', " ");
        assert_eq!(Format::detect(known.as_bytes()), Format::Text);
        assert_eq!(Format::Maze.parse(known.as_bytes()), Format::Text.parse(known.as_bytes()));
    }

    #[test]
    fn dots_that_are_posts_or_walls_are_known() {
        for text in [
            redrawn(|c| if c == '+' { '.' } else { c }),
            redrawn(|c| if c == '|' { '.' } else { c }),
            redrawn(|c| if "+-|".contains(c) { '.' } else { c }),
        ] {
            assert_eq!(Format::detect(text.as_bytes()), Format::Text, "{text}");
            let plain = redrawn(|c| c);
            assert_eq!(Format::Text.parse(text.as_bytes()), Format::Text.parse(plain.as_bytes()));
        }
    }

    fn redrawn(drawn: impl Fn(char) -> char) -> String {
        PARTLY_KNOWN.replace('.', " ").chars().map(drawn).collect()
    }

    #[test]
    fn a_dot_is_a_wall_in_the_text_format() {
        let wall = "o---o---o\n| S . G |\no---o---o\n";
        assert_eq!(
            Format::Text.parse(wall.as_bytes()),
            Ok(wall.replace('.', "|").parse().unwrap())
        );
        assert_eq!(Format::detect(wall.as_bytes()), Format::Maze);
    }

    #[test]
    fn an_outer_wall_cannot_be_unknown() {
        let text = PARTLY_KNOWN.replacen("|   |\n", "|   .\n", 1);
        let error = Format::Maze.parse(text.as_bytes()).unwrap_err();
        insta::assert_snapshot!(error, @r#"line 4, column 13: expected the outer wall, found ".""#);
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

    fn parse_oshwdem(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Oshwdem, "{text}");
        Format::Oshwdem.parse(text.as_bytes())
    }

    #[test]
    fn drawings_are_rotated() {
        let maze = parse_oshwdem(GENERATED).unwrap();
        insta::assert_snapshot!(maze, @"
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
    }

    #[test]
    fn line_numbers_include_the_title() {
        let error = |from: &str, to: &str| {
            parse_oshwdem(&GENERATED.replacen(from, to, 1)).unwrap_err().to_string()
        };
        insta::assert_snapshot!(error("| A |", "| S |"), @r#"line 3, column 2: expected "A" or nothing in a cell, found "S""#);
        insta::assert_snapshot!(error("|   |   |", "| A |   |"), @r#"line 5, column 2: expected one start, found "A""#);
        insta::assert_snapshot!(error("B", "X"), @r#"line 6, column 13: expected a post, or "B" in the middle of the goal, found "X""#);
        insta::assert_snapshot!(error("+   +   +   B", "+   B   +   B"), @r#"line 6, column 13: expected one goal, found "B""#);
        insta::assert_snapshot!(error("+   +   +   B", "B   +   +   +"), @r#"line 6, column 1: expected the goal at a post inside the maze, found "B""#);
        insta::assert_snapshot!(parse_oshwdem("OSHWDEM\n").unwrap_err(), @"line 2, column 1: expected a maze, found the end of the file");
    }
}
