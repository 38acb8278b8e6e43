//! The format of the OSHWDEM maze generator. The drawing is rotated: the cell in row r and column c
//! of the file has x = r and y = c. In the file, north is on the right, east at the bottom, south
//! on the left and west at the top.

use mmsim_maze::{CellSet, Heading, Maze, Walls};

use crate::error::ParseError;
use crate::grid::{self, Dots};
use crate::parsed_maze::{cell, maze, size};

pub(crate) fn parse(text: &str) -> Result<Maze, Vec<ParseError>> {
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
    use super::*;
    use crate::format::Format;

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

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Oshwdem, "{text}");
        Format::Oshwdem.parse(text.as_bytes())
    }

    #[test]
    fn drawings_are_rotated() {
        let maze = parse(GENERATED).unwrap();
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
        let error =
            |from: &str, to: &str| parse(&GENERATED.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("| A |", "| S |"), @r#"line 3, column 2: expected "A" or nothing in a cell, found "S""#);
        insta::assert_snapshot!(error("|   |   |", "| A |   |"), @r#"line 5, column 2: expected one start, found "A""#);
        insta::assert_snapshot!(error("B", "X"), @r#"line 6, column 13: expected a post, or "B" in the middle of the goal, found "X""#);
        insta::assert_snapshot!(error("+   +   +   B", "+   B   +   B"), @r#"line 6, column 13: expected one goal, found "B""#);
        insta::assert_snapshot!(error("+   +   +   B", "B   +   +   +"), @r#"line 6, column 1: expected the goal at a post inside the maze, found "B""#);
        insta::assert_snapshot!(parse("OSHWDEM\n").unwrap_err(), @"line 2, column 1: expected a maze, found the end of the file");
    }
}
