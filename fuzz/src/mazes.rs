//! Maze files, in whichever format they are.

use mmsim_maze::{Format, Maze, ParseError};

/// Reads the content as that of a file, then the same below a title that makes it another format,
/// and checks the maze or the error.
pub fn run(content: &[u8]) {
    read(content);
    read(&[b"OSHWDEM\n", content].concat());
}

fn read(content: &[u8]) {
    let text = String::from_utf8_lossy(content);
    let result = Maze::parse(content);
    assert_eq!(result, text.parse(), "the same from bytes and from text");
    match result {
        Ok(maze) => check_maze(&maze),
        Err(error) => check_error(&error, &text),
    }
}

/// What is drawn reads back.
fn check_maze(maze: &Maze) {
    let size = maze.size();
    assert!(size.contains(maze.start().cell));
    assert!(!maze.goals().is_empty());
    assert!(maze.goals().iter().all(|cell| size.contains(cell)));
    assert_eq!(maze.to_string().parse().as_ref(), Ok(maze));
}

/// The error takes one line and its place lies in the text, or just past its end. A drawing is
/// as wide as its widest line, since missing trailing blanks are supplied.
fn check_error(error: &ParseError, text: &str) {
    assert!(!error.to_string().contains(char::is_control), "in one line: {error:?}");
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
    assert!((1..=lines.len() + 1).contains(&error.line), "{error} in {} lines", lines.len());
    let width = match Format::of(text) {
        Format::Trial => lines.get(error.line - 1),
        _ => lines.iter().max(),
    };
    let width = width.copied().unwrap_or(0);
    assert!((1..=width + 1).contains(&error.column), "{error} in {width} columns");
}
