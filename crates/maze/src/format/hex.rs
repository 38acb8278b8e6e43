//! Rows of hex digits, a digit a cell, of which nobody says how they lie and what their bits mean:
//! it is found out by trying.

mod faults;

use faults::{Faults, is_start};

use super::rows::{Item, MAX_ITEMS, items, table};
use super::stated::{self, Stated};
use super::{ParseError, Reading, quoted, unmarked};
use crate::{Cell, CellSet, Heading, Maze, MazeSize, Sides, Walls};

/// A way to read the digits.
#[derive(Clone, Copy)]
struct Way {
    lie: Lie,
    /// Whether a bit that is set means an open side.
    set_is_open: bool,
    /// The headings of the bits 1, 2, 4 and 8.
    bits: [Heading; 4],
}

/// How the lines of the file lie in the maze.
#[derive(Clone, Copy)]
struct Lie {
    /// Whether a line is a column of the maze instead of a row.
    columns: bool,
    /// Whether the first line is at the north or east edge.
    lines_back: bool,
    /// Whether the first digit of a line is at the north or east edge.
    digits_back: bool,
}

impl Lie {
    /// The order in which they are tried: as one would draw a maze, as `.maz` has it, then the rest.
    const ALL: [Self; 8] = {
        const fn lie(columns: bool, lines_back: bool, digits_back: bool) -> Lie {
            Lie { columns, lines_back, digits_back }
        }
        [
            lie(false, true, false),
            lie(true, false, false),
            lie(false, true, true),
            lie(false, false, false),
            lie(false, false, true),
            lie(true, false, true),
            lie(true, true, false),
            lie(true, true, true),
        ]
    };

    fn words(self) -> String {
        let (lines, far, near, across, from) = if self.columns {
            ("columns", "east", "west", "north", "south")
        } else {
            ("rows", "north", "south", "east", "west")
        };
        let lines_from = if self.lines_back { far } else { near };
        let digits_from = if self.digits_back { across } else { from };
        format!("{lines} from the {lines_from}, each from the {digits_from}")
    }

    /// The size of a maze of which there are so many lines of so many digits.
    fn size(self, lines: MazeSize) -> MazeSize {
        let (digits, lines) = (usize::from(lines.width()), usize::from(lines.height()));
        let (width, height) = if self.columns { (lines, digits) } else { (digits, lines) };
        MazeSize::new(width, height).unwrap_or(MazeSize::CLASSIC)
    }

    /// The line and the digit in it that stand for a cell.
    fn place(self, size: MazeSize, Cell { x, y }: Cell) -> (usize, usize) {
        let (line, lines, digit, digits) = if self.columns {
            (x, size.width(), y, size.height())
        } else {
            (y, size.height(), x, size.width())
        };
        let at = |index: u8, count: u8, back: bool| {
            usize::from(if back { count - 1 - index } else { index })
        };
        (at(line, lines, self.lines_back), at(digit, digits, self.digits_back))
    }
}

impl Way {
    /// All of them, in the order in which they are tried. What is usual for bits goes first, since it
    /// leaves but one way to turn the maze, while of a maze with several dead ends in its corners
    /// each can be the start for some order of the bits. Of the unusual bits each is as likely as
    /// the others, so there what is usual for the lines goes first.
    fn all() -> impl Iterator<Item = Self> {
        let usual = USUAL_BITS.into_iter().flat_map(|bits| {
            [false, true]
                .into_iter()
                .flat_map(move |set_is_open| Lie::ALL.map(|lie| Self { lie, set_is_open, bits }))
        });
        let unusual = Lie::ALL.into_iter().flat_map(|lie| {
            unusual_bits().flat_map(move |bits| {
                [false, true].map(|set_is_open| Self { lie, set_is_open, bits })
            })
        });
        usual.chain(unusual)
    }

    /// The sides with a wall.
    fn sides(self, digit: u8) -> Sides {
        let set = if self.set_is_open { !digit } else { digit };
        (0..)
            .zip(self.bits)
            .filter(|&(bit, _)| set >> bit & 1 == 1)
            .fold(Sides::NONE, |sides, (_, heading)| sides.or(Sides::of(heading)))
    }

    fn words(self) -> String {
        let set = if self.set_is_open { "open" } else { "walls" };
        let [one, two, four, eight] = self.bits;
        format!("{}, bits 1 2 4 8 {set} {one} {two} {four} {eight}", self.lie.words())
    }
}

/// The orders of the headings that most write: clockwise from the north and counter-clockwise from
/// the east.
const USUAL_BITS: [[Heading; 4]; 2] = {
    use Heading::{East, North, South, West};
    [[North, East, South, West], [East, North, West, South]]
};

/// The other orders of the headings, as in a dictionary.
fn unusual_bits() -> impl Iterator<Item = [Heading; 4]> {
    let all = || Heading::ALL.into_iter();
    let pairs = all().flat_map(move |a| all().map(move |b| (a, b)));
    let orders =
        pairs.flat_map(move |(a, b)| all().flat_map(move |c| Heading::ALL.map(|d| [a, b, c, d])));
    orders.filter(|order| {
        !USUAL_BITS.contains(order) && Heading::ALL.iter().all(|heading| order.contains(heading))
    })
}

/// What says of a number that it is hex.
const SIGNS: [&str; 2] = ["0x", "0X"];

/// The digits of a line, which may be parted by commas, semicolons or blanks; then each may have
/// a `0x` or a 0 before it.
pub(super) fn digits(line: usize, content: &str) -> Vec<Item<'_>> {
    match items(line, content)[..] {
        [row] => characters(without(row, SIGNS)),
        ref items => items.iter().copied().map(digit).collect(),
    }
}

/// Whether all items are hex digits, and there are some.
pub(super) fn are_digits(items: &[Item]) -> bool {
    !items.is_empty() && items.iter().all(|item| value(item).is_some())
}

fn value(item: &Item) -> Option<u8> {
    u8::from_str_radix(item.text, 16).ok().filter(|_| item.text.len() == 1)
}

/// A digit that stands alone.
pub(super) fn digit(item: Item) -> Item {
    let item = without(item, SIGNS);
    if item.text.len() == 2 { without(item, ["0"]) } else { item }
}

/// The item without the first of these that stands before it.
fn without(item: Item<'_>, prefixes: impl IntoIterator<Item = &'static str>) -> Item<'_> {
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

pub(super) fn read(text: &str) -> Result<Reading, Vec<ParseError>> {
    let (rows, lines) = table(text, "hex digits", digits)?;
    let row = |row: &Vec<Item>| row.iter().map(parse_digit).collect::<Result<Vec<_>, _>>();
    let values: Vec<Vec<u8>> = rows.iter().map(row).collect::<Result<_, _>>()?;
    let faults = Faults::count(&values, lines);
    let mut nearest: Option<(u32, Way)> = None;
    let mut mazes: Vec<(Way, Maze)> = Vec::new();
    for way in Way::all() {
        match faults.for_way(way) {
            0 => mazes.push((way, unmarked(walls(&values, lines, way))?)),
            faults if nearest.is_none_or(|(fewest, _)| faults < fewest) => {
                nearest = Some((faults, way));
            }
            _ => {}
        }
    }
    let taken = mazes.iter().find(|(_, maze)| reaches_goal(maze)).or(mazes.first());
    if let Some((way, maze)) = taken.cloned() {
        let is_ambiguous = mazes.iter().any(|(_, other)| *other != maze);
        let ambiguous_way = is_ambiguous.then(|| way.words());
        return Ok(Reading { ambiguous_way, ..Reading::of(maze) });
    }
    // There is one, since there are ways.
    Err(nearest.map_or_else(Vec::new, |(_, way)| miss(&rows, &values, lines, way)))
}

fn parse_digit(item: &Item) -> Result<u8, ParseError> {
    value(item).ok_or_else(|| item.error("a hex digit"))
}

/// The walls of digits that do not contradict each other.
fn walls(values: &[Vec<u8>], lines: MazeSize, way: Way) -> Walls {
    let size = way.lie.size(lines);
    let mut walls = Walls::open(size);
    for cell in size.cells() {
        let (line, digit) = way.lie.place(size, cell);
        let sides = way.sides(values[line][digit]);
        for heading in [Heading::North, Heading::East] {
            walls.set(cell, heading, sides.has(heading));
        }
    }
    walls
}

/// What is wrong with the digits in the way in which the least is wrong.
fn miss(rows: &[Vec<Item>], values: &[Vec<u8>], lines: MazeSize, way: Way) -> Vec<ParseError> {
    let mut errors = stated_walls(rows, values, lines, way).err().unwrap_or_default();
    let start = Cell::new(0, 0);
    let (line, digit) = way.lie.place(way.lie.size(lines), start);
    if !is_start(way.sides(values[line][digit])) {
        let expected = format!("the start cell {start} closed but to the north");
        errors.push(rows[line][digit].error(expected).with_cell(start));
    }
    let nearest = format!(", in the nearest of all ways to read it: {}", way.words());
    for error in &mut errors {
        error.found += &nearest;
    }
    errors
}

fn stated_walls(
    rows: &[Vec<Item>],
    values: &[Vec<u8>],
    lines: MazeSize,
    way: Way,
) -> Result<Walls, Vec<ParseError>> {
    let stated: Vec<Vec<Stated>> = rows
        .iter()
        .zip(values)
        .map(|(row, values)| {
            let stated = |(item, &value): (&Item, &u8)| Stated {
                sides: way.sides(value),
                place: item.place(),
                found: quoted(item.text),
            };
            row.iter().zip(values).map(stated).collect()
        })
        .collect();
    let size = way.lie.size(lines);
    stated::walls(size, |cell| {
        let (line, digit) = way.lie.place(size, cell);
        &stated[line][digit]
    })
}

/// Whether a mouse can go from the start to the goal.
fn reaches_goal(maze: &Maze) -> bool {
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

    use super::*;
    use crate::Format;

    /// Rows from the north, bits north east south west set where there is a wall.
    const MAZE: &str = "9553\na93a\naaaa\nec46\n";

    fn read(text: &str) -> String {
        assert_eq!(Format::detect(text.as_bytes()), Format::Hex, "{text}");
        text.parse::<Maze>().map_or_else(|error| error.to_string(), |maze| maze.to_string())
    }

    #[test]
    fn there_are_384_ways_to_read_them() {
        let ways: BTreeSet<String> = Way::all().map(Way::words).collect();
        assert_eq!((ways.len(), Way::all().count()), (384, 384));
        let first = Way::all().next().map(Way::words);
        insta::assert_snapshot!(first.unwrap(), @"rows from the north, each from the west, bits 1 2 4 8 walls north east south west");
    }

    #[test]
    fn the_way_is_found_out() {
        insta::assert_snapshot!(read(MAZE), @"
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

    /// Writes a maze in every way and reads it back.
    #[test]
    fn every_way_is_found_out() {
        let maze: Maze = MAZE.parse().unwrap();
        for way in Way::all() {
            let size = way.lie.size(maze.size());
            let mut lines = vec![vec![' '; usize::from(size.width())]; usize::from(size.height())];
            for cell in maze.size().cells() {
                let (line, digit) = way.lie.place(maze.size(), cell);
                let sides = maze.walls().sides(cell);
                let value = (0..16).find(|&value| way.sides(value) == sides).unwrap();
                lines[line][digit] = char::from_digit(value.into(), 16).unwrap();
            }
            let text: String =
                lines.into_iter().map(|line| line.into_iter().collect::<String>() + "\n").collect();
            assert_eq!(text.parse().as_ref(), Ok(&maze), "{}:\n{text}", way.words());
        }
    }

    #[test]
    fn variations_read_alike() {
        let parted = |between: &str, prefix: &str| -> String {
            let row = |line: &str| {
                let digits = line.chars().map(|digit| format!("{prefix}{digit}"));
                digits.collect::<Vec<_>>().join(between) + "\n"
            };
            MAZE.lines().map(row).collect()
        };
        let before_rows =
            |sign: &str| sign.to_string() + &MAZE.trim_end().replace('\n', &format!("\n{sign}"));
        for (what, text) in [
            ("capitals", MAZE.to_uppercase()),
            ("carriage returns and blank lines", MAZE.replace('\n', "\r\n\r\n")),
            ("blanks", parted(" ", "")),
            ("commas", parted(",", "")),
            ("commas and blanks", parted(", ", "")),
            ("trailing commas", parted(",", "").replace('\n', ",\n")),
            ("a sign of hex", parted(", ", "0x")),
            ("a capital sign of hex", parted(", ", "0X").to_uppercase()),
            ("two digits", parted(" ", "0")),
            ("a sign of hex and two digits", parted(",", "0x0")),
            ("a sign of hex before a row", before_rows("0x")),
            ("a capital sign of hex before a row", before_rows("0X")),
        ] {
            assert_eq!(Format::detect(text.as_bytes()), Format::Hex, "{what}");
            assert_eq!(text.parse::<Maze>(), MAZE.parse(), "{what}");
        }
    }

    /// Three corners may be the start. From the one to the south-west, which is tried first, the
    /// goal cannot be reached.
    #[test]
    fn of_several_mazes_that_one_is_taken_whose_goal_can_be_reached() {
        let digits = "d3b\nb82\nec6\n";
        let values = [vec![13, 3, 11], vec![11, 8, 2], vec![14, 12, 6]];
        let faults = Faults::count(&values, MazeSize::new(3, 3).unwrap());
        assert_eq!(Way::all().filter(|&way| faults.for_way(way) == 0).count(), 3);
        insta::assert_snapshot!(read(digits), @"
        o---o---o---o
        |           |
        o---o   o   o
        |     G     |
        o   o---o---o
        | S |       |
        o---o---o---o
        ");
        let reading = Format::Hex.read(digits.as_bytes()).unwrap();
        insta::assert_snapshot!(reading.ambiguous_way.unwrap(), @"columns from the west, each from the south, bits 1 2 4 8 walls west north east south");
        assert_eq!(Format::Hex.read(MAZE.as_bytes()).unwrap().ambiguous_way, None);
        let symmetric = Format::Hex.read(b"93\nee\n").unwrap();
        assert_eq!(symmetric.ambiguous_way, None, "all ways give the same maze");
    }

    #[test]
    fn errors_tell_the_nearest_miss() {
        let error = |from: &str, to: &str| {
            MAZE.replacen(from, to, 1).parse::<Maze>().unwrap_err().to_string()
        };
        insta::assert_snapshot!(error("a93a", "a92a"), @r#"line 1, column 3: expected (2, 3) open to the south, as (2, 2) is to the north at line 2, column 3, found "5", in the nearest of all ways to read it: rows from the north, each from the west, bits 1 2 4 8 walls north east south west"#);
        insta::assert_snapshot!(error("9553", "1553"), @r#"line 1, column 1: expected (0, 3) closed to the west, an outer wall, found "1", in the nearest of all ways to read it: rows from the north, each from the west, bits 1 2 4 8 walls north east south west"#);
        insta::assert_snapshot!(error("ec46", "cc46"), @r#"line 4, column 2: expected (1, 0) open to the west, as (0, 0) is to the east at line 4, column 1, found "c", in the nearest of all ways to read it: rows from the north, each from the west, bits 1 2 4 8 walls north east south west"#);
        insta::assert_snapshot!(error("a93a", "a93"), @"line 2, column 4: expected 4 hex digits, as on line 1, found 3");
        insta::assert_snapshot!(error("a93a", "a93g"), @r#"line 2, column 4: expected a hex digit, found "g""#);
        insta::assert_snapshot!("f\n".parse::<Maze>().unwrap_err(), @r#"line 1, column 1: expected the start cell (0, 0) closed but to the north, found "f", in the nearest of all ways to read it: rows from the north, each from the west, bits 1 2 4 8 walls north east south west"#);
    }
}
