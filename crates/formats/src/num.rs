//! The format with one line for each cell. A line gives the coordinates of its cell and whether
//! there is a wall on each side.

use std::collections::BTreeMap;

use mmsim_maze::{Cell, Heading, Maze, MazeSize, Sides};

use crate::error::{ParseError, ParseErrorKind, quoted};
use crate::parsed_maze::{CellRecord, by_columns, cell, size, unmarked_maze, walls_of_cells};
use crate::rows::{Item, end, items, lines};

/// Returns true if a line has the `num` format.
pub(crate) fn matches_line(content: &str) -> bool {
    let items: Vec<&str> = content.split_whitespace().collect();
    let is_number = |item: &&str| item.len() <= 2 && item.bytes().all(|c| c.is_ascii_digit());
    let is_wall = |item: &&str| ["0", "1"].contains(item);
    items.len() == 6 && items.iter().all(is_number) && items[2..].iter().all(is_wall)
}

pub(crate) fn parse(text: &str) -> Result<Maze, Vec<ParseError>> {
    let mut cells: BTreeMap<Cell, CellRecord> = BTreeMap::new();
    for (line, content) in lines(text) {
        let (cell, record) = parse_line(line, content)?;
        if let Some(before) = cells.get(&cell) {
            let found = format!("{cell}, already defined at {}", before.location);
            let error = ParseError::at(record.location, "a new cell", found).with_cell(cell);
            return Err(error.with_kind(ParseErrorKind::Contradiction).into());
        }
        cells.insert(cell, record);
    }
    let count = |coordinate: fn(&Cell) -> u8| {
        cells.keys().map(coordinate).max().map_or(0, |last| usize::from(last) + 1)
    };
    let size = size(count(|cell| cell.x), count(|cell| cell.y))?;
    let missing: Vec<Cell> = size.cells().filter(|cell| !cells.contains_key(cell)).collect();
    if let Some(first) = missing.first() {
        let last = lines(text).last().map_or(0, |(line, _)| line);
        let expected = format!("a line for each cell of the {size} maze");
        let found = format!("none for {}", abbreviated(&missing));
        return Err(ParseError::new(last + 1, 1, expected, found).with_cell(*first).into());
    }
    unmarked_maze(walls_of_cells(size, |cell| &cells[&cell])?)
}

pub(crate) fn write(maze: &Maze) -> String {
    let line = |cell: Cell| {
        let sides = maze.walls().sides(cell);
        let [north, east, south, west] = Heading::ALL.map(|heading| u8::from(sides.has(heading)));
        format!("{} {} {north} {east} {south} {west}\n", cell.x, cell.y)
    };
    by_columns(maze.size()).map(line).collect()
}

fn parse_line(line: usize, content: &str) -> Result<(Cell, CellRecord), ParseError> {
    let items = items(line, content);
    let &[x, y, north, east, south, west] = &items[..] else {
        let column = items.get(6).map_or_else(|| end(content), |item| item.column);
        let (expected, found) = ("six numbers (x y north east south west)", items.len());
        return Err(ParseError::new(line, column, expected, found.to_string()));
    };
    let cell = cell(coordinate(&x)?, coordinate(&y)?);
    let mut bits = 0;
    for (bit, side) in [north, east, south, west].iter().enumerate() {
        match side.text {
            "0" => {}
            "1" => bits |= 1 << bit,
            _ => return Err(side.error("0 (no wall) or 1 (wall)")),
        }
    }
    let (location, found) = (x.location(), quoted(content.trim()));
    Ok((cell, CellRecord { sides: Sides::from_bits(bits), location, found }))
}

fn coordinate(item: &Item) -> Result<usize, ParseError> {
    let number = item.text.parse().ok().filter(|&number| number < usize::from(MazeSize::MAX_SIDE));
    number.ok_or_else(|| item.error("a coordinate from 0 to 31"))
}

/// Lists the first three cells and counts the rest.
fn abbreviated(cells: &[Cell]) -> String {
    const SHOWN: usize = 3;
    let shown: Vec<String> = cells.iter().take(SHOWN).map(Cell::to_string).collect();
    let shown = shown.join(", ");
    match cells.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;

    const MAZE: &str = "\
0 0 0 1 1 1
0 1 1 0 0 1
1 0 0 1 1 1
1 1 1 1 0 0
";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Num, "{text}");
        Format::Num.parse(text.as_bytes())
    }

    #[test]
    fn lines_are_cells_in_any_order() {
        let maze = parse(MAZE).unwrap();
        insta::assert_snapshot!(maze, @"
        o---o---o
        | G   G |
        o   o   o
        |SG | G |
        o---o---o
        ");
        let lines: Vec<&str> = MAZE.lines().rev().collect();
        let reversed = "\n ".to_string() + &lines.join(" \r\n\r\n");
        assert_eq!(parse(&reversed).as_ref(), Ok(&maze));
        assert_eq!(Format::Num.write(&maze).as_deref(), Ok(MAZE.as_bytes()));
    }

    #[test]
    fn errors_name_cells_and_lines() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("1 0 0 1 1 1", "1 0 0 1 1 0"), @r#"line 3, column 1: expected a wall between (0, 0) and (1, 0) to match line 1, column 1, found "1 0 0 1 1 0""#);
        insta::assert_snapshot!(error("0 0 0 1 1 1", "0 0 0 1 1 0"), @r#"line 1, column 1: expected an outer wall to the west of (0, 0), found "0 0 0 1 1 0""#);
        insta::assert_snapshot!(error("1 0 0 1 1 1", "0 0 0 1 1 1"), @"line 3, column 1: expected a new cell, found (0, 0), already defined at line 1, column 1");
        insta::assert_snapshot!(error("0 0 0 1 1 1\n", ""), @"line 4, column 1: expected a line for each cell of the 2x2 maze, found none for (0, 0)");
        insta::assert_snapshot!(error("1 1 1 1", "9 1 1 1"), @"line 5, column 1: expected a line for each cell of the 10x2 maze, found none for (2, 0), (3, 0), (4, 0) and 13 more");
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0 2"), @r#"line 4, column 11: expected 0 (no wall) or 1 (wall), found "2""#);
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 32 1 1 0 0"), @r#"line 4, column 3: expected a coordinate from 0 to 31, found "32""#);
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0"), @"line 4, column 10: expected six numbers (x y north east south west), found 5");
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0 0 0"), @"line 4, column 13: expected six numbers (x y north east south west), found 7");
    }
}
