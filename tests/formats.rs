//! Checks that mazes are unchanged after conversion to each format and back, and that the examples
//! in docs/formats.md are valid.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mmsim_formats::{Catalogue, Choice, Format, Notation, parse_maze};
use mmsim_maze::{Cell, Heading, Maze};
use mmsim_tests::shared;

/// Returns the mazes of a collection that are drawings, with their paths.
fn text_mazes(catalogue: &Catalogue) -> Vec<(String, Maze)> {
    let entries = catalogue.entries().iter();
    let parsed = entries.map(|entry| (entry, entry.parsed().unwrap()));
    let texts = parsed.filter(|(_, parsed)| parsed.notation == Notation::Drawing);
    texts.map(|(entry, parsed)| (entry.path().display().to_string(), parsed.maze.clone())).collect()
}

/// Converts each maze to every format that can hold it, and checks that parsing the result gives
/// the same maze. Returns the number of mazes per format.
fn round_trips(mazes: &[(String, Maze)]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for (path, maze) in mazes {
        for format in Format::ALL {
            let Ok(content) = format.write(maze) else { continue };
            let back = parse_maze(&content).unwrap();
            assert_eq!(back.to_string(), maze.to_string(), "{path} as {format:?}");
            assert_eq!(&back, maze, "{path} as {format:?}");
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
fn real_mazes_parse_from_codes() {
    let Some(folder) = shared("mazes/classic") else { return };
    for (path, maze) in text_mazes(&Catalogue::from_path(&folder).unwrap()) {
        assert_eq!(parse_maze(codes(&maze).as_bytes()).as_ref(), Ok(&maze), "{path}");
    }
}

fn codes(maze: &Maze) -> String {
    const CODES: [u8; 16] = [15, 2, 3, 7, 4, 10, 6, 12, 1, 8, 9, 13, 5, 14, 11, 16];
    let rows = (0..maze.size().height()).rev().map(|y| {
        let code = |x| CODES[usize::from(bits(maze, Cell { x, y }))].to_string();
        (0..maze.size().width()).map(code).collect::<Vec<_>>().join(",")
    });
    rows.collect::<Vec<_>>().join("\n")
}

/// An encoding of mazes as hex digits.
#[derive(Clone, Copy, Debug)]
struct Digits {
    /// The sides that the bits 1, 2, 4 and 8 stand for, as indices into [`Heading::ALL`].
    order: [usize; 4],
    set_is_open: bool,
    /// Whether lines are columns, and the lines and their digits are reversed.
    layout: [bool; 3],
}

impl Digits {
    /// Returns all encodings: 24 orders of the bits, for walls and openings, and 8 layouts.
    fn all() -> impl Iterator<Item = Self> {
        let orders =
            (0..256).map(|number| [number & 3, number >> 2 & 3, number >> 4 & 3, number >> 6]);
        let orders = orders.filter(|order| (0..4).all(|heading| order.contains(&heading)));
        orders.flat_map(|order| {
            (0..16).map(move |choice| {
                let [set_is_open, columns, lines, digits] =
                    [1, 2, 4, 8].map(|bit| choice & bit != 0);
                Self { order, set_is_open, layout: [columns, lines, digits] }
            })
        })
    }

    fn write(self, maze: &Maze) -> String {
        let (width, height) = (maze.size().width(), maze.size().height());
        let [are_columns, are_lines_reversed, are_digits_reversed] = self.layout;
        let (lines, digits) = if are_columns { (width, height) } else { (height, width) };
        let turned = |at, count: u8, is_reversed| if is_reversed { count - 1 - at } else { at };
        let mut text = String::new();
        for line in 0..lines {
            for digit in 0..digits {
                let line = turned(line, lines, are_lines_reversed);
                let digit = turned(digit, digits, are_digits_reversed);
                let (x, y) = if are_columns { (line, digit) } else { (digit, height - 1 - line) };
                let walls = bits(maze, Cell { x, y });
                let set = if self.set_is_open { !walls } else { walls };
                let value =
                    (0..).zip(self.order).map(|(bit, side)| u32::from(set >> side & 1) << bit);
                text.push(char::from_digit(value.sum(), 16).unwrap());
            }
            text.push('\n');
        }
        text
    }
}

/// A file of hex digits alone is read as the right maze or reported as ambiguous, with the right
/// maze among its readings. 107 of the 250 mazes have another corner that could be the start.
#[test]
fn hex_digits_are_right_or_ambiguous() {
    let Some(folder) = shared("mazes/classic") else { return };
    let mazes = text_mazes(&Catalogue::from_path(&folder).unwrap());
    let (mut right, mut ambiguous) = (0, 0);
    for (index, (path, maze)) in mazes.iter().enumerate() {
        // Each encoding is tried with every eighth maze.
        for (_, digits) in Digits::all().enumerate().filter(|(number, _)| (number + index) % 8 == 0)
        {
            match parse_maze(digits.write(maze).as_bytes()) {
                Ok(read) => {
                    assert_eq!(&read, maze, "{path}: {digits:?}");
                    right += 1;
                }
                Err(error) => {
                    assert!(
                        error.readings.iter().any(|reading| reading.maze == *maze),
                        "{path}: {digits:?}"
                    );
                    ambiguous += 1;
                }
            }
        }
    }
    assert_eq!((right, ambiguous), (6864, 5136));
}

/// The files of a folder share an encoding, so every file is right. Each seventh encoding is tried.
#[test]
fn hex_digits_in_a_folder_are_right() {
    let Some(folder) = shared("mazes/classic") else { return };
    let mazes = text_mazes(&Catalogue::from_path(&folder).unwrap());
    for digits in Digits::all().step_by(7) {
        let contents =
            mazes.iter().map(|(path, maze)| (path.into(), Ok(digits.write(maze).into())));
        let catalogue = Catalogue::from_contents(contents, Choice::default());
        let read: Vec<Maze> =
            catalogue.entries().iter().map(|entry| entry.maze().unwrap()).collect();
        assert!(read.iter().eq(mazes.iter().map(|(_, maze)| maze)), "{digits:?}");
    }
}

/// Returns the walls of a cell as bits: 1 for north, 2 for east, 4 for south and 8 for west.
fn bits(maze: &Maze, cell: Cell) -> u8 {
    let sides = maze.walls().sides(cell);
    Heading::ALL.into_iter().map(|heading| u8::from(sides.has(heading)) << heading as u8).sum()
}

/// Checks that all examples in docs/formats.md parse to the same maze.
#[test]
fn the_documented_examples_parse() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let page = fs::read_to_string(page).unwrap();
    let (page, _) = page.split_once("\n## Findings").unwrap();
    let mut first = None;
    let examples = page.split("```text\n").skip(1).map(|text| text.split("```").next().unwrap());
    let examples: Vec<&str> = examples.collect();
    for example in &examples {
        let maze =
            parse_maze(example.as_bytes()).unwrap_or_else(|error| panic!("{error}:\n{example}"));
        for line_end in ["\r\n", "\r"] {
            let ended = example.replace('\n', line_end);
            assert_eq!(parse_maze(ended.as_bytes()).as_ref(), Ok(&maze), "{ended:?}");
        }
        assert_eq!(first.get_or_insert_with(|| maze.clone()), &maze, "{example}");
    }
    let notations = examples.iter().map(|example| {
        let parsed = Choice::default().read(example.as_bytes()).unwrap();
        parsed.notation.name()
    });
    let notations: Vec<_> = notations.collect();
    assert_eq!(
        notations,
        [["drawing"; 4], ["numbers"; 4]].concat().into_iter().chain(["cells"]).collect::<Vec<_>>()
    );
}
