//! The fuzz target for maze files in all formats.

use mmsim_formats::{Format, Location, ParseError, parse_maze};
use mmsim_maze::Maze;

/// Reads the content as a maze file, first in the detected format and then in every format. Reads
/// it again after prepending the title line of the OSHWDEM format. Checks each resulting maze or
/// error.
pub fn run(content: &[u8]) {
    read(content);
    read(&[b"OSHWDEM\n", content].concat());
    for format in Format::ALL {
        read_as(format, content);
    }
}

fn read(content: &[u8]) {
    let detected = Format::detect(content);
    let result = parse_maze(content);
    assert_eq!(
        result,
        detected.parse(content),
        "parsing in the detected format gives a different result"
    );
    if let Ok(picture) = String::from_utf8_lossy(content).parse::<Maze>() {
        assert_eq!(result, Ok(picture), "parsing in the text format gives a different maze");
    }
    read_as(detected, content);
}

fn read_as(format: Format, content: &[u8]) {
    match format.read(content) {
        Ok(parsed) => {
            assert!(parsed.unknown_walls.is_empty() || format == Format::Maze);
            check_maze(&parsed.maze);
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

/// Converts the maze to text and to every format that can hold it. Checks that parsing the result
/// gives the same maze.
fn check_maze(maze: &Maze) {
    let size = maze.size();
    assert!(size.contains(maze.start().cell));
    assert!(!maze.goals().is_empty());
    assert!(maze.goals().iter().all(|cell| size.contains(cell)));
    assert_eq!(maze.to_string().parse().as_ref(), Ok(maze));
    for format in Format::ALL {
        if let Ok(written) = format.write(maze) {
            assert_eq!(Format::detect(&written), format);
            assert_eq!(parse_maze(&written).as_ref(), Ok(maze), "{format}");
        }
    }
}

/// Checks that the error message is a single line and that its location is inside the file or just
/// after the end. In formats that draw the maze, a line may lack trailing blanks, so any column up
/// to the end of the longest line is accepted.
fn check_error(format: Format, error: &ParseError, text: &str) {
    assert!(!error.to_string().contains(char::is_control), "not a single line: {error:?}");
    let (line, column) = match error.location {
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
    assert!(
        (1..=lines.len() + 1).contains(&line),
        "{error}, but the file has {} lines",
        lines.len()
    );
    let width = match format {
        Format::Text | Format::Maze | Format::Oshwdem => lines.iter().max(),
        _ => lines.get(line - 1),
    };
    let width = width.copied().unwrap_or(0);
    assert!((1..=width + 1).contains(&column), "{error}, but the line has {width} columns");
}
