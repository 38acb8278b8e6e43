//! Mazes as a line for each cell: its coordinates, and a digit for each side.

use std::collections::BTreeMap;

use mmsim_maze::{Cell, CellSet, Heading, MazeSize, Sides, counted};

use crate::error::{Location, ParseError, ParseErrorKind, quoted};
use crate::parsed_maze::{Notation, ParsedMaze, maze, size, walls};
use crate::rows::{Item, Row, rows};

/// Reads lines with x, y and 1 for a wall to the north, east, south and west, or the CSV of pyamaze:
/// its header names the sides, a cell is a row from the north and a column, both counted from 1,
/// and 1 is an opening. Returns `None` if the text is neither.
pub(crate) fn parse(text: &str) -> Option<Result<ParsedMaze, Vec<ParseError>>> {
    let head: String =
        text.split_inclusive('\n').filter(|it| !it.trim().is_empty()).take(2).collect();
    let head = rows(&head);
    if let ["cell", sides @ ..] = &head.first()?.texts()[..] {
        let side = |name: &&str| Heading::from_letter(name.parse().ok()?);
        let sides: Vec<Heading> = sides.iter().filter_map(side).collect();
        return (sides.len() == 4).then(|| read(&rows(text)[1..], &sides, true));
    }
    let is_cell = |row: &Row| {
        let texts = row.texts();
        let is_number = |item: &&str| item.len() < 3 && item.parse::<u8>().is_ok();
        let is_digit = |item: &&str| ["0", "1"].contains(item);
        texts.len() == 6 && texts.iter().all(is_number) && texts[2..].iter().all(is_digit)
    };
    head.iter().any(is_cell).then(|| read(&rows(text), &Heading::ALL, false))
}

fn read(rows: &[Row], sides: &[Heading], is_pyamaze: bool) -> Result<ParsedMaze, Vec<ParseError>> {
    let mut cells: BTreeMap<Cell, (Sides, Location, String)> = BTreeMap::new();
    let first = u8::from(is_pyamaze);
    let coordinate = |item: &Item| {
        let number = item.text.parse().ok().and_then(|number: u8| number.checked_sub(first));
        let expected = format!("a coordinate from {first} to {}", first + MazeSize::MAX_SIDE - 1);
        number.filter(|&number| number < MazeSize::MAX_SIDE).ok_or_else(|| item.error(expected))
    };
    for row in rows {
        let items = &row.items;
        let &[ref one, ref two, north, east, south, west] = &items[..] else {
            let at = items.get(6).map_or_else(|| items[items.len() - 1].end(), Item::location);
            let expected = "six numbers: two coordinates and four sides";
            return Err(ParseError::new(at, expected, items.len().to_string()).into());
        };
        let (one, two) = (coordinate(one)?, coordinate(two)?);
        let cell = if is_pyamaze { Cell::new(two, one) } else { Cell::new(one, two) };
        let mut bits = 0;
        for (digit, &side) in [north, east, south, west].iter().zip(sides) {
            match digit.text {
                "0" | "1" => bits |= u8::from((digit.text == "1") != is_pyamaze) << side as u8,
                _ => return Err(digit.error("0 or 1").into()),
            }
        }
        let at = items[0].location();
        let record = (Sides::from_bits(bits), at, quoted(&row.texts().join(" ")));
        if let Some((_, before, _)) = cells.insert(cell, record) {
            let found = format!("{cell}, already defined at {before}");
            let (kind, cell) = (ParseErrorKind::Contradiction, Some(cell));
            return Err(
                ParseError { kind, cell, ..ParseError::new(at, "a new cell", found) }.into()
            );
        }
    }
    let far = |coordinate: fn(&Cell) -> u8| cells.keys().map(coordinate).max().unwrap_or(0);
    let [width, height] = [far(|cell| cell.x), far(|cell| cell.y)].map(|far| usize::from(far) + 1);
    let size = size(Location::FIRST, width, height)?;
    if let Some(missing) = size.cells().find(|cell| !cells.contains_key(cell)) {
        let line = rows.last().map_or(1, |row| row.items[0].line + 1);
        let expected = format!("a line for each of the {} cells", size.area());
        let found = format!("{}, but none for {missing}", counted(cells.len(), "line"));
        return Err(ParseError::new(Location::Text { line, column: 1 }, expected, found).into());
    }
    // The rows of pyamaze are counted from the north.
    let last = size.height() - 1;
    let record = |Cell { x, y }| &cells[&Cell::new(x, if is_pyamaze { last - y } else { y })];
    let place = |cell| (record(cell).1, record(cell).2.clone());
    let walls = walls(size, |cell| record(cell).0, place)?;
    let start = is_pyamaze.then(|| Cell::new(size.width() - 1, 0));
    let goals = is_pyamaze.then(|| Cell::new(0, last));
    let maze = maze(walls, start, goals.into_iter().collect::<CellSet>())?;
    Ok(ParsedMaze { maze, notation: Notation::Cells, encodings: Vec::new(), notes: Vec::new() })
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::read::parse_maze;

    const MAZE: &str = "\
0 0 0 1 1 1
0 1 1 0 0 1
1 0 0 1 1 1
1 1 1 1 0 0
";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        parse_maze(text.as_bytes())
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
        for separator in [";", ",", ", ", "\t"] {
            assert_eq!(parse(&MAZE.replace(' ', separator)).as_ref(), Ok(&maze));
        }
    }

    #[test]
    fn errors_name_cells_and_lines() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("1 0 0 1 1 1", "1 0 0 1 1 0"), @r#"line 3, column 1: expected a wall between (0, 0) and (1, 0) to match line 1, column 1, found "1 0 0 1 1 0""#);
        insta::assert_snapshot!(error("0 0 0 1 1 1", "0 0 0 1 1 0"), @r#"line 1, column 1: expected an outer wall to the west of (0, 0), found "0 0 0 1 1 0""#);
        insta::assert_snapshot!(error("1 0 0 1 1 1", "0 0 0 1 1 1"), @"line 3, column 1: expected a new cell, found (0, 0), already defined at line 1, column 1");
        insta::assert_snapshot!(error("0 0 0 1 1 1\n", ""), @"line 4, column 1: expected a line for each of the 4 cells, found 3 lines, but none for (0, 0)");
        insta::assert_snapshot!(error("1 1 1 1", "9 1 1 1"), @"line 5, column 1: expected a line for each of the 20 cells, found 4 lines, but none for (2, 0)");
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0 2"), @r#"line 4, column 11: expected 0 or 1, found "2""#);
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 32 1 1 0 0"), @r#"line 4, column 3: expected a coordinate from 0 to 31, found "32""#);
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0"), @"line 4, column 10: expected six numbers: two coordinates and four sides, found 5");
        insta::assert_snapshot!(error("1 1 1 1 0 0", "1 1 1 1 0 0 0"), @"line 4, column 13: expected six numbers: two coordinates and four sides, found 7");
    }

    /// The first row of pyamaze is in the north, and the start is in the last one.
    #[test]
    fn pyamaze_names_the_openings() {
        let csv = "  cell  ,E,W,N,S\n\"(1, 1)\",0,0,0,1\n\"(2, 1)\",1,0,1,0\n\"(1, 2)\",0,0,0,1\n\"(2, 2)\",0,1,1,0\n";
        insta::assert_snapshot!(parse(csv).unwrap(), @"
        o---o---o
        | G |   |
        o   o   o
        |     S |
        o---o---o
        ");
        let mirrored = csv.replace("E,W,N,S", "W,E,N,S");
        assert!(parse(&mirrored).is_err(), "openings through the outer wall");
        insta::assert_snapshot!(parse(&csv.replace("2, 2", "0, 2")).unwrap_err(), @r#"line 5, column 3: expected a coordinate from 1 to 32, found "0""#);
        insta::assert_snapshot!(parse(&csv.replace("0,0,0,1\n\"(2, 1", "0,0,0,0\n\"(2, 1")).unwrap_err(), @r#"line 2, column 3: expected no wall between (0, 0) and (0, 1) to match line 3, column 3, found "1 1 0 0 0 0""#);
    }
}
