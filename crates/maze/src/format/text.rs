//! The text format: north on top.

use super::{ParseError, Reading, cell, finish, grid, size};
use crate::{CellSet, Heading, Walls};

pub(super) fn read(text: &str) -> Result<Reading, Vec<ParseError>> {
    read_grid(&grid::parse(text, 1, grid::Dots::Wall)?)
}

/// The maze of a drawing with north on top.
pub(super) fn read_grid(grid: &grid::Grid) -> Result<Reading, Vec<ParseError>> {
    if let Some(mark) = grid.post_marks.first() {
        return Err(mark.error("posts of one character").into());
    }
    let maze_cell = |row: usize, column: usize| cell(column, grid.rows - 1 - row);
    let mut walls = Walls::open(size(grid.columns, grid.rows)?);
    for (row, column) in grid.cells() {
        walls.set(maze_cell(row, column), Heading::South, grid.below[row][column]);
        walls.set(maze_cell(row, column), Heading::East, grid.right[row][column]);
    }
    let (mut start, mut goals) = (None, CellSet::EMPTY);
    for mark in &grid.cell_marks {
        if !["S", "G", "SG"].contains(&mark.text.as_str()) {
            return Err(mark.error(r#""S", "G" or nothing in a cell"#).into());
        }
        let cell = maze_cell(mark.row, mark.column);
        if mark.text.contains('S') && start.replace(cell).is_some() {
            return Err(mark.error("one start").into());
        }
        if mark.text.contains('G') {
            goals.insert(cell);
        }
    }
    let maze = finish(walls, start, goals)?;
    Ok(Reading { unknown_walls: grid.unknown.clone(), ..Reading::of(maze) })
}

#[cfg(test)]
mod tests {
    use crate::{Cell, Format, Maze, MazeSize};

    const MAZE: &str = "\
o---o---o---o
|     G   G |
o   o---o   o
| S |       |
o---o---o---o
";

    fn error(text: &str) -> String {
        text.parse::<Maze>().unwrap_err().to_string()
    }

    /// The same maze, written as others do.
    #[test]
    fn variations_read_alike() {
        let maze: Maze = MAZE.parse().unwrap();
        assert_eq!(maze.to_string(), MAZE);
        assert_eq!(*maze.goals(), [Cell::new(1, 1), Cell::new(2, 1)].into_iter().collect());
        for (what, text) in [
            ("plus signs", MAZE.replace('o', "+")),
            ("dots", MAZE.replace('o', ".")),
            ("a sign beyond ASCII", MAZE.replace('o', "·")),
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
            assert_eq!(text.parse().as_ref(), Ok(&maze), "{what}");
        }
    }

    #[test]
    fn start_and_goal_are_optional() {
        let maze: Maze = MAZE.replace(['S', 'G'], " ").parse().unwrap();
        assert_eq!(maze.start().cell, Cell::new(0, 0));
        assert_eq!(*maze.goals(), MazeSize::new(3, 2).unwrap().central_cells());
    }

    #[test]
    fn a_maze_of_one_kind_of_character_reads() {
        let maze: Maze = MAZE.replace(['o', '-', '|'], "#").parse().unwrap();
        assert_eq!(maze, MAZE.parse().unwrap());
        let narrow: Maze = "#######\n#  G G#\n# ### #\n#S#   #\n#######\n".parse().unwrap();
        assert_eq!(narrow, maze);
        let digits = MAZE.replace(['o', '-', '|'], "1").parse();
        assert_eq!(digits, Ok(maze));
    }

    #[test]
    fn trailing_blanks_may_be_missing_but_no_wall() {
        let text = "o---o---o\n|       |\no   o   o\n|   |   |\no---o---o\n";
        assert!(text.parse::<Maze>().is_ok());
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
    fn errors_name_place_expected_and_found() {
        let replaced = |from: &str, to: &str| error(&MAZE.replacen(from, to, 1));
        insta::assert_snapshot!(replaced("o---o   o", "o-- o   o"), @r#"line 3, column 6: expected "---" or three spaces between posts, found "-- ""#);
        insta::assert_snapshot!(replaced("o   o---", "o   ----"), @r#"line 3, column 5: expected a post 'o', found "----o   o""#);
        insta::assert_snapshot!(replaced("o   o---", "o   x---"), @r#"line 3, column 5: expected posts of one character, found "x""#);
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

    /// Its first two rows would make a maze alone.
    #[test]
    fn every_gap_is_told_at_its_own_place() {
        let text = "o---o---o\n|       |\no---o---o\n|       |\no---o---o\n  official: 2\n";
        let places = |first: &str, second: &str| -> Vec<String> {
            let row = "|       |\n";
            let text = text.replacen(row, "ROW", 1).replacen(row, second, 1).replace("ROW", first);
            let errors = Format::Text.read(text.as_bytes()).unwrap_err();
            errors.iter().map(|error| error.place.to_string()).collect()
        };
        let (row, bare) = ("|       |\n", "  S\n");
        let at = |line: usize| [1, 9].map(|column| format!("line {line}, column {column}"));
        assert_eq!(places(row, bare), at(4));
        assert_eq!(places(bare, row), at(2));
        assert_eq!(places(bare, bare), [at(2), at(4)].concat());
    }

    #[test]
    fn a_truncated_maze_is_an_error() {
        let lines = |count: usize| MAZE.split_inclusive('\n').take(count).collect::<String>();
        insta::assert_snapshot!(error(&lines(1)), @"line 2, column 1: expected a row of cells between outer walls, found none");
        insta::assert_snapshot!(error(&lines(2)), @"line 3, column 1: expected a row of posts, found the end of the file");
        insta::assert_snapshot!(error(&lines(3)), @r#"line 3, column 2: expected the outer wall, found "   ""#);
        insta::assert_snapshot!(error(&lines(4)), @"line 5, column 1: expected a row of posts, found the end of the file");
        for end in 1..MAZE.trim_end().len() {
            assert!(MAZE[..end].parse::<Maze>().is_err(), "cut after {end} bytes");
        }
    }

    #[test]
    fn more_than_32_cells_are_too_many() {
        let wide = "o".to_string() + &"---o".repeat(33);
        insta::assert_snapshot!(error(&wide), @"line 1, column 130: expected at most 32 cells side by side, found 33 cells");
        let high = "o---o\n|   |\n".repeat(33) + "o---o\n";
        insta::assert_snapshot!(error(&high), @"line 66, column 1: expected at most 32 rows of cells, found one more");
    }
}
