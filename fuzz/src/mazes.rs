//! The fuzz target for maze files.

use mmsim_formats::{Choice, Encoding, Format, Location, ParseError, ParseErrorKind, parse_maze};
use mmsim_maze::Maze;

/// Reads the content as a maze file, and again below a title line. Checks each resulting maze or
/// error.
pub fn run(content: &[u8]) {
    read(content);
    read(&[b"OSHWDEM\n", content].concat());
}

fn read(content: &[u8]) {
    let text = String::from_utf8_lossy(content);
    if let Ok(picture) = text.parse::<Maze>() {
        assert_eq!(parse_maze(content), Ok(picture), "the drawing of a maze is another maze");
    }
    match Choice::default().read(content) {
        Ok(parsed) => {
            check_encodings(content, &parsed.encodings, &parsed.maze);
            check_maze(&parsed.maze);
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            for error in &errors {
                check_error(error, &text);
                check_readings(error, content);
            }
        }
    }
}

/// Checks that each encoding alone gives the maze.
fn check_encodings(content: &[u8], encodings: &[Encoding], maze: &Maze) {
    for &Encoding { bits, rows } in encodings {
        let choice = Choice { bits: Some(bits), rows: Some(rows) };
        let parsed = choice.read(content).expect("the encoding fits the file");
        assert_eq!(parsed.maze, *maze, "--bits {bits} --rows {rows}");
    }
}

/// Checks that only an ambiguous file has readings, that the readings differ, and that their
/// encodings select them.
fn check_readings(error: &ParseError, content: &[u8]) {
    let is_ambiguous = error.kind == ParseErrorKind::Ambiguous;
    assert_eq!(is_ambiguous, error.readings.len() > 1, "{error}");
    assert_eq!(is_ambiguous, !error.readings.is_empty(), "{error}");
    for (index, reading) in error.readings.iter().enumerate() {
        assert!(error.readings[..index].iter().all(|other| other.maze != reading.maze));
        assert!(!reading.encodings.is_empty());
        check_encodings(content, &reading.encodings, &reading.maze);
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
            assert_eq!(parse_maze(&written).as_ref(), Ok(maze), "{format:?}");
        }
    }
}

/// Checks that the error message is a single line and that its location is inside the file or just
/// after the end. A drawing may lack trailing blanks, so any column up to the end of the longest line
/// is accepted.
fn check_error(error: &ParseError, text: &str) {
    assert!(!error.to_string().contains(char::is_control), "not a single line: {error:?}");
    let (line, column) = match error.location {
        Location::Text { line, column } => (line, column),
        Location::Byte(byte) => {
            assert!((1..=text.len() + 1).contains(&byte), "{error}");
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
    let width = lines.iter().max().copied().unwrap_or(0);
    assert!((1..=width + 1).contains(&column), "{error}, but no line has so many columns");
}
