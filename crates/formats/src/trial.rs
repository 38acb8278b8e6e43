//! The file format of the two-run trial.

use mmsim_maze::{Cell, Maze, Sides};

use crate::error::{ParseError, quoted};
use crate::parsed_maze::{CellRecord, size, unmarked_maze, walls_of_cells};
use crate::rows::{Item, MAX_SIDE, end, items, lines};

pub(crate) fn parse(text: &str) -> Result<Maze, Vec<ParseError>> {
    let columns = parse_columns(text)?;
    let size = size(columns.len(), columns.len())?;
    let record = |Cell { x, y }| &columns[usize::from(x)][usize::from(y)];
    unmarked_maze(walls_of_cells(size, record)?)
}

pub(crate) fn write(maze: &Maze) -> String {
    let size = maze.size();
    let mut text = format!("{}\n", size.width());
    for x in 0..size.width() {
        let number = |y| (maze.walls().sides(Cell { x, y }).bits() ^ 15).to_string();
        text += &(0..size.height()).map(number).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// Reads the records of all cells, indexed as `[x][y]`. The first line of the file contains the
/// side length of the maze.
fn parse_columns(text: &str) -> Result<Vec<Vec<CellRecord>>, ParseError> {
    let mut lines = lines(text);
    let (mut last, first) = lines.next().unwrap_or((1, ""));
    let side = parse_side(last, first)?;
    let mut columns = Vec::new();
    for (line, content) in lines {
        if columns.len() == side {
            let expected = format!("the end of the file after {side} lines of cells");
            return Err(ParseError::new(line, 1, expected, quoted(content.trim())));
        }
        columns.push(parse_column(line, content, side)?);
        last = line;
    }
    if columns.len() < side {
        let expected = format!("{side} lines of cells");
        return Err(ParseError::new(last + 1, 1, expected, format!("{} lines", columns.len())));
    }
    Ok(columns)
}

fn parse_side(line: usize, content: &str) -> Result<usize, ParseError> {
    let side = content.trim().parse().ok();
    let side = side.filter(|side| (2..=MAX_SIDE).contains(side) && side % 2 == 0);
    let expected = "an even side length from 2 to 32";
    side.ok_or_else(|| ParseError::new(line, 1, expected, quoted(content.trim())))
}

fn parse_column(line: usize, content: &str, side: usize) -> Result<Vec<CellRecord>, ParseError> {
    let items = items(line, content);
    if let Some(beyond) = items.get(side) {
        return Err(beyond.error(format!("the end of the line after {side} numbers")));
    }
    let numbers: Vec<CellRecord> = items.iter().map(parse_number).collect::<Result<_, _>>()?;
    if numbers.len() < side {
        let found = format!("{} numbers", numbers.len());
        return Err(ParseError::new(line, end(content), format!("{side} numbers"), found));
    }
    Ok(numbers)
}

fn parse_number(item: &Item) -> Result<CellRecord, ParseError> {
    let number = item.text.parse::<u8>().ok().filter(|&number| number <= 15);
    let open = number.ok_or_else(|| item.error("a number from 0 to 15"))?;
    let (sides, found) = (Sides::from_bits(!open), open.to_string());
    Ok(CellRecord { sides, location: item.location(), found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::Format;

    /// After the side length, each line is a column of the maze, from west to east. The numbers in
    /// a line are the cells of the column, from south to north.
    const MAZE: &str = "4\n1,7,5,4\n2,10,3,6\n11,13,14,8\n9,5,13,4\n";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Trial, "{text}");
        Format::Trial.parse(text.as_bytes())
    }

    #[test]
    fn lines_are_columns_and_bits_are_openings() {
        let maze = parse(MAZE).unwrap();
        insta::assert_snapshot!(maze, @"
        o---o---o---o---o
        |   |       |   |
        o   o   o---o   o
        |   | G   G     |
        o   o---o   o   o
        |     G   G |   |
        o   o---o   o   o
        | S |           |
        o---o---o---o---o
        ");
        assert_eq!(Format::Trial.write(&maze).as_deref(), Ok(MAZE.as_bytes()));
    }

    #[test]
    fn blanks_and_carriage_returns_are_ignored() {
        let text = "\n ".to_string() + &MAZE.replace(',', " , ").replace('\n', " \r\n\r\n");
        assert_eq!(parse(&text), parse(MAZE));
    }

    #[test]
    fn errors_name_both_cells() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("2,10", "2,8"), @"line 4, column 4: expected a wall between (1, 1) and (2, 1) to match line 3, column 3, found 13");
        insta::assert_snapshot!(error("1,7,5", "1,5,5"), @"line 3, column 3: expected a wall between (0, 1) and (1, 1) to match line 2, column 3, found 10");
        insta::assert_snapshot!(error("1,7", "5,7"), @"line 2, column 1: expected an outer wall to the south of (0, 0), found 5");
        insta::assert_snapshot!(error("4\n1", "3\n1"), @r#"line 1, column 1: expected an even side length from 2 to 32, found "3""#);
        insta::assert_snapshot!(error("4\n1", "34\n1"), @r#"line 1, column 1: expected an even side length from 2 to 32, found "34""#);
        insta::assert_snapshot!(error("10", "16"), @r#"line 3, column 3: expected a number from 0 to 15, found "16""#);
        insta::assert_snapshot!(error("10", ""), @"line 3, column 3: expected a number from 0 to 15, found the end of the line");
        insta::assert_snapshot!(error("10", "-1"), @r#"line 3, column 3: expected a number from 0 to 15, found "-1""#);
        insta::assert_snapshot!(error("2,10,3,6", "2,10,3"), @"line 3, column 7: expected 4 numbers, found 3 numbers");
        insta::assert_snapshot!(error("2,10,3,6", "2,10,3,6,1"), @r#"line 3, column 10: expected the end of the line after 4 numbers, found "1""#);
        insta::assert_snapshot!(error("9,5,13,4\n", ""), @"line 5, column 1: expected 4 lines of cells, found 3 lines");
        insta::assert_snapshot!(error("9,5,13,4\n", "9,5,13,4\n1,2,3,4\n"), @r#"line 6, column 1: expected the end of the file after 4 lines of cells, found "1,2,3,4""#);
    }
}
