//! The table format of Python micromouse simulators, with a code from 1 to 16 for each cell.

use mmsim_maze::{Cell, Maze, Sides};

use crate::error::ParseError;
use crate::parsed_maze::{CellRecord, unmarked_maze, walls_of_cells};
use crate::rows::{Item, items, table};

/// The walls that the codes 1 to 16 stand for, as bits of [`Sides`].
const CODES: [u8; 16] = [8, 1, 2, 4, 12, 6, 3, 9, 10, 5, 14, 7, 11, 13, 0, 15];

pub(crate) fn parse(text: &str) -> Result<Maze, Vec<ParseError>> {
    let (rows, size) = table(text, "numbers", items)?;
    let rows: Vec<Vec<CellRecord>> =
        rows.iter().map(|row| row.iter().map(parse_cell).collect()).collect::<Result<_, _>>()?;
    let from_north = |y: u8| usize::from(size.height() - 1 - y);
    let record = |Cell { x, y }| &rows[from_north(y)][usize::from(x)];
    unmarked_maze(walls_of_cells(size, record)?)
}

fn parse_cell(item: &Item) -> Result<CellRecord, ParseError> {
    let bits = number(item.text).and_then(|code| CODES.get(code.checked_sub(1)?).copied());
    let bits = bits.ok_or_else(|| item.error("a whole number from 1 to 16"))?;
    let (location, found) = (item.location(), item.text.to_string());
    Ok(CellRecord { sides: Sides::from_bits(bits), location, found })
}

/// Parses a whole number from 0 to 99, which may be written as a float, such as `1.0` or
/// `1.000000000000000000e+00`.
pub(crate) fn number(text: &str) -> Option<usize> {
    let number: f64 = text.parse().ok()?;
    let is_whole = number.fract() == 0.0 && (0.0..=99.0).contains(&number);
    // The number is whole and small.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    is_whole.then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mmsim_maze::Heading;

    use crate::format::Format;

    const MAZE: &str = "8,2,7\n9,9,9\n11,5,6\n";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Csv, "{text}");
        Format::Csv.parse(text.as_bytes())
    }

    #[test]
    fn rows_are_from_the_north() {
        let maze = parse(MAZE).unwrap();
        insta::assert_snapshot!(maze, @"
        o---o---o---o
        |           |
        o   o   o   o
        |   | G |   |
        o   o   o   o
        | S |       |
        o---o---o---o
        ");
    }

    #[test]
    fn every_code_has_its_walls() {
        let codes = "W N E S SW SE NE NW WE NS SWE NSE NWE NSW none all".replace("all", "NESW");
        for (code, walls) in (1..).zip(codes.split(' ')) {
            let item = Item { text: &format!("{code}"), line: 1, column: 1 };
            let sides = parse_cell(&item).unwrap().sides;
            for (heading, letter) in Heading::ALL.into_iter().zip(['N', 'E', 'S', 'W']) {
                assert_eq!(sides.has(heading), walls.contains(letter), "{code} to the {heading}");
            }
        }
    }

    #[test]
    fn variations_are_equal() {
        let floats = |format: &dyn Fn(f64) -> String, separator: &str| -> String {
            let row = |line: &str| {
                let numbers = line.split(',').map(|number| format(number.parse().unwrap()));
                numbers.collect::<Vec<_>>().join(separator) + "\n"
            };
            MAZE.lines().map(row).collect()
        };
        for (what, text) in [
            ("carriage returns and blank lines", MAZE.replace('\n', "\r\n\r\n")),
            ("blanks", MAZE.replace(',', " ,  ")),
            ("trailing commas", MAZE.replace('\n', ",\n")),
            ("semicolons", MAZE.replace(',', ";")),
            ("only blanks", MAZE.replace(',', "  ")),
            ("a byte order mark", "\u{feff}".to_string() + MAZE),
            ("floats", floats(&|number| format!("{number:.1}"), ",")),
            ("what numpy.savetxt writes", floats(&|number| format!("{number:.18}e+00"), " ")),
        ] {
            assert_eq!(parse(&text), parse(MAZE), "{what}");
        }
    }

    #[test]
    fn errors_name_location_expected_and_found() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("9,9,9", "9,15,9"), @"line 2, column 3: expected a wall between (0, 1) and (1, 1) to match line 2, column 1, found 15");
        insta::assert_snapshot!(error("8,2", "1,2"), @"line 1, column 1: expected an outer wall to the north of (0, 2), found 1");
        insta::assert_snapshot!(error("9,9,9", "9,17,9"), @r#"line 2, column 3: expected a whole number from 1 to 16, found "17""#);
        insta::assert_snapshot!(error("9,9,9", "9,1.5,9"), @r#"line 2, column 3: expected a whole number from 1 to 16, found "1.5""#);
        insta::assert_snapshot!(error("9,9,9", "9,,9"), @"line 2, column 3: expected a whole number from 1 to 16, found the end of the line");
        insta::assert_snapshot!(error("9,9,9", "9,9"), @"line 2, column 4: expected 3 numbers, as on line 1, found 2");
        insta::assert_snapshot!(error("9,9,9", "9,x,9"), @r#"line 2, column 3: expected a whole number from 1 to 16, found "x""#);
        insta::assert_snapshot!(error(MAZE, &("11,".repeat(33) + "\n")), @"line 1, column 97: expected at most 32 cells per row, found more");
        insta::assert_snapshot!(error(MAZE, &"11,11\n".repeat(33)), @"line 33, column 1: expected at most 32 rows of cells, found one more");
    }
}
