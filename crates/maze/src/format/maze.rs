//! The text format with unknown walls, as kerikun11's library writes what a mouse knows.

use super::{ParseError, Reading, grid, text};

/// Reads the drawing. An unknown wall is taken as open.
pub(super) fn read(content: &str) -> Result<Reading, Vec<ParseError>> {
    text::read_grid(&grid::parse(content, 1, grid::Dots::Unknown)?)
}

#[cfg(test)]
mod tests {
    use crate::{Format, Maze, Place};

    const MAZE: &str = "\
+---+---+---+
|   .   . G |
+   + . +   +
| S |   |   |
+---+---+---+
";

    #[test]
    fn unknown_walls_are_open_and_counted() {
        assert_eq!(Format::detect(MAZE.as_bytes()), Format::Maze);
        let reading = Format::Maze.read(MAZE.as_bytes()).unwrap();
        insta::assert_snapshot!(reading.maze, @"
        o---o---o---o
        |         G |
        o   o   o   o
        | S |   |   |
        o---o---o---o
        ");
        let place = |line, column| Place::Text { line, column };
        assert_eq!(reading.unknown_walls, [place(2, 5), place(2, 9), place(3, 7)]);
        let narrow = "+-+-+-+\n|S. .G|\n+ +.+ +\n| | | |\n+-+-+-+\n";
        assert_eq!(Format::detect(narrow.as_bytes()), Format::Maze);
        assert_eq!(Format::Maze.read(narrow.as_bytes()).unwrap().unknown_walls.len(), 3);
    }

    #[test]
    fn a_drawing_without_them_is_text() {
        let known = MAZE.replace('.', " ");
        assert_eq!(Format::detect(known.as_bytes()), Format::Text);
        assert_eq!(Format::Maze.parse(known.as_bytes()), known.parse());
    }

    /// What is drawn with dots has known walls.
    #[test]
    fn dots_that_are_posts_or_walls_are_known() {
        for text in [
            known_by(|c| if c == '+' { '.' } else { c }),
            known_by(|c| if c == '|' { '.' } else { c }),
            known_by(|c| if "+-|".contains(c) { '.' } else { c }),
        ] {
            assert_eq!(Format::detect(text.as_bytes()), Format::Text, "{text}");
            assert_eq!(text.parse(), known_by(|c| c).parse::<Maze>(), "{text}");
        }
    }

    fn known_by(drawn: impl Fn(char) -> char) -> String {
        MAZE.replace('.', " ").chars().map(drawn).collect()
    }

    /// Whoever knows that it is text may say so: then whatever is no blank is a wall.
    #[test]
    fn as_text_a_dot_is_a_wall() {
        let wall = "o---o---o\n| S . G |\no---o---o\n";
        assert_eq!(Format::Text.parse(wall.as_bytes()), wall.replace('.', "|").parse());
        assert_eq!(Format::detect(wall.as_bytes()), Format::Maze);
    }

    #[test]
    fn an_outer_wall_is_known() {
        let error = MAZE.replacen("|   |\n", "|   .\n", 1).parse::<Maze>().unwrap_err();
        insta::assert_snapshot!(error, @r#"line 4, column 13: expected the outer wall, found ".""#);
    }
}
