//! `mmsim mazes convert`: write a maze in another format.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::TypedValueParser;
use mmsim_formats::{Format, ReadError, WriteError, read_content, read_content_from};
use mmsim_maze::{Cell, CellSet, Maze, counted};

use super::check::ambiguity;
use crate::args::{CommandResult, UsageError, one_of};
use crate::output::{is_standard, note, replace_or_print, warn};

#[derive(Debug, Args)]
pub(super) struct ConvertArgs {
    /// Maze file; - for stdin
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write; - for stdout. The extension .txt, .trial, .maz or .num selects the format,
    /// unless --to is set. Existing files are replaced
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format of IN [default: detected from its content]
    #[arg(long, value_parser = format(|_| true))]
    format: Option<Format>,
    /// Format of OUT [default: selected by its extension; for stdout, the text format]
    #[arg(long, value_parser = format(Format::is_writable))]
    to: Option<Format>,
    /// Omit a start or goal that the format cannot store
    #[arg(long)]
    lossy: bool,
}

/// Returns a parser for the names of all formats that satisfy `accepts`.
pub(super) fn format(accepts: fn(Format) -> bool) -> impl TypedValueParser<Value = Format> {
    let formats = Format::ALL.into_iter().filter(move |&format| accepts(format));
    one_of(formats, |format| format.name().into())
}

pub(super) fn run(args: &ConvertArgs) -> CommandResult {
    let for_stdout = is_standard(&args.output).then_some(Format::Text);
    let to = args.to.or(for_stdout).or_else(|| Format::from_path(&args.output));
    let to = to.ok_or_else(|| {
        let output = args.output.display();
        let hint = "use .txt, .trial, .maz or .num, or --to FORMAT";
        UsageError::new("mazes convert", format!("unknown format of {output} ({hint})"))
    })?;
    let maze = read(&args.input, args.format)?;
    let content = match to.write(&maze) {
        Err(WriteError::Start { .. } | WriteError::Goal { .. }) if args.lossy => {
            let bare = Maze::new(maze.walls().clone(), Cell::new(0, 0), CellSet::EMPTY)?;
            note(format_args!("omitted: {}", omitted(&maze, &bare)));
            to.write(&bare)
        }
        written => written,
    };
    let content = content.map_err(|error| {
        let is_mark = matches!(error, WriteError::Start { .. } | WriteError::Goal { .. });
        let hint = if is_mark { " (use --lossy to omit it)" } else { "" };
        format!("cannot write {}: {error}{hint}", args.output.display())
    })?;
    replace_or_print(&args.output, &content)?;
    Ok(true)
}

fn read(path: &Path, format: Option<Format>) -> Result<Maze, Box<dyn std::error::Error>> {
    let is_stdin = is_standard(path);
    let path = if is_stdin { Path::new("stdin") } else { path };
    let content = if is_stdin {
        read_content_from(io::stdin().lock(), path)?
    } else if path.is_dir() {
        return Err(format!("{} is a folder, not a maze file", path.display()).into());
    } else {
        read_content(path)?
    };
    let reading = format.unwrap_or_else(|| Format::detect(&content)).read(&content);
    let reading = reading.map_err(|errors| match errors.into_iter().next() {
        Some(source) => ReadError::Parse { path: path.into(), source }.to_string(),
        None => format!("{}: no maze", path.display()),
    })?;
    if let Some(way) = &reading.ambiguous_encoding {
        warn(format_args!("{}: {}", path.display(), ambiguity(way)));
    }
    if !reading.unknown_walls.is_empty() {
        let walls = counted(reading.unknown_walls.len(), "unknown wall");
        warn(format_args!("{}: {walls} assumed open", path.display()));
    }
    Ok(reading.maze)
}

/// Describes the start and goal of `maze` that would be lost if `bare` were written instead. `bare`
/// has the default start and goal.
fn omitted(maze: &Maze, bare: &Maze) -> String {
    let mut marks = Vec::new();
    if maze.start() != bare.start() {
        let (found, assumed) = (maze.start().cell, bare.start().cell);
        marks.push(format!("start {found}, which will be read as {assumed}"));
    }
    if maze.goals() != bare.goals() {
        let list = |goals: &CellSet| {
            goals.iter().map(|cell| cell.to_string()).collect::<Vec<_>>().join(" ")
        };
        let (found, assumed) = (list(maze.goals()), list(bare.goals()));
        marks.push(format!("goal {found}, which will be read as {assumed}"));
    }
    marks.join("; ")
}
