//! Maze files, in whichever format they are.

use mmsim_formats::{Format, Location, ParseError};
use mmsim_maze::Maze;

/// Reads the content as that of a file, then the same below a title that makes it another format,
/// then in each format; and checks the maze or the error.
pub fn run(content: &[u8]) {
    read(content);
    read(&[b"OSHWDEM\n", content].concat());
    for format in Format::ALL {
        read_as(format, content);
    }
}

fn read(content: &[u8]) {
    let result = mmsim_formats::parse_maze(content);
    if let Ok(text) = str::from_utf8(content) {
        assert_eq!(result, text.parse(), "the same from bytes and from text");
    }
    assert_eq!(result, Format::detect(content).parse(content), "in the format that it is in");
    read_as(Format::detect(content), content);
}

fn read_as(format: Format, content: &[u8]) {
    match format.read(content) {
        Ok(reading) => {
            assert!(reading.unknown_walls.is_empty() || format == Format::Maze);
            check_maze(&reading.maze);
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            let text = String::from_utf8_lossy(content);
            for error in &errors {
                check_error(format, error, &text);
            }
        }
    }
}

/// What is drawn or written reads back.
fn check_maze(maze: &Maze) {
    let size = maze.size();
    assert!(size.contains(maze.start().cell));
    assert!(!maze.goals().is_empty());
    assert!(maze.goals().iter().all(|cell| size.contains(cell)));
    assert_eq!(maze.to_string().parse().as_ref(), Ok(maze));
    for format in Format::ALL {
        if let Ok(written) = format.write(maze) {
            assert_eq!(Format::detect(&written), format);
            assert_eq!(mmsim_formats::parse_maze(&written).as_ref(), Ok(maze), "{format}");
        }
    }
}

/// The error takes one line and its place lies in the file, or just past its end. A drawing is as
/// wide as its widest line, since missing trailing blanks are supplied.
fn check_error(format: Format, error: &ParseError, text: &str) {
    assert!(!error.to_string().contains(char::is_control), "in one line: {error:?}");
    let (line, column) = match error.place {
        Location::Text { line, column } => (line, column),
        Location::Byte(byte) => {
            assert_eq!(format, Format::Maz);
            assert!((1..=257).contains(&byte), "{error}");
            return;
        }
        _ => unreachable!("{error:?}"),
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let lines: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
    assert!((1..=lines.len() + 1).contains(&line), "{error} in {} lines", lines.len());
    let width = match format {
        Format::Text | Format::Maze | Format::Oshwdem => lines.iter().max(),
        _ => lines.get(line - 1),
    };
    let width = width.copied().unwrap_or(0);
    assert!((1..=width + 1).contains(&column), "{error} in {width} columns");
}
