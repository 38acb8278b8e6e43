//! A parser for mazes that are drawn as text.

use core::str::FromStr;

use crate::cell::{Cell, MazeSize};
use crate::cell_set::CellSet;
use crate::heading::Heading;
use crate::maze::Maze;
use crate::walls::Walls;

/// The error for text that is not a valid picture of a maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: expected {expected}")]
#[non_exhaustive]
pub struct ParseMazeError {
    /// The line number, counted from 1.
    pub line: usize,
    /// The column number in bytes, counted from 1.
    pub column: usize,
    /// A description of the expected text.
    pub expected: &'static str,
}

const PICTURE: &str = if cfg!(feature = "half-size") {
    "the picture of a maze of 1x1 to 32x32 cells"
} else {
    "the picture of a maze of 1x1 to 16x16 cells"
};

type Result<T = ()> = core::result::Result<T, ParseMazeError>;

/// Parses the text picture that [`Display`](core::fmt::Display) writes for a maze. Blank lines and
/// trailing whitespace are ignored. The `mmsim-formats` crate reads other text pictures and maze
/// files.
///
/// ```
/// use mmsim_maze::Maze;
/// let error = "o---o\n| S |\no-- o\n".parse::<Maze>().unwrap_err();
/// assert_eq!(error.to_string(), r#"line 3, column 2: expected the outer wall, "---""#);
/// ```
impl FromStr for Maze {
    type Err = ParseMazeError;

    fn from_str(text: &str) -> Result<Self> {
        let lines = || {
            let lines = (1..).zip(text.lines());
            let lines = lines.map(|(number, text)| Line { number, text: text.trim_end() });
            lines.filter(|line| !line.text.is_empty())
        };
        let end = Line { number: lines().last().map_or(1, |last| last.number + 1), text: "" };
        let first = lines().next().unwrap_or(end);
        let rows = lines().filter(|line| line.text.starts_with('|')).count();
        let size =
            MazeSize::new(first.text.len() / 4, rows).map_err(|_| first.error(0, PICTURE))?;
        let mut parts = Parts { walls: Walls::open(size), start: None, goals: CellSet::EMPTY };
        let mut lines = lines();
        let mut next = || lines.next().unwrap_or(end);
        for y in (0..size.height()).rev() {
            parts.read_posts(next(), y, Heading::North)?;
            parts.read_cells(next(), y)?;
        }
        parts.read_posts(next(), 0, Heading::South)?;
        next().expect_end(0, "the end of the picture")?;
        Maze::new(parts.walls, parts.start.unwrap_or(Cell::new(0, 0)), parts.goals)
            .map_err(|_| first.error(0, "a start and goals inside the maze"))
    }
}

/// A line of the picture, without trailing whitespace.
#[derive(Clone, Copy)]
struct Line<'a> {
    number: usize,
    text: &'a str,
}

impl Line<'_> {
    const fn error(self, at: usize, expected: &'static str) -> ParseMazeError {
        ParseMazeError { line: self.number, column: at + 1, expected }
    }

    /// Returns the index of the first element of `choices` that the line contains at byte offset
    /// `at`.
    fn choice(self, at: usize, choices: &[&str], expected: &'static str) -> Result<usize> {
        let rest = self.text.get(at..).unwrap_or("");
        let found = choices.iter().position(|choice| rest.starts_with(choice));
        found.ok_or(self.error(at, expected))
    }

    fn expect_end(self, at: usize, expected: &'static str) -> Result {
        if self.text.len() > at { Err(self.error(at, expected)) } else { Ok(()) }
    }
}

/// The parts of a maze that have been parsed so far.
struct Parts {
    walls: Walls,
    start: Option<Cell>,
    goals: CellSet,
}

impl Parts {
    /// Reads a line of posts and walls: the walls on the `heading` side of the cells in row `y`.
    fn read_posts(&mut self, line: Line, y: u8, heading: Heading) -> Result {
        const POST: &str = r#"a post "o""#;
        for x in 0..self.walls.size().width() {
            let at = 4 * usize::from(x);
            line.choice(at, &["o"], POST)?;
            self.read_wall(line, at + 1, Cell::new(x, y), heading)?;
        }
        let end = 4 * usize::from(self.walls.size().width());
        line.choice(end, &["o"], POST)?;
        line.expect_end(end + 1, "the end of the line")
    }

    /// Reads the line with the cells of row `y` and their east and west walls.
    fn read_cells(&mut self, line: Line, y: u8) -> Result {
        const MARKS: &[&str] = &["   ", " S ", " G ", "SG "];
        self.read_wall(line, 0, Cell::new(0, y), Heading::West)?;
        for x in 0..self.walls.size().width() {
            let (cell, at) = (Cell::new(x, y), 4 * usize::from(x) + 1);
            let mark = line.choice(at, MARKS, "an empty cell or a cell with S, G or SG")?;
            if mark % 2 == 1 && self.start.replace(cell).is_some() {
                return Err(line.error(at, "one start"));
            }
            if mark >= 2 {
                self.goals.insert(cell);
            }
            self.read_wall(line, at + 3, cell, Heading::East)?;
        }
        line.expect_end(4 * usize::from(self.walls.size().width()) + 1, "the end of the line")
    }

    /// Reads the wall on the `heading` side of `cell`.
    fn read_wall(&mut self, line: Line, at: usize, cell: Cell, heading: Heading) -> Result {
        use Heading::{East, North, South, West};
        let is_inner = self.walls.size().neighbour(cell, heading).is_some();
        let (choices, expected): (&[&str], _) = match (heading, is_inner) {
            (North | South, true) => (&["---", "   "], r#""---" or three spaces"#),
            (North | South, false) => (&["---"], r#"the outer wall, "---""#),
            (East | West, true) => (&["|", " "], r#""|" or a space"#),
            (East | West, false) => (&["|"], r#"the outer wall, "|""#),
        };
        self.walls.set(cell, heading, line.choice(at, choices, expected)? == 0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MAZE: &str = "o---o---o\n| G |SG |\no   o---o\n|       |\no---o---o\n";

    #[test]
    fn pictures_parse() {
        let maze: Maze = MAZE.parse().unwrap();
        assert_eq!(maze.to_string(), MAZE);
        let spaced = "\n".to_string() + &MAZE.replace('\n', " \r\n\n");
        assert_eq!(spaced.parse(), Ok(maze));
    }

    #[test]
    fn errors_name_line_and_column() {
        let error = |from: &str, to: &str| {
            MAZE.replacen(from, to, 1).parse::<Maze>().unwrap_err().to_string()
        };
        insta::assert_snapshot!(error("o   o", "o - o"), @r#"line 3, column 2: expected "---" or three spaces"#);
        insta::assert_snapshot!(error(" G |", " S |"), @"line 2, column 6: expected one start");
        insta::assert_snapshot!(error("       |", "        "), @"line 4, column 2: expected an empty cell or a cell with S, G or SG");
        insta::assert_snapshot!(error(" G ", " X "), @"line 2, column 2: expected an empty cell or a cell with S, G or SG");
        insta::assert_snapshot!(error("o---o---o\n|", "o---o---o-\n|"), @"line 1, column 10: expected the end of the line");
        insta::assert_snapshot!(error(MAZE, &(MAZE.to_string() + "x\n")), @"line 6, column 1: expected the end of the picture");
        insta::assert_snapshot!(error(MAZE, &(MAZE.to_string() + "o---o---o\n")), @"line 6, column 1: expected the end of the picture");
        insta::assert_snapshot!(error("|       |\no---o---o\n", "|       |\n"), @r#"line 5, column 1: expected a post "o""#);
        insta::assert_snapshot!(error(MAZE, ""), @"line 1, column 1: expected the picture of a maze of 1x1 to 32x32 cells");
    }

    #[test]
    fn each_wall_and_post_has_its_place_in_errors() {
        let error = |from: &str, to: &str| {
            assert!(MAZE.contains(from));
            let error = MAZE.replacen(from, to, 1).parse::<Maze>().unwrap_err();
            (error.line, error.column, error.expected)
        };
        let (post, end) = (r#"a post "o""#, "the end of the line");
        let (outer_row, outer_side) = (r#"the outer wall, "---""#, r#"the outer wall, "|""#);
        assert_eq!(error("o---o", "x---o"), (1, 1, post));
        assert_eq!(error("o---o", "o---x"), (1, 5, post));
        assert_eq!(error("---o\n", "---x\n"), (1, 9, post));
        assert_eq!(error("o---o---o", "o---o- -o"), (1, 6, outer_row));
        assert_eq!(error("|\no---o---o\n", "|\no- -o---o\n"), (5, 2, outer_row));
        assert_eq!(error("| G |SG |", "| G xSG |"), (2, 5, r#""|" or a space"#));
        assert_eq!(error("SG |", "SG x"), (2, 9, outer_side));
        assert_eq!(error("SG |", "SG |x"), (2, 10, end));
        assert_eq!(error("o   o---o\n", "o   o---ox\n"), (3, 10, end));
        let unwalled = MAZE.replacen('|', " ", 1) + "|\n";
        let error = unwalled.parse::<Maze>().unwrap_err();
        assert_eq!((error.line, error.column, error.expected), (2, 1, outer_side));
        // Blank lines count in line numbers.
        let error = ("\n\n".to_string() + "o\n").parse::<Maze>().unwrap_err();
        assert_eq!((error.line, error.column), (3, 1));
        let wide = format!("o{}\n|\n", "---o".repeat(33)).parse::<Maze>().unwrap_err();
        assert_eq!(wide.expected, "the picture of a maze of 1x1 to 32x32 cells");
    }

    #[test]
    fn a_picture_without_marks_has_the_default_start_and_goal() {
        let maze: Maze = MAZE.replace(" G ", "   ").replace("SG ", "   ").parse().unwrap();
        assert_eq!(maze.start().cell, Cell::new(0, 0));
        assert_eq!(maze.goals(), &maze.size().central_cells());
        let maze: Maze = MAZE.parse().unwrap();
        assert_eq!(maze.start().cell, Cell::new(1, 1));
        assert!(maze.goals().iter().eq([Cell::new(0, 1), Cell::new(1, 1)]));
    }

    proptest! {
        #[test]
        fn a_damaged_picture_is_another_maze_or_an_error_in_the_text(
            damage in prop::collection::vec((any::<prop::sample::Index>(), 0u8..128), 1..3),
        ) {
            let mut bytes = MAZE.as_bytes().to_vec();
            for (index, byte) in damage {
                let index = index.index(bytes.len());
                bytes[index] = byte;
            }
            let text = String::from_utf8(bytes).unwrap();
            match text.parse::<Maze>() {
                Ok(maze) => prop_assert_eq!(maze.to_string().parse(), Ok(maze)),
                Err(error) => prop_assert!((1..=text.lines().count() + 1).contains(&error.line)),
            }
        }
    }
}
