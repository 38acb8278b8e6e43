//! Mazes as lines of hex digits, with one digit for each cell. The encoding is inferred by trying
//! 32 candidates.

use mmsim_maze::{Cell, CellSet, Heading, Maze, MazeSize, Sides, Walls};

use crate::error::{ParseError, quoted};
use crate::parsed_maze::{CellRecord, ParsedMaze, unmarked_maze, walls_of_cells};
use crate::rows::{Item, MAX_ITEMS, MAX_SIDE, items, table};

/// The two usual assignments of headings to the bits 1, 2, 4 and 8: clockwise from north, and
/// counter-clockwise from east.
const BIT_ORDERS: [[Heading; 4]; 2] = {
    use Heading::{East, North, South, West};
    [[North, East, South, West], [East, North, West, South]]
};

/// The order in which a file stores the cells of a maze.
#[derive(Clone, Copy)]
struct Layout {
    /// The first line of the file contains the row or column of cells at this edge of the maze.
    lines_from: Heading,
    /// The edge of the maze at which each line begins.
    digits_from: Heading,
}

impl Layout {
    /// Returns all layouts. The two most common ones come first: those of drawings and of `.maz`
    /// files.
    fn all() -> impl Iterator<Item = Self> {
        use Heading::{East, North, South, West};
        let usual = [(North, West), (West, South)];
        let rows = [(North, East), (South, West), (South, East)];
        let columns = [(West, North), (East, South), (East, North)];
        let edges = usual.into_iter().chain(rows).chain(columns);
        edges.map(|(lines_from, digits_from)| Self { lines_from, digits_from })
    }

    /// Returns true if each line is a column of the maze instead of a row.
    const fn has_columns(self) -> bool {
        matches!(self.lines_from, Heading::East | Heading::West)
    }

    fn words(self) -> String {
        let lines = if self.has_columns() { "columns" } else { "rows" };
        format!("{lines} from the {}, each starting in the {}", self.lines_from, self.digits_from)
    }

    /// Returns the size of the maze. The width of `table` is the length of its lines, and its
    /// height is the number of lines.
    fn maze_size(self, table: MazeSize) -> MazeSize {
        let (digits, lines) = (usize::from(table.width()), usize::from(table.height()));
        let (width, height) = if self.has_columns() { (lines, digits) } else { (digits, lines) };
        MazeSize::new(width, height).unwrap_or(table)
    }

    /// Returns the index of the line that contains a cell, and the index of the cell's digit in
    /// that line.
    fn position(self, size: MazeSize, Cell { x, y }: Cell) -> (usize, usize) {
        let cells_from = |edge| match edge {
            Heading::North => size.height() - 1 - y,
            Heading::East => size.width() - 1 - x,
            Heading::South => y,
            Heading::West => x,
        };
        (cells_from(self.lines_from).into(), cells_from(self.digits_from).into())
    }
}

/// The digits of a file, assigned to cells by a layout.
struct Digits {
    layout: Layout,
    size: MazeSize,
    /// Bit x of `planes[i][y]` is bit i of the hex digit for the cell (x, y).
    planes: [[u32; MAX_SIDE]; 4],
}

impl Digits {
    fn in_all_layouts(values: &[Vec<u8>], table: MazeSize) -> Vec<Self> {
        Layout::all().map(|layout| Self::new(values, table, layout)).collect()
    }

    fn new(values: &[Vec<u8>], table: MazeSize, layout: Layout) -> Self {
        let size = layout.maze_size(table);
        let mut planes = [[0; MAX_SIDE]; 4];
        for cell in size.cells() {
            let (line, digit) = layout.position(size, cell);
            for (bit, plane) in planes.iter_mut().enumerate() {
                let value = u32::from(values[line][digit] >> bit & 1);
                plane[usize::from(cell.y)] |= value << cell.x;
            }
        }
        Self { layout, size, planes }
    }
}

/// An encoding of a maze as digits.
#[derive(Clone, Copy)]
struct Encoding<'a> {
    digits: &'a Digits,
    /// The headings that the bits 1, 2, 4 and 8 stand for.
    bits: [Heading; 4],
    /// True if a set bit means an open side, false if it means a wall.
    set_is_open: bool,
}

impl<'a> Encoding<'a> {
    /// Returns all encodings, in the order in which they are tried.
    fn all(layouts: &'a [Digits]) -> impl Iterator<Item = Self> {
        BIT_ORDERS.into_iter().flat_map(move |bits| {
            [false, true].into_iter().flat_map(move |set_is_open| {
                layouts.iter().map(move |digits| Self { digits, bits, set_is_open })
            })
        })
    }

    fn words(self) -> String {
        let set = if self.set_is_open { "open sides" } else { "walls" };
        let [one, two, four, eight] = self.bits;
        let layout = self.digits.layout.words();
        format!("{layout}; bits 1, 2, 4 and 8 are {set} to the {one}, {two}, {four} and {eight}")
    }

    /// Returns the cells that have a wall on the side `heading`. Bit x of row y stands for the cell
    /// (x, y).
    fn walls_towards(self, heading: Heading) -> [u32; MAX_SIDE] {
        let bit = self.bits.iter().position(|&side| side == heading).unwrap_or(0);
        let columns = u32::MAX >> (u32::BITS - u32::from(self.digits.size.width()));
        let open = if self.set_is_open { columns } else { 0 };
        self.digits.planes[bit].map(|row| row ^ open)
    }

    /// Returns the walls and the number of faults. Faults are contradictions, missing outer walls,
    /// and a start that is closed to the north or open to another side.
    fn decode(self) -> (Walls, u32) {
        let [north, east, south, west] = Heading::ALL.map(|heading| self.walls_towards(heading));
        let (width, height) = (self.digits.size.width(), usize::from(self.digits.size.height()));
        let columns = u32::MAX >> (u32::BITS - u32::from(width));
        let row_faults = |y: usize| {
            let above = if y + 1 < height { south[y + 1] } else { columns };
            let right = west[y] >> 1 | 1 << (width - 1);
            (north[y] ^ above).count_ones() + (east[y] ^ right).count_ones() + (!west[y] & 1)
        };
        let is_start = !north[0] & east[0] & south[0] & west[0] & 1 == 1;
        let faults = (0..height).map(row_faults).sum::<u32>()
            + (south[0] ^ columns).count_ones()
            + u32::from(!is_start);
        (Walls::from_rows(self.digits.size, north, east), faults)
    }

    fn sides(self, digit: u8) -> Sides {
        let set = if self.set_is_open { !digit } else { digit };
        let bits = self.bits.into_iter().enumerate();
        Sides::from_bits(bits.map(|(bit, heading)| (set >> bit & 1) << heading as u8).sum())
    }
}

/// The prefixes of hex numbers.
const PREFIXES: [&str; 2] = ["0x", "0X"];

/// Returns the hexadecimal digits of a line, one item for each cell, without prefixes such as `0x`.
pub(crate) fn digits(line: usize, content: &str) -> Vec<Item<'_>> {
    match items(line, content)[..] {
        [row] => characters(without_prefix(row, PREFIXES)),
        ref items => items.iter().copied().map(digit).collect(),
    }
}

/// Returns true if there is at least one item and all items are hex digits.
pub(crate) fn are_digits(items: &[Item]) -> bool {
    !items.is_empty() && items.iter().all(|item| value(item).is_some())
}

fn value(item: &Item) -> Option<u8> {
    u8::from_str_radix(item.text, 16).ok().filter(|_| item.text.len() == 1)
}

/// Removes the prefix of a single digit, if there is one.
pub(crate) fn digit(item: Item) -> Item {
    let item = without_prefix(item, PREFIXES);
    if item.text.len() == 2 { without_prefix(item, ["0"]) } else { item }
}

/// Removes the first of `prefixes` that the item starts with.
fn without_prefix(item: Item<'_>, prefixes: impl IntoIterator<Item = &'static str>) -> Item<'_> {
    let without = |prefix: &str| {
        let text = item.text.strip_prefix(prefix)?;
        Some(Item { text, column: item.column + prefix.len(), ..item })
    };
    prefixes.into_iter().find_map(without).unwrap_or(item)
}

fn characters(row: Item) -> Vec<Item> {
    (row.column..)
        .zip(row.text.char_indices())
        .map(|(column, (at, c))| Item { text: &row.text[at..at + c.len_utf8()], column, ..row })
        .take(MAX_ITEMS)
        .collect()
}

pub(crate) fn parse(text: &str) -> Result<ParsedMaze, Vec<ParseError>> {
    let (rows, table) = table(text, "hex digits", digits)?;
    let row = |row: &Vec<Item>| row.iter().map(parse_digit).collect::<Result<Vec<_>, _>>();
    let values: Vec<Vec<u8>> = rows.iter().map(row).collect::<Result<_, _>>()?;
    let layouts = Digits::in_all_layouts(&values, table);
    let mut nearest: Option<(u32, Encoding)> = None;
    let mut mazes: Vec<(Encoding, Maze)> = Vec::new();
    for encoding in Encoding::all(&layouts) {
        match encoding.decode() {
            (walls, 0) => mazes.push((encoding, unmarked_maze(walls)?)),
            (_, faults) if nearest.is_none_or(|(fewest, _)| faults < fewest) => {
                nearest = Some((faults, encoding));
            }
            _ => {}
        }
    }
    let first = mazes.iter().find(|(_, maze)| is_goal_reachable(maze)).or(mazes.first());
    if let Some((encoding, maze)) = first.cloned() {
        let is_ambiguous = mazes.iter().any(|(_, other)| *other != maze);
        let ambiguous_encoding = is_ambiguous.then(|| encoding.words());
        return Ok(ParsedMaze { ambiguous_encoding, ..maze.into() });
    }
    // If no encoding gives a maze, every encoding has a fault.
    Err(nearest.map_or_else(Vec::new, |(_, encoding)| faults(&rows, &values, encoding)))
}

fn parse_digit(item: &Item) -> Result<u8, ParseError> {
    value(item).ok_or_else(|| item.error("a hex digit"))
}

/// Returns an error for each fault of the maze in this encoding.
fn faults(rows: &[Vec<Item>], values: &[Vec<u8>], encoding: Encoding) -> Vec<ParseError> {
    let record = |(item, &value): (&Item, &u8)| CellRecord {
        sides: encoding.sides(value),
        location: item.location(),
        found: quoted(item.text),
    };
    let records: Vec<Vec<CellRecord>> = rows
        .iter()
        .zip(values)
        .map(|(row, values)| row.iter().zip(values).map(record).collect())
        .collect();
    let Digits { layout, size, .. } = *encoding.digits;
    let record = |cell| {
        let (line, digit) = layout.position(size, cell);
        &records[line][digit]
    };
    let mut errors = walls_of_cells(size, record).err().unwrap_or_default();
    let start = Cell::new(0, 0);
    let CellRecord { sides, location, found } = record(start);
    if *sides != Sides::from_bits(!1) {
        let expected = format!("the start {start} to be open only to the north");
        errors.push(ParseError::at(*location, expected, found).with_cell(start));
    }
    let nearest = format!(" (nearest encoding: {})", encoding.words());
    for error in &mut errors {
        error.found += &nearest;
    }
    errors
}

fn is_goal_reachable(maze: &Maze) -> bool {
    let (mut reached, mut ahead) = (CellSet::EMPTY, vec![maze.start().cell]);
    while let Some(cell) = ahead.pop() {
        if reached.insert(cell) {
            ahead.extend(maze.walls().open_neighbours(cell));
        }
    }
    maze.goals().iter().any(|goal| reached.contains(goal))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::format::Format;

    /// A maze whose rows are listed from north to south. In each digit, the bits 1, 2, 4 and 8 are
    /// set for walls to the north, east, south and west.
    const MAZE: &str = "9553\na93a\naaaa\nec46\n";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        assert_eq!(Format::detect(text.as_bytes()), Format::Hex, "{text}");
        Format::Hex.parse(text.as_bytes())
    }

    #[test]
    fn all_32_encodings_differ() {
        let table = MazeSize::new(1, 1).unwrap();
        let layouts = Digits::in_all_layouts(&[vec![0]], table);
        let encodings: BTreeSet<String> = Encoding::all(&layouts).map(Encoding::words).collect();
        assert_eq!((encodings.len(), Encoding::all(&layouts).count()), (32, 32));
        let first = Encoding::all(&layouts).next().map(Encoding::words);
        insta::assert_snapshot!(first.unwrap(), @"rows from the north, each starting in the west; bits 1, 2, 4 and 8 are walls to the north, east, south and west");
    }

    #[test]
    fn rows_from_the_north_are_tried_first() {
        insta::assert_snapshot!(parse(MAZE).unwrap(), @"
        o---o---o---o---o
        |               |
        o   o---o---o   o
        |   | G   G |   |
        o   o   o   o   o
        |   | G | G |   |
        o   o   o   o   o
        | S |           |
        o---o---o---o---o
        ");
    }

    #[test]
    fn every_encoding_is_inferred() {
        let maze = parse(MAZE).unwrap();
        let blank = vec![vec![0; 4]; 4];
        let layouts = Digits::in_all_layouts(&blank, maze.size());
        for encoding in Encoding::all(&layouts) {
            let text = text(&written(maze.walls(), encoding));
            assert_eq!(parse(&text).as_ref(), Ok(&maze), "{}:\n{text}", encoding.words());
        }
    }

    #[test]
    fn variations_are_equal() {
        let separated = |separator: &str, prefix: &str| -> String {
            let row = |line: &str| {
                let digits = line.chars().map(|digit| format!("{prefix}{digit}"));
                digits.collect::<Vec<_>>().join(separator) + "\n"
            };
            MAZE.lines().map(row).collect()
        };
        let before_rows = |prefix: &str| {
            prefix.to_string() + &MAZE.trim_end().replace('\n', &format!("\n{prefix}"))
        };
        for (what, text) in [
            ("capitals", MAZE.to_uppercase()),
            ("carriage returns and blank lines", MAZE.replace('\n', "\r\n\r\n")),
            ("blanks", separated(" ", "")),
            ("commas", separated(",", "")),
            ("commas and blanks", separated(", ", "")),
            ("trailing commas", separated(",", "").replace('\n', ",\n")),
            ("0x before each digit", separated(", ", "0x")),
            ("0X before each digit", separated(", ", "0X").to_uppercase()),
            ("two digits", separated(" ", "0")),
            ("0x and two digits", separated(",", "0x0")),
            ("0x before each row", before_rows("0x")),
            ("0X before each row", before_rows("0X")),
        ] {
            assert_eq!(parse(&text), parse(MAZE), "{what}");
        }
    }

    #[test]
    fn errors_name_the_nearest_encoding() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("a93a", "a92a"), @r#"line 1, column 3: expected no wall between (2, 2) and (2, 3) to match line 2, column 3, found "5" (nearest encoding: rows from the north, each starting in the west; bits 1, 2, 4 and 8 are walls to the north, east, south and west)"#);
        insta::assert_snapshot!(error("9553", "1553"), @r#"line 1, column 1: expected an outer wall to the west of (0, 3), found "1" (nearest encoding: rows from the north, each starting in the west; bits 1, 2, 4 and 8 are walls to the north, east, south and west)"#);
        insta::assert_snapshot!(error("ec46", "cc46"), @r#"line 4, column 2: expected no wall between (0, 0) and (1, 0) to match line 4, column 1, found "c" (nearest encoding: rows from the north, each starting in the west; bits 1, 2, 4 and 8 are walls to the north, east, south and west)"#);
        insta::assert_snapshot!(error("a93a", "a93"), @"line 2, column 4: expected 4 hex digits, as on line 1, found 3");
        insta::assert_snapshot!(error("a93a", "a93g"), @r#"line 2, column 4: expected a hex digit, found "g""#);
        insta::assert_snapshot!(parse("f\n").unwrap_err(), @r#"line 1, column 1: expected the start (0, 0) to be open only to the north, found "f" (nearest encoding: rows from the north, each starting in the west; bits 1, 2, 4 and 8 are walls to the north, east, south and west)"#);
    }

    fn text(values: &[Vec<u8>]) -> String {
        let digit = |&value: &u8| char::from_digit(value.into(), 16).unwrap();
        values.iter().flat_map(|line| line.iter().map(digit).chain(['\n'])).collect()
    }

    /// Encodes walls as digits.
    fn written(walls: &Walls, encoding: Encoding) -> Vec<Vec<u8>> {
        // `maze_size` is its own inverse.
        let layout = encoding.digits.layout;
        let table = layout.maze_size(walls.size());
        let mut values = vec![vec![0; table.width().into()]; table.height().into()];
        for cell in walls.size().cells() {
            let (line, digit) = layout.position(walls.size(), cell);
            let sides = walls.sides(cell);
            values[line][digit] = (0..16).find(|&value| encoding.sides(value) == sides).unwrap();
        }
        values
    }

    /// Generates random walls with a valid start.
    fn any_walls() -> impl Strategy<Value = Walls> {
        let rows = prop::array::uniform32(any::<u32>());
        (1usize..=8, 2usize..=8, rows, rows).prop_map(|(width, height, north, east)| {
            let mut walls = Walls::from_rows(MazeSize::new(width, height).unwrap(), north, east);
            walls.set(Cell::new(0, 0), Heading::North, false);
            walls.set(Cell::new(0, 0), Heading::East, true);
            walls
        })
    }

    proptest! {
        #[test]
        fn decoding_equals_comparing_cell_by_cell(
            walls in any_walls(),
            written_in in any::<prop::sample::Index>(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), 0u8..16), 0..3),
        ) {
            let layouts = |values: &[Vec<u8>]| {
                let table = MazeSize::new(values[0].len(), values.len()).unwrap();
                Digits::in_all_layouts(values, table)
            };
            let side = usize::from(walls.size().width().max(walls.size().height()));
            let blank = layouts(&vec![vec![0; side]; side]);
            let encoding = Encoding::all(&blank).nth(written_in.index(32)).unwrap();
            let mut values = written(&walls, encoding);
            let is_damaged = !damage.is_empty();
            for (place, value) in damage {
                let place = place.index(values.len() * values[0].len());
                let width = values[0].len();
                values[place / width][place % width] = value;
            }
            let text = text(&values);
            let rows: Vec<Vec<Item>> = text.lines().zip(1..).map(|(row, line)| digits(line, row)).collect();
            for encoding in Encoding::all(&layouts(&values)) {
                let errors = faults(&rows, &values, encoding);
                let (decoded, count) = encoding.decode();
                prop_assert_eq!(count as usize, errors.len(), "{}", encoding.words());
                if errors.is_empty() {
                    for cell in decoded.size().cells() {
                        let (line, digit) = encoding.digits.layout.position(decoded.size(), cell);
                        prop_assert_eq!(decoded.sides(cell), encoding.sides(values[line][digit]));
                    }
                }
            }
            prop_assert!(is_damaged || Format::Hex.read(text.as_bytes()).is_ok());
        }
    }
}
