//! Counts how much is wrong with a table of digits, for each way to read it.

use std::array::from_fn;

use super::Way;
use crate::{Cell, Heading, MazeSize, Sides};

/// Counts that give the faults of every way, so that no way has to look at each digit again.
///
/// Every layout has the same neighbours, because it turns or mirrors the table as a whole. The ways
/// differ only in which bit of a digit stands for the wall to which neighbour.
pub(super) struct Faults<'a> {
    values: &'a [Vec<u8>],
    lines: MazeSize,
    /// At `[a][b]` the digits whose bit a differs from bit b of the digit in the same place of the
    /// next line.
    between_lines: Pairs,
    /// At `[a][b]` the digits whose bit a differs from bit b of the next digit of the line.
    between_digits: Pairs,
    /// How many digits have each bit set: on the first line, on the last line, in the first place of
    /// a line, in the last place.
    edges: [[u32; 4]; 4],
}

type Pairs = [[u32; 4]; 4];

impl<'a> Faults<'a> {
    /// Counts in a table of this size, whose width is the length of a line.
    pub(super) fn count(values: &'a [Vec<u8>], lines: MazeSize) -> Self {
        let planes: Vec<[u32; 4]> = values.iter().map(|line| planes(line)).collect();
        let last = usize::from(lines.width()) - 1;
        let has_next = !(u32::MAX << last);
        let pairs = |count: &dyn Fn(usize, usize) -> u32| from_fn(|a| from_fn(|b| count(a, b)));
        let on_line =
            |line: Option<&[u32; 4]>| line.map_or([0; 4], |line| line.map(u32::count_ones));
        let in_place =
            |place| from_fn(|bit| planes.iter().map(|line| line[bit] >> place & 1).sum());
        Self {
            values,
            lines,
            between_lines: pairs(&|a, b| {
                planes.windows(2).map(|two| (two[0][a] ^ two[1][b]).count_ones()).sum()
            }),
            between_digits: pairs(&|a, b| {
                let differ = |line: &[u32; 4]| (line[a] ^ line[b] >> 1) & has_next;
                planes.iter().map(|line| differ(line).count_ones()).sum()
            }),
            edges: [on_line(planes.first()), on_line(planes.last()), in_place(0), in_place(last)],
        }
    }

    /// Returns how many sides of cells contradict the neighbour there or lack an outer wall, plus one
    /// unless the start is closed on all sides but the north.
    pub(super) fn for_way(&self, way: Way) -> u32 {
        // The headings in which lines and digits follow each other.
        let (lines, digits) = if way.lie.columns {
            (Heading::East, Heading::North)
        } else {
            (Heading::North, Heading::East)
        };
        let forward = |heading: Heading, back| if back { heading.back() } else { heading };
        let bit = |heading| way.bits.iter().position(|&of_bit| of_bit == heading).unwrap_or(0);
        let both = |heading: Heading| (bit(heading), bit(heading.back()));
        let (next_line, line_before) = both(forward(lines, way.lie.lines_back));
        let (next_digit, digit_before) = both(forward(digits, way.lie.digits_back));
        let outer = [line_before, next_line, digit_before, next_digit];
        let (width, height) = (self.lines.width().into(), self.lines.height().into());
        let gaps = self.edges.iter().zip(outer).zip([width, width, height, height]);
        let gaps = gaps.map(
            |((set, bit), length): (_, u32)| {
                if way.set_is_open { set[bit] } else { length - set[bit] }
            },
        );
        let start = u32::from(!is_start(way.sides(self.value(way, Cell::new(0, 0)))));
        // Both cells count.
        2 * self.between_lines[next_line][line_before]
            + 2 * self.between_digits[next_digit][digit_before]
            + gaps.sum::<u32>()
            + start
    }

    fn value(&self, way: Way, cell: Cell) -> u8 {
        let (line, digit) = way.lie.place(way.lie.size(self.lines), cell);
        self.values[line][digit]
    }
}

/// The bits of a line of digits: bit i of plane k is bit k of digit i.
fn planes(line: &[u8]) -> [u32; 4] {
    let plane = |bit| (0..).zip(line).map(|(at, value)| u32::from(value >> bit & 1) << at).sum();
    from_fn(plane)
}

/// Walls west, south and east and none north.
pub(super) fn is_start(sides: Sides) -> bool {
    Heading::ALL.into_iter().all(|heading| sides.has(heading) != (heading == Heading::North))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{
        digits, miss, parse_digit, reaches_goal, read, stated_walls, table, unmarked,
    };
    use super::*;
    use crate::format::{ParseError, Reading};
    use crate::{Maze, Walls};

    /// The same, cell by cell.
    fn naive(values: &[Vec<u8>], lines: MazeSize, way: Way) -> u32 {
        let size = way.lie.size(lines);
        let sides = |cell| {
            let (line, digit) = way.lie.place(size, cell);
            way.sides(values[line][digit])
        };
        let agrees = |here: Cell, heading: Heading| match size.neighbour(here, heading) {
            None => sides(here).has(heading),
            Some(there) => sides(here).has(heading) == sides(there).has(heading.back()),
        };
        let pairs = size.cells().flat_map(|cell| Heading::ALL.map(|heading| (cell, heading)));
        let wrong = pairs.filter(|&(cell, heading)| !agrees(cell, heading)).count();
        let start = u32::from(!is_start(sides(Cell::new(0, 0))));
        u32::try_from(wrong).unwrap() + start
    }

    /// Reads hex digits as `read` does, but counts and takes the walls cell by cell.
    fn read_naively(text: &str) -> Result<Reading, Vec<ParseError>> {
        let (rows, lines) = table(text, "hex digits", digits)?;
        let values = rows.iter().map(|row| row.iter().map(parse_digit).collect());
        let values: Vec<Vec<u8>> = values.collect::<Result<_, _>>()?;
        let is_fault_free = |way: &Way| naive(&values, lines, *way) == 0;
        let read =
            |way| unmarked(stated_walls(&rows, &values, lines, way)?).map(|maze| (way, maze));
        let mazes: Vec<(Way, Maze)> =
            Way::all().filter(is_fault_free).map(read).collect::<Result<_, _>>()?;
        let Some((way, maze)) =
            mazes.iter().find(|(_, maze)| reaches_goal(maze)).or(mazes.first()).cloned()
        else {
            let nearest = Way::all().min_by_key(|&way| naive(&values, lines, way)).unwrap();
            return Err(miss(&rows, &values, lines, nearest));
        };
        let is_ambiguous = mazes.iter().any(|(_, other)| *other != maze);
        Ok(Reading { ambiguous_way: is_ambiguous.then(|| way.words()), ..Reading::of(maze) })
    }

    /// Writes walls as hex digits, to be read in this way.
    fn written(walls: &Walls, way: Way) -> Vec<Vec<u8>> {
        // The layout is its own inverse but for the size, which a column of lines turns.
        let turned = way.lie.size(walls.size());
        let mut values = vec![vec![0; usize::from(turned.width())]; usize::from(turned.height())];
        for cell in walls.size().cells() {
            let (line, digit) = way.lie.place(walls.size(), cell);
            let sides = walls.sides(cell);
            values[line][digit] = (0..16).find(|&value| way.sides(value) == sides).unwrap();
        }
        values
    }

    /// Walls of a maze, at random but for the start.
    fn any_walls() -> impl Strategy<Value = Walls> {
        let rows = prop::array::uniform32(any::<u32>());
        (1usize..=8, 2usize..=8, rows, rows).prop_map(|(width, height, north, east)| {
            let mut walls = Walls::from_rows(MazeSize::new(width, height).unwrap(), north, east);
            walls.set(Cell::new(0, 0), Heading::North, false);
            walls.set(Cell::new(0, 0), Heading::East, true);
            walls
        })
    }

    fn check(values: &[Vec<u8>]) {
        let lines = MazeSize::new(values[0].len(), values.len()).unwrap();
        let faults = Faults::count(values, lines);
        for way in Way::all() {
            assert_eq!(faults.for_way(way), naive(values, lines, way), "{}", way.words());
        }
    }

    #[test]
    fn tables_of_all_shapes_count_as_cell_by_cell() {
        for (lines, digits) in [(1, 1), (1, 32), (32, 1), (2, 2), (31, 32), (32, 32)] {
            for value in [0b0000, 0b0001, 0b0110, 0b1111] {
                check(&vec![vec![value; digits]; lines]);
            }
        }
    }

    proptest! {
        #[test]
        fn any_table_counts_as_cell_by_cell(
            digits in 1usize..=32,
            mut values in prop::collection::vec(prop::collection::vec(0u8..16, 32), 1..=32),
        ) {
            for line in &mut values {
                line.truncate(digits);
            }
            check(&values);
        }

        #[test]
        fn mazes_damaged_or_not_read_as_cell_by_cell(
            walls in any_walls(),
            way in any::<prop::sample::Index>(),
            damage in prop::collection::vec((any::<prop::sample::Index>(), 0u8..16), 0..3),
        ) {
            let ways: Vec<Way> = Way::all().collect();
            let mut values = written(&walls, ways[way.index(ways.len())]);
            let is_whole = damage.is_empty();
            for (place, value) in damage {
                let width = values[0].len();
                let place = place.index(width * values.len());
                values[place / width][place % width] = value;
            }
            let digit = |value: u8| char::from_digit(value.into(), 16).unwrap();
            let line = |line: Vec<u8>| line.into_iter().map(digit).chain(['\n']).collect::<String>();
            let text: String = values.into_iter().map(line).collect();
            let reading = read(&text);
            prop_assert!(!is_whole || reading.is_ok());
            prop_assert_eq!(reading, read_naively(&text));
        }
    }
}
