//! Mazes go from format to format without a difference, and docs/formats.md shows what reads.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mmsim_maze::{Catalogue, Cell, Format, Heading, Maze};
use mmsim_tests::{bundled_mazes, shared};

/// The mazes of a folder, but for those in the format of the trial.
fn text_mazes(folder: &Path) -> Vec<(String, Maze)> {
    let catalogue = Catalogue::of_path(folder).unwrap();
    let entries = catalogue.entries().iter();
    let texts = entries.filter(|entry| Format::of(&entry.content().unwrap()) == Format::Text);
    texts.map(|entry| (entry.path().display().to_string(), entry.maze().unwrap())).collect()
}

/// Writes each maze in each format that can hold it, and back as text. Gives how many each format
/// held.
fn held(mazes: &[(String, Maze)]) -> BTreeMap<&'static str, usize> {
    let mut held = BTreeMap::new();
    for (path, maze) in mazes {
        for format in Format::ALL {
            let Ok(content) = format.write(maze) else { continue };
            assert_eq!(Format::of(&content), format, "{path} as {format}");
            let back = Maze::parse(&content).unwrap();
            assert_eq!(back.to_string(), maze.to_string(), "{path} as {format}");
            assert_eq!(&back, maze, "{path} as {format}");
            *held.entry(format.name()).or_default() += 1;
        }
    }
    held
}

#[test]
fn bundled_mazes_survive_every_format_that_can_hold_them() {
    let mazes = text_mazes(&bundled_mazes());
    let expected = [("maz", 12), ("num", 13), ("text", 15), ("trial", 13)];
    assert_eq!(held(&mazes), BTreeMap::from(expected));
}

#[test]
fn real_mazes_survive_every_format_that_can_hold_them() {
    let Some(folder) = shared("mazes") else { return };
    let mazes = text_mazes(&folder);
    let expected = [("maz", 266), ("num", 266), ("text", 281), ("trial", 266)];
    assert_eq!(held(&mazes), BTreeMap::from(expected));
}

#[test]
fn real_mazes_read_from_csv() {
    let Some(folder) = shared("mazes/classic") else { return };
    for (path, maze) in text_mazes(&folder) {
        let csv = csv(&maze);
        assert_eq!(Format::of(csv.as_bytes()), Format::Csv, "{path}");
        assert_eq!(csv.parse().as_ref(), Ok(&maze), "{path}");
    }
}

/// Nothing in hex rows says what they mean. With the usual orders of bits they read as what was
/// written; with others those do not in which another corner may be the start as well.
#[test]
fn real_mazes_read_from_hex_rows() {
    let Some(folder) = shared("mazes/classic") else { return };
    let mazes = text_mazes(&folder);
    let mut right = [0; 4];
    for (path, maze) in &mazes {
        for (right, text) in right.iter_mut().zip(hex_rows(maze)) {
            assert_eq!(Format::of(text.as_bytes()), Format::Hex, "{path}");
            *right += usize::from(&text.parse::<Maze>().unwrap() == maze);
        }
    }
    assert_eq!((mazes.len(), right), (250, [250, 250, 250, 151]));
}

fn csv(maze: &Maze) -> String {
    const CODES: [u8; 16] = [15, 2, 3, 7, 4, 10, 6, 12, 1, 8, 9, 13, 5, 14, 11, 16];
    let rows = (0..maze.size().height()).rev().map(|y| {
        let code = |x| CODES[usize::from(bits(maze, Cell { x, y }))].to_string();
        (0..maze.size().width()).map(code).collect::<Vec<_>>().join(",")
    });
    rows.collect::<Vec<_>>().join("\n")
}

/// Rows from the north with walls as bits N E S W; columns as in `.maz`; rows from the north with
/// openings as bits E N W S; and rows from the south, each from the east, with walls as bits W S E N.
fn hex_rows(maze: &Maze) -> [String; 4] {
    let last = maze.size().width() - 1;
    let rows = |digit_of: &dyn Fn(u8, u8) -> u8| -> String {
        let digit = |value| char::from_digit(u32::from(value), 16).unwrap();
        let row = |line| (0..=last).map(move |at| digit(digit_of(line, at))).chain(['\n']);
        (0..=last).flat_map(row).collect()
    };
    let open_counter_clockwise = |bits: u8| {
        let swapped = (bits & 1) << 1 | bits >> 1 & 1 | (bits & 4) << 1 | (bits & 8) >> 1;
        swapped ^ 15
    };
    [
        rows(&|line, at| bits(maze, Cell::new(at, last - line))),
        rows(&|line, at| bits(maze, Cell::new(line, at))),
        rows(&|line, at| open_counter_clockwise(bits(maze, Cell::new(at, last - line)))),
        rows(&|line, at| bits(maze, Cell::new(last - at, line)).reverse_bits() >> 4),
    ]
}

/// Walls as bits: 1 north, 2 east, 4 south, 8 west.
fn bits(maze: &Maze, cell: Cell) -> u8 {
    let sides = maze.walls().sides(cell);
    Heading::ALL.into_iter().map(|heading| u8::from(sides.has(heading)) << heading as u8).sum()
}

/// Every example of the page reads as the maze that the page draws first, in the format under whose
/// heading it stands.
#[test]
fn the_examples_of_the_page_read() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats.md");
    let page = fs::read_to_string(page).unwrap();
    let mut drawn = None;
    let mut formats = Vec::new();
    for section in page.split("\n## ").skip(1) {
        let heading = section.split([' ', ',', '\n']).next().unwrap();
        for example in section.split("```text\n").skip(1) {
            let example = example.split("```").next().unwrap();
            let maze: Maze = example.parse().unwrap_or_else(|error| panic!("{heading}: {error}"));
            let format = Format::of(example.as_bytes());
            assert_eq!(format.name(), heading.to_lowercase(), "{example}");
            for line_end in ["\r\n", "\r"] {
                let ended = example.replace('\n', line_end);
                assert_eq!(Format::of(ended.as_bytes()), format, "{ended:?}");
                assert_eq!(ended.parse().as_ref(), Ok(&maze), "{ended:?}");
            }
            assert_eq!(drawn.get_or_insert_with(|| maze.clone()), &maze, "{heading}");
            formats.push(format);
        }
    }
    let texts = Format::ALL.into_iter().filter(|&format| format != Format::Maz);
    assert!(texts.eq(formats.iter().copied()), "an example of each but bytes: {formats:?}");
}
