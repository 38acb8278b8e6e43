//! Mazes as a number for each cell: rows of digits, tables, arrays of a program, and bytes.
//!
//! Few files tell the order of the cells and the meaning of the bits. All [encodings](Encoding) are
//! tried: adjacent cells must agree about the wall between them, the outer wall must be closed, and
//! the start must be open only to the north. A file that fits several mazes is ambiguous.

use mmsim_maze::{Cell, CellSet, Heading, Sides};

use crate::encoding::{Bits, Encoding, Rows};
use crate::error::{Location, Note, NoteKind, ParseError, ParseErrorKind};
use crate::parsed_maze::{self, Notation, ParsedMaze, faults, maze, size, walls};
use crate::read::Choice;
use crate::rows::{Item, Row, rows, without_code};

/// The numbers of a file.
struct Table {
    /// The numbers of each line and their locations. All lines have the same length.
    lines: Vec<Vec<(u8, Location)>>,
    /// The encoding, if the file tells it.
    encoding: Option<Encoding>,
    notes: Vec<Note>,
}

/// Reads a file of bytes: one for each cell of a 16×16 or 32×32 maze, in columns from the west, each
/// from the south. Returns `None` for a file of another kind.
pub(crate) fn parse_bytes(
    content: &[u8],
    choice: Choice,
) -> Option<Result<ParsedMaze, Vec<ParseError>>> {
    let all = |is: fn(u8) -> bool| content.iter().all(|&byte| is(byte));
    let is_low = all(|byte| byte < 16) && !all(|byte| (9..=13).contains(&byte));
    let is_text = all(|byte| (9..=13).contains(&byte) || byte >= 32);
    let Some(side) = [16, 32].into_iter().find(|side| side * side == content.len()) else {
        let expected = "256 or 1024 bytes, one for each cell of a 16x16 or 32x32 maze";
        let at = Location::Byte(content.len() + 1);
        let error = ParseError::new(at, expected, content.len().to_string());
        return is_low.then(|| Err(error.into()));
    };
    let numbers: Vec<_> = content.iter().copied().zip((1..).map(Location::Byte)).collect();
    let lines = numbers.chunks(side).map(<[_]>::to_vec).collect();
    let encoding = Some(Encoding { bits: Bits::WALLS, rows: Rows::WEST });
    let table = Table { lines, encoding, notes: Vec::new() };
    let parsed = table.parse(choice);
    let is_maz = is_low || !is_text && content[0] & 15 == 14;
    (is_maz || parsed.is_ok()).then_some(parsed)
}

/// Reads text with a number for each cell. Returns `None` for text of another kind.
pub(crate) fn parse_text(
    text: &str,
    choice: Choice,
) -> Option<Result<ParsedMaze, Vec<ParseError>>> {
    let is_digit = |byte: &u8| byte.is_ascii_hexdigit();
    let drawn = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).count();
    if 6 * text.bytes().filter(is_digit).count() < drawn {
        return None;
    }
    let text = without_code(text);
    let mut rows = rows(&text);
    let route = split_off_route(&mut rows);
    let is_single = |row: &Row| !row.is_separated || row.items[0].text.len() > 2;
    let is_word = |row: &&Row| row.items.len() == 1 && is_single(row);
    let are_words = 2 * rows.iter().filter(is_word).count() >= rows.len();
    let mut lines: Vec<Vec<Item>> = rows.iter().map(|row| row.numbers(are_words)).collect();
    if lines.len() == 1 && text.contains(['{', '[']) {
        lines = lines[0].chunks(lines[0].len().isqrt()).map(<[_]>::to_vec).collect();
    }
    let is_number = |item: &Item| item.number(are_words).or_else(|| item.number(true)).is_some();
    let is_numbers = |line: &Vec<Item>| line.iter().all(is_number);
    let [first, last] = [lines.iter().position(is_numbers)?, lines.iter().rposition(is_numbers)?];
    let table = &lines[first..=last];
    // Other lists of numbers have lines of different lengths, or words between them.
    let usual = table[table.len() / 2].len();
    let is_usual = |line: &&Vec<Item>| is_numbers(line) && line.len() == usual;
    let count = table.iter().filter(is_usual).count();
    if table.len() < 2 || 4 * count + 6 < 3 * table.len() || 2 * count + 1 < lines.len() {
        return None;
    }
    let around = lines[..first].iter().chain(&lines[last + 1..]);
    let mut notes: Vec<Note> = around.map(|line| line[0].ignored()).collect();
    let (mut encoding, mut numbers) = (None, table);
    if table.len() > 2 && table[0].len() < usual.min(3) {
        // The size is above the numbers. In files of the trial, it is the side of the square.
        numbers = &table[1..];
        match rows[first].items[..] {
            [length] if length.text.parse() != Ok(usual) => notes.push(length.ignored()),
            [length] if numbers.len() != usual => {
                let expected = format!("{} lines of numbers below", numbers.len());
                return Some(Err(length.error(expected).into()));
            }
            [_] => encoding = Some(Encoding { bits: Bits::OPENINGS, rows: Rows::WEST }),
            ref size => notes.push(size[0].ignored()),
        }
    }
    let is_letter = |item: &Item| item.number(false).is_none() && item.number(true).is_some();
    let is_hex = are_words || numbers.iter().flatten().any(is_letter);
    let parsed = Table::new(numbers, is_hex).map_err(Vec::from).and_then(|table| match route {
        Some(route) => {
            let (bits, rows) = (Bits::WALLS, Rows::NORTH);
            let table = Table { encoding: Some(Encoding { bits, rows }), notes, ..table };
            add_route(&route, table.parse(Choice { bits: Some(bits), rows: Some(rows) })?)
        }
        None => Table { encoding, notes, ..table }.parse(choice),
    });
    let is_other = |error: &ParseError| error.kind == ParseErrorKind::NotAMaze;
    let is_none = |errors: &Vec<ParseError>| numbers.len() == 1 || errors.iter().any(is_other);
    Some(parsed).filter(|parsed| !parsed.as_ref().is_err_and(is_none))
}

impl Table {
    fn new(lines: &[Vec<Item>], is_hex: bool) -> Result<Self, ParseError> {
        let first = &lines[0];
        if let Some(line) = lines.iter().find(|line| line.len() != first.len()) {
            let expected = format!("{} numbers, as on line {}", first.len(), first[0].line);
            let end = line[line.len() - 1].end();
            return Err(ParseError::new(end, expected, line.len().to_string()));
        }
        let number = |item: &Item| {
            let expected = if is_hex { "a hex digit" } else { "a whole number from 0 to 16" };
            let number = item.number(is_hex).ok_or_else(|| item.error(expected))?;
            Ok((number, item.location()))
        };
        let lines = lines.iter().map(|line| line.iter().map(number).collect());
        Ok(Self { lines: lines.collect::<Result<_, _>>()?, encoding: None, notes: Vec::new() })
    }

    /// Decides which maze the numbers mean.
    fn parse(&self, choice: Choice) -> Result<ParsedMaze, Vec<ParseError>> {
        let (at, items, lines) = (self.lines[0][0].1, self.lines[0].len(), self.lines.len());
        let sizes = [size(at, items, lines)?, size(at, lines, items)?];
        let size = |rows: Rows| sizes[usize::from(rows.are_columns())];
        let number = |rows: Rows, cell| {
            let (line, item) = rows.position(size(rows), cell);
            self.lines[line][item]
        };
        let numbers = || self.lines.iter().flatten();
        let has_meaning = |bits: &Bits| numbers().all(|&(number, _)| bits.sides(number).is_some());
        let bits = Bits::all().filter(has_meaning);
        let encodings = bits.flat_map(|bits| Rows::all().map(move |rows| Encoding { bits, rows }));
        let encodings: Vec<Encoding> = encodings.filter(|it| choice.allows(*it)).collect();
        let walled = |Encoding { bits, rows }| {
            move |cell| bits.sides(number(rows, cell).0).unwrap_or(Sides::from_bits(0))
        };
        let faults = |encoding: &Encoding| faults(size(encoding.rows), walled(*encoding));
        let own = self.encoding.filter(|own| encodings.contains(own));
        let rank = |it: &Encoding| (own == Some(*it), walled(*it)(Cell::new(0, 0)) == START);
        let fits = |it: &&Encoding| faults(it).next().is_none();
        let mut fitting: Vec<Encoding> = encodings.iter().filter(fits).copied().collect();
        let best = fitting.iter().map(rank).max();
        fitting.retain(|encoding| Some(rank(encoding)) == best);
        let decode = |encoding: Encoding| {
            let place = |cell| {
                let (number, location) = number(encoding.rows, cell);
                let nearest = format!(" (nearest encoding: {encoding})");
                (location, format!("{number}{}", if own.is_some() { "" } else { &nearest }))
            };
            walls(size(encoding.rows), walled(encoding), place)
        };
        let mut readings: Vec<ParsedMaze> = Vec::new();
        for encoding in fitting {
            let maze = maze(decode(encoding)?, None, CellSet::EMPTY)?;
            if let Some(reading) = readings.iter_mut().find(|reading| reading.maze == maze) {
                reading.encodings.push(encoding);
                continue;
            }
            let mut notes = self.notes.clone();
            let high = numbers().find(|(number, _)| *number > 15 && encoding.bits != Bits::Codes);
            let ignored = |&(_, at)| Note::new(NoteKind::Ignored, at, "ignored the high bits");
            notes.extend(high.map(ignored));
            let encodings = vec![encoding; usize::from(own != Some(encoding))];
            readings.push(ParsedMaze { maze, notation: Notation::Numbers, encodings, notes });
        }
        if readings.len() > 1 {
            let found =
                format!("numbers that fit {} mazes (use --bits and --rows)", readings.len());
            let error = ParseError::new(at, "numbers that fit one maze", found);
            return Err(ParseError { kind: ParseErrorKind::Ambiguous, readings, ..error }.into());
        }
        if let Some(reading) = readings.pop() {
            return Ok(reading);
        }
        let count = |encoding: &Encoding| faults(encoding).count();
        let nearest = own.or_else(|| encodings.iter().copied().min_by_key(count));
        let is_known = own.is_some() || encodings.len() == 1;
        let is_near = |it: &Encoding| is_known || 4 * count(it) <= items * lines + 8;
        let errors = nearest.filter(is_near).and_then(|nearest| decode(nearest).err());
        Err(errors.unwrap_or_else(|| {
            let error = ParseError::new(at, "numbers for walls", "other numbers");
            ParseError { kind: ParseErrorKind::NotAMaze, ..error }.into()
        }))
    }
}

/// The walls of a start: open only to the north.
const START: Sides = Sides::from_bits(0b1110);

/// Splits off the lines below the numbers in files of the exercise A-maze-ing: x and y of the entry,
/// x and y of the exit, both from the north-west, and perhaps a path of the letters N, E, S and W.
fn split_off_route<'a>(rows: &mut Vec<Row<'a>>) -> Option<Vec<Row<'a>>> {
    let is_letter = |c| Heading::from_letter(c).is_some();
    let is_path = |row: &Row| matches!(row.items[..], [item] if item.text.chars().all(is_letter));
    let is_cell = |row: &Row| row.is_separated && row.items.len() == 2;
    let count = rows.len() - usize::from(rows.last().is_some_and(is_path));
    let [.., last, entry, exit] = &rows[..count] else { return None };
    let is_below = entry.items[0].line > last.items[0].line + 1;
    (is_below && is_cell(entry) && is_cell(exit)).then(|| rows.split_off(count - 2))
}

/// Adds the start and the goal of a route to a maze, and checks the path.
fn add_route(route: &[Row], parsed: ParsedMaze) -> Result<ParsedMaze, Vec<ParseError>> {
    let ParsedMaze { maze, mut notes, .. } = parsed;
    let (size, walls) = (maze.size(), maze.walls());
    let cell = |row: &Row| {
        let [x, y] = [0, 1].map(|at| row.items[at].number(false).unwrap_or(u8::MAX));
        let error = || row.items[0].error(format!("x and y of a cell of the {size} maze"));
        let is_inside = size.contains(Cell { x, y });
        is_inside.then(|| Cell { x, y: size.height() - 1 - y }).ok_or_else(error)
    };
    let (start, goal) = (cell(&route[0])?, cell(&route[1])?);
    if let Some(path) = route.get(2).map(|row| row.items[0]) {
        let follow = |here: Cell, step: Item| {
            let heading = step.text.chars().next().and_then(Heading::from_letter);
            let open = heading.filter(|&heading| !walls.has(here, heading));
            let next = open.and_then(|heading| here.neighbour(heading));
            next.ok_or_else(|| (step.location(), format!("the path crosses a wall of {here}")))
        };
        let end = path.characters().into_iter().try_fold(start, follow);
        let elsewhere = |end| (path.end(), format!("the path ends in {end}, not in {goal}"));
        let wrong = end.map_or_else(Some, |end| (end != goal).then(|| elsewhere(end)));
        notes.extend(wrong.map(|(at, text)| Note::new(NoteKind::Path, at, text)));
    }
    let maze = parsed_maze::maze(walls.clone(), Some(start), [goal].into_iter().collect())?;
    Ok(ParsedMaze { maze, notes, ..parsed })
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Maze;

    use super::*;
    use crate::read::{Choice, parse_maze};

    /// Rows from the north; bits 1, 2, 4 and 8 are walls to the north, east, south and west.
    const MAZE: &str = "9553\na93a\naaaa\nec46\n";

    fn parse(text: &str) -> Result<Maze, ParseError> {
        parse_maze(text.as_bytes())
    }

    #[test]
    fn numbers_are_read_in_any_notation() {
        let maze = parse(MAZE).unwrap();
        insta::assert_snapshot!(maze, @"
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
        let written = |number: fn(u32) -> String, between: &str, rows: [&str; 3]| {
            let row = |line: &str| {
                let numbers = line.chars().map(|digit| number(digit.to_digit(16).unwrap()));
                numbers.collect::<Vec<_>>().join(between)
            };
            let [before, middle, after] = rows;
            before.to_string() + &MAZE.lines().map(row).collect::<Vec<_>>().join(middle) + after
        };
        let decimal: fn(u32) -> String = |number| number.to_string();
        let hex: fn(u32) -> String = |number| format!("0x{number:02X}");
        let lines = ["", "\n", "\n"];
        for text in [
            MAZE.to_uppercase(),
            MAZE.replace('\n', "\r\n\r\n"),
            format!("A maze of digits\n{MAZE}\nofficial: 4 goals\n"),
            format!("4 4\n{MAZE}"),
            format!("0x{}", MAZE.trim_end().replace('\n', "\n0x")),
            written(|number| format!("{number:x}"), " ", lines),
            written(|number| format!("{number:02x}"), " ", lines),
            written(decimal, ",", lines),
            written(decimal, ", ", lines),
            written(decimal, ";", lines),
            written(decimal, "\t", lines),
            written(decimal, ",", ["", ",\n", ",\n"]),
            written(|number| format!("{number}.0"), ",", lines),
            written(|number| format!("{:.18e}", f64::from(number)), " ", lines),
            written(hex, ", ", ["", "\n", ""]),
            written(hex, ", ", ["const unsigned char maze[4][4] = {\n  {", "},\n  {", "}\n};\n"]),
            written(
                hex,
                ", ",
                [
                    "#include <stdint.h>\n/* a {maze} */\nuint8_t m[16] PROGMEM = {\n",
                    ",\n",
                    "};\nint other[2] = {1, 2};\n",
                ],
            ),
            written(decimal, ", ", ["maze = [[", "], # a row\n[", "]]\n"]),
            written(decimal, ",", ["{\"maze\": [[", "],[", "]]}"]),
            written(decimal, ", ", ["int maze[] = {", ", ", "};"]),
            "\"9553\",\n\"a93a\",\n\"aaaa\",\n\"ec46\"\n".into(),
        ] {
            assert_eq!(parse(&text).as_ref(), Ok(&maze), "{text}");
        }
        let high = Choice::default()
            .read(written(|number| format!("0x{:x}", number + 0xf0), ",", lines).as_bytes())
            .unwrap();
        assert_eq!(high.maze, maze);
        insta::assert_snapshot!(high.notes[0], @"line 1, column 1: ignored the high bits");
    }

    #[test]
    fn errors_name_the_nearest_encoding() {
        let error =
            |from: &str, to: &str| parse(&MAZE.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("a93a", "a92a"), @"line 1, column 3: expected no wall between (2, 2) and (2, 3) to match line 2, column 3, found 5 (nearest encoding: --bits N1E2S4W8 --rows north)");
        insta::assert_snapshot!(error("9553", "1553"), @"line 1, column 1: expected an outer wall to the west of (0, 3), found 1 (nearest encoding: --bits N1E2S4W8 --rows north)");
        insta::assert_snapshot!(error("ec46", "cc46"), @"line 4, column 2: expected no wall between (0, 0) and (1, 0) to match line 4, column 1, found 12 (nearest encoding: --bits N1E2S4W8 --rows north)");
        insta::assert_snapshot!(error("a93a", "a93"), @"line 2, column 4: expected 4 numbers, as on line 1, found 3");
        insta::assert_snapshot!(error("a93a", "a93g"), @r#"line 2, column 4: expected a hex digit, found "g""#);
        let chosen = Choice { bits: Some(Bits::WALLS), rows: "south".parse().ok() };
        assert_ne!(chosen.read(b"9113\nec46\n").unwrap_err()[0].kind, ParseErrorKind::NotAMaze);
        let wide = "5".repeat(33) + "\n";
        insta::assert_snapshot!(parse(&wide.repeat(3)).unwrap_err(), @"line 1, column 1: expected at most 32x32 cells, found 33x3");
        insta::assert_snapshot!(parse(&"55\n".repeat(33)).unwrap_err(), @"line 1, column 1: expected at most 32x32 cells, found 2x33");
    }

    const TRIAL: &str = "4\n1,7,5,4\n2,10,3,6\n11,13,14,8\n9,5,13,4\n";

    #[test]
    fn a_trial_is_recognized_by_its_side() {
        insta::assert_snapshot!(parse(TRIAL).unwrap(), @"
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
        assert_eq!(parse(&TRIAL.replace(',', " , ")), parse(TRIAL));
        let error =
            |from: &str, to: &str| parse(&TRIAL.replacen(from, to, 1)).unwrap_err().to_string();
        insta::assert_snapshot!(error("2,10", "2,8"), @"line 4, column 4: expected a wall between (1, 1) and (2, 1) to match line 3, column 3, found 13");
        insta::assert_snapshot!(error("1,7", "5,7"), @"line 2, column 1: expected an outer wall to the south of (0, 0), found 5");
        insta::assert_snapshot!(error("10", "-1"), @r#"line 3, column 3: expected a whole number from 0 to 16, found "-1""#);
        insta::assert_snapshot!(error("2,10,3,6", "2,10,3"), @r#"line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found "4""#);
        insta::assert_snapshot!(error("9,5,13,4\n", ""), @r#"line 1, column 1: expected 3 lines of numbers below, found "4""#);
        insta::assert_snapshot!(error("9,5,13,4\n", "9,5,13,4\n1,2,3,4\n"), @r#"line 1, column 1: expected 5 lines of numbers below, found "4""#);
    }

    #[test]
    fn codes_name_walls() {
        let maze = parse("8,2,7\n9,9,9\n11,5,6\n").unwrap();
        insta::assert_snapshot!(maze, @"
        o---o---o---o
        |           |
        o   o   o   o
        |   | G |   |
        o   o   o   o
        | S |       |
        o---o---o---o
        ");
        let choice = Choice { bits: "codes".parse().ok(), ..Choice::default() };
        let errors = choice.read(b"8,2,7\n9,15,9\n11,5,6\n").unwrap_err();
        insta::assert_snapshot!(errors[0], @"line 2, column 3: expected a wall between (0, 1) and (1, 1) to match line 2, column 1, found 15 (nearest encoding: --bits codes --rows north)");
    }

    const A_MAZE_ING: &str = "93\nC6\n\n0,0\n1,1\nES\n";

    #[test]
    fn a_maze_ing_has_a_route() {
        let parsed = Choice::default().read(A_MAZE_ING.as_bytes()).unwrap();
        insta::assert_snapshot!(parsed.maze, @"
        o---o---o
        | S     |
        o   o   o
        |     G |
        o---o---o
        ");
        assert_eq!(parsed.notes, []);
        let note = |from: &str, to: &str| {
            let text = A_MAZE_ING.replacen(from, to, 1);
            let parsed = Choice::default().read(text.as_bytes()).unwrap();
            parsed.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
        };
        insta::assert_snapshot!(note("ES", "EE"), @"line 6, column 2: the path crosses a wall of (1, 1)");
        insta::assert_snapshot!(note("ES", "E"), @"line 6, column 2: the path ends in (1, 1), not in (1, 0)");
        insta::assert_snapshot!(note("ES\n", ""), @"");
        insta::assert_snapshot!(parse(&A_MAZE_ING.replace("1,1", "1,2")).unwrap_err(), @r#"line 5, column 1: expected x and y of a cell of the 2x2 maze, found "1""#);
        insta::assert_snapshot!(parse(&A_MAZE_ING.replace("93", "13")).unwrap_err(), @"line 1, column 1: expected an outer wall to the west of (0, 1), found 1");
    }

    #[test]
    fn bytes_are_columns() {
        let maze: Maze = mmsim_mazes::HARBOUR.parse().unwrap();
        let bytes = crate::Format::Maz.write(&maze).unwrap();
        let parsed = |bytes: &[u8]| Choice::default().read(bytes);
        assert_eq!(parsed(&bytes).unwrap().maze, maze);
        let visited: Vec<u8> = bytes.iter().map(|byte| byte | 0x40).collect();
        let visited = parsed(&visited).unwrap();
        assert_eq!(visited.maze, maze);
        insta::assert_snapshot!(visited.notes[0], @"byte 1: ignored the high bits");
        let mut wrong = bytes.clone();
        wrong[16] ^= 4;
        insta::assert_snapshot!(parsed(&wrong).unwrap_err()[0], @"byte 17: expected an outer wall to the south of (1, 0), found 8");
        insta::assert_snapshot!(parsed(&bytes[..255]).unwrap_err()[0], @"byte 256: expected 256 or 1024 bytes, one for each cell of a 16x16 or 32x32 maze, found 255");
    }

    /// Another cell is open only to one side, too, so that the maze may also be reflected.
    #[test]
    fn ambiguous_numbers_have_all_readings() {
        let error = parse("b93\neee\n").unwrap_err();
        assert_eq!(error.kind, ParseErrorKind::Ambiguous);
        insta::assert_snapshot!(error, @"line 1, column 1: expected numbers that fit one maze, found numbers that fit 3 mazes (use --bits and --rows)");
        for reading in &error.readings {
            for &Encoding { bits, rows } in &reading.encodings {
                let choice = Choice { bits: Some(bits), rows: Some(rows) };
                assert_eq!(choice.read(b"b93\neee\n").unwrap().maze, reading.maze);
            }
        }
    }
}
