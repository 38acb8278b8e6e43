//! Drawings with unknown walls, as kerikun11's library writes what a mouse knows.

use crate::error::ParseError;
use crate::grid::{self, Dots};
use crate::parsed_maze::ParsedMaze;
use crate::text;

/// Reads a drawing with unknown walls as open.
pub(crate) fn parse(content: &str) -> Result<ParsedMaze, Vec<ParseError>> {
    text::to_maze(&grid::parse(content, 1, Dots::Unknown)?)
}

#[cfg(test)]
mod tests {
    use crate::error::Location;
    use crate::format::Format;

    const MAZE: &str = "\
+---+---+---+
|   .   . G |
+   + . +   +
| S |   |   |
+---+---+---+
";

    #[test]
    fn unknown_walls_are_open_and_located() {
        assert_eq!(Format::detect(MAZE.as_bytes()), Format::Maze);
        let parsed = Format::Maze.read(MAZE.as_bytes()).unwrap();
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
        let known = MAZE.replace('.', " ");
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
        MAZE.replace('.', " ").chars().map(drawn).collect()
    }

    #[test]
    fn read_as_text_a_dot_is_a_wall() {
        let wall = "o---o---o\n| S . G |\no---o---o\n";
        assert_eq!(
            Format::Text.parse(wall.as_bytes()),
            Ok(wall.replace('.', "|").parse().unwrap())
        );
        assert_eq!(Format::detect(wall.as_bytes()), Format::Maze);
    }

    #[test]
    fn an_outer_wall_cannot_be_unknown() {
        let text = MAZE.replacen("|   |\n", "|   .\n", 1);
        let error = Format::Maze.parse(text.as_bytes()).unwrap_err();
        insta::assert_snapshot!(error, @r#"line 4, column 13: expected the outer wall, found ".""#);
    }
}
