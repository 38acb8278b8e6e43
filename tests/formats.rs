//! Checks that mazes are unchanged after conversion to each format and back, and that the examples
//! in docs/formats.md are valid.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mmsim_formats::{Catalogue, Format, parse_maze};
use mmsim_maze::{Cell, Heading, Maze};
use mmsim_tests::shared;

/// Returns the text-format mazes of a collection, with their paths.
fn text_mazes(catalogue: &Catalogue) -> Vec<(String, Maze)> {
    let entries = catalogue.entries().iter();
    let texts = entries.filter(|entry| Format::detect(&entry.content().unwrap()) == Format::Text);
    texts.map(|entry| (entry.path().display().to_string(), entry.maze().unwrap())).collect()
}

/// Converts each maze to every format that can hold it, and checks that parsing the result gives
/// the same maze. Returns the number of mazes per format.
fn round_trips(mazes: &[(String, Maze)]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for (path, maze) in mazes {
        for format in Format::ALL {
            let Ok(content) = format.write(maze) else { continue };
            assert_eq!(Format::detect(&content), format, "{path} as {format}");
            let back = parse_maze(&content).unwrap();
            assert_eq!(back.to_string(), maze.to_string(), "{path} as {format}");
            assert_eq!(&back, maze, "{path} as {format}");
            *counts.entry(format.name()).or_default() += 1;
        }
    }
    counts
}

#[test]
fn bundled_mazes_are_unchanged_in_every_format_that_can_hold_them() {
    let mazes = text_mazes(&Catalogue::bundled());
    let expected = [("maz", 12), ("num", 13), ("text", 15), ("trial", 13)];
    assert_eq!(round_trips(&mazes), BTreeMap::from(expected));
}

#[test]
fn real_mazes_are_unchanged_in_every_format_that_can_hold_them() {
    let Some(folder) = shared("mazes") else { return };
    let mazes = text_mazes(&Catalogue::from_path(&folder).unwrap());
    let expected = [("maz", 266), ("num", 266), ("text", 281), ("trial", 266)];
    assert_eq!(round_trips(&mazes), BTreeMap::from(expected));
}

#[test]
fn real_mazes_parse_from_csv() {
    let Some(folder) = shared("mazes/classic") else { return };
    for (path, maze) in text_mazes(&Catalogue::from_path(&folder).unwrap()) {
        let csv = csv(&maze);
        assert_eq!(Format::detect(csv.as_bytes()), Format::Csv, "{path}");
        assert_eq!(parse_maze(csv.as_bytes()).as_ref(), Ok(&maze), "{path}");
    }
}

/// Formats each maze as hex rows in all bit orders and parses the rows. If the bits are in the
/// order north, east, south, west or in the order east, north, west, south, parsing must give the
/// original maze. In any other bit order, parsing must give an error or a different maze.
#[test]
fn real_mazes_parse_from_hex_rows() {
    const USUAL: [[usize; 4]; 2] = [[0, 1, 2, 3], [1, 0, 3, 2]];
    let Some(folder) = shared("mazes/classic") else { return };
    let mazes = text_mazes(&Catalogue::from_path(&folder).unwrap());
    // The layouts are: rows from the north; columns from the west, which begin in the south; and
    // columns from the east, which begin in the north.
    let layouts: [fn(u8, u8, u8) -> Cell; 3] = [
        |last, line, digit| Cell::new(digit, last - line),
        |_, line, digit| Cell::new(line, digit),
        |last, line, digit| Cell::new(last - line, last - digit),
    ];
    let read = |maze: &Maze, order, set_is_open, layout: usize| {
        let last = maze.size().width() - 1;
        let text = hex_rows(maze, order, set_is_open, |line, at| layouts[layout](last, line, at));
        assert_eq!(Format::detect(text.as_bytes()), Format::Hex);
        Format::Hex.read(text.as_bytes())
    };
    let (mut errors, mut others) = (0, 0);
    for (path, maze) in &mazes {
        for order in USUAL {
            for (layout, set_is_open) in (0..3).flat_map(|layout| [(layout, false), (layout, true)])
            {
                let parsed = read(maze, order, set_is_open, layout).unwrap();
                assert_eq!(&parsed.maze, maze, "{path}");
                assert_eq!(parsed.ambiguous_encoding, None, "{path}");
            }
        }
        for order in orders().filter(|order| !USUAL.contains(order)) {
            match read(maze, order, false, 0) {
                Ok(parsed) => others += usize::from(parsed.maze != *maze),
                Err(_) => errors += 1,
            }
        }
    }
    assert_eq!(
        (errors, others),
        (5204, 296),
        "(errors, different mazes) for 22 bit orders in 250 mazes"
    );
}

/// Returns all permutations of the headings, as indices into [`Heading::ALL`].
fn orders() -> impl Iterator<Item = [usize; 4]> {
    let all = (0..256).map(|number| [number & 3, number >> 2 & 3, number >> 4 & 3, number >> 6]);
    all.filter(|order| (0..4).all(|heading| order.contains(&heading)))
}

fn csv(maze: &Maze) -> String {
    const CODES: [u8; 16] = [15, 2, 3, 7, 4, 10, 6, 12, 1, 8, 9, 13, 5, 14, 11, 16];
    let rows = (0..maze.size().height()).rev().map(|y| {
        let code = |x| CODES[usize::from(bits(maze, Cell { x, y }))].to_string();
        (0..maze.size().width()).map(code).collect::<Vec<_>>().join(",")
    });
    rows.collect::<Vec<_>>().join("\n")
}

/// Formats a maze as lines of hex digits. `order` contains the headings that the bits 1, 2, 4 and 8
/// stand for. `cell` returns the cell for a line number and a position in the line.
fn hex_rows(
    maze: &Maze,
    order: [usize; 4],
    set_is_open: bool,
    cell: impl Fn(u8, u8) -> Cell,
) -> String {
    let side = maze.size().width();
    let digit = |line, at| {
        let walls = bits(maze, cell(line, at));
        let set = if set_is_open { !walls } else { walls };
        let value = (0..).zip(order).map(|(bit, heading)| u32::from(set >> heading & 1) << bit);
        char::from_digit(value.sum(), 16).unwrap()
    };
    let digit = &digit;
    (0..side).flat_map(|line| (0..side).map(move |at| digit(line, at)).chain(['\n'])).collect()
}

/// Returns the walls of a cell as bits: 1 for north, 2 for east, 4 for south and 8 for west.
fn bits(maze: &Maze, cell: Cell) -> u8 {
    let sides = maze.walls().sides(cell);
    Heading::ALL.into_iter().map(|heading| u8::from(sides.has(heading)) << heading as u8).sum()
}

/// Checks that all examples in docs/formats.md parse to the same maze, and that the format of each
/// example is the one in its section heading.
#[test]
fn the_documented_examples_parse() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let page = fs::read_to_string(page).unwrap();
    let mut first = None;
    let mut formats = Vec::new();
    for section in page.split("\n## ").skip(1) {
        let heading = section.split([' ', ',', '\n']).next().unwrap();
        for example in section.split("```text\n").skip(1) {
            let example = example.split("```").next().unwrap();
            let maze =
                parse_maze(example.as_bytes()).unwrap_or_else(|error| panic!("{heading}: {error}"));
            let format = Format::detect(example.as_bytes());
            assert_eq!(format.name(), heading.to_lowercase(), "{example}");
            for line_end in ["\r\n", "\r"] {
                let ended = example.replace('\n', line_end);
                assert_eq!(Format::detect(ended.as_bytes()), format, "{ended:?}");
                assert_eq!(parse_maze(ended.as_bytes()).as_ref(), Ok(&maze), "{ended:?}");
            }
            assert_eq!(first.get_or_insert_with(|| maze.clone()), &maze, "{heading}");
            formats.push(format);
        }
    }
    let texts = Format::ALL.into_iter().filter(|&format| format != Format::Maz);
    assert!(
        texts.eq(formats.iter().copied()),
        "expected one example of each format but maz: {formats:?}"
    );
}
