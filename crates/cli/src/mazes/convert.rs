//! `mmsim mazes convert`: the same maze in another format.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use mmsim_formats::{Format, ReadError, WriteError, read_content, read_content_from};
use mmsim_maze::{Cell, CellSet, Maze};

use super::args::ConvertArgs;
use super::finding::ambiguity;
use crate::Outcome;
use crate::args::wrong_usage;
use crate::output::{complain, counted, replace, say};

/// What stands for the standard input or output.
const STANDARD: &str = "-";

pub(super) fn run(args: &ConvertArgs) -> Outcome {
    let to = args.to.or_else(|| format_by_ending(&args.output)).unwrap_or_else(|| {
        let expected = "a file that ends in .txt, .trial, .maz or .num, or --to FORMAT";
        let found = args.output.display();
        wrong_usage("mazes", &format!("expected {expected}, found {found}"))
    });
    let maze = read(&args.input, args.format)?;
    let content = match to.write(&maze) {
        Err(WriteError::Start { .. } | WriteError::Goal { .. }) if args.lossy => {
            let bare = Maze::new(maze.walls().clone(), Cell::new(0, 0), CellSet::EMPTY)?;
            say(format_args!("left out: {}", left_out(&maze, &bare)));
            to.write(&bare)
        }
        written => written,
    };
    let content = content.map_err(|error| {
        let is_mark = matches!(error, WriteError::Start { .. } | WriteError::Goal { .. });
        let hint = if is_mark { "; --lossy leaves it out" } else { "" };
        format!("{}: not written: {error}{hint}", args.output.display())
    })?;
    if args.output == Path::new(STANDARD) {
        let mut out = io::stdout().lock();
        match out.write_all(&content).and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => return Err(error.into()),
            _ => {}
        }
    } else {
        replace(&args.output, &content)?;
    }
    Ok(true)
}

/// The format that the ending of a file stands for, if one does.
pub(super) fn format_by_ending(path: &Path) -> Option<Format> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match &ending[..] {
        "" if path == Path::new(STANDARD) => Some(Format::Text),
        "txt" => Some(Format::Text),
        "trial" => Some(Format::Trial),
        "maz" => Some(Format::Maz),
        "num" => Some(Format::Num),
        _ => None,
    }
}

fn read(path: &Path, format: Option<Format>) -> Result<Maze, Box<dyn std::error::Error>> {
    let is_standard = path == Path::new(STANDARD);
    let path = if is_standard { Path::new("standard input") } else { path };
    let content = if is_standard {
        read_content_from(io::stdin().lock(), path)?
    } else if path.is_dir() {
        return Err(format!("{}: expected a maze file, found a folder", path.display()).into());
    } else {
        read_content(path)?
    };
    let reading = format.unwrap_or_else(|| Format::detect(&content)).read(&content);
    let reading = reading.map_err(|errors| match errors.into_iter().next() {
        Some(source) => ReadError::Parse { path: path.into(), source }.to_string(),
        None => format!("{}: expected a maze, found none", path.display()),
    })?;
    if let Some(way) = &reading.ambiguous_encoding {
        complain(format_args!("{}: {}", path.display(), ambiguity(way)));
    }
    match reading.unknown_walls.len() {
        0 => {}
        count => complain(format_args!(
            "{}: {} taken as open",
            path.display(),
            counted(count as u64, "unknown wall")
        )),
    }
    Ok(reading.maze)
}

/// What the bare maze lacks.
fn left_out(maze: &Maze, bare: &Maze) -> String {
    let mut lacking = Vec::new();
    if maze.start() != bare.start() {
        let (found, assumed) = (maze.start().cell, bare.start().cell);
        lacking.push(format!("the start {found}, which reads back as {assumed}"));
    }
    if maze.goals() != bare.goals() {
        let list = |goals: &CellSet| {
            goals.iter().map(|cell| cell.to_string()).collect::<Vec<_>>().join(" ")
        };
        let (found, assumed) = (list(maze.goals()), list(bare.goals()));
        lacking.push(format!("the goal {found}, which reads back as {assumed}"));
    }
    lacking.join("; ")
}
