//! `mmsim mazes convert`: write a maze in another format.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_formats::{Format, NoteKind, ReadError, read_content_from};
use mmsim_maze::{Cell, CellSet, Maze, counted};

use super::EncodingArgs;
use super::diff::cells;
use crate::args::{CommandResult, UsageError, one_of};
use crate::output::{is_standard, note, replace_or_print, warn};
use crate::selection::Selection;

#[derive(Debug, Args)]
pub(super) struct ConvertArgs {
    /// Maze file, words from the path of a maze, or a folder and words in quotes; - for stdin
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write; - for stdout. The extension .txt, .trial, .maz or .num selects the format,
    /// unless --to is set. Existing files are replaced
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// Format of OUT [default: selected by its extension; for stdout, the text format]
    #[arg(long, value_parser = one_of(Format::ALL, |format| format.name().into()))]
    to: Option<Format>,
    /// Omit a start or goal that the format cannot store
    #[arg(long)]
    lossy: bool,
}

pub(super) fn run(args: &ConvertArgs) -> CommandResult {
    let for_stdout = is_standard(&args.output).then_some(Format::Text);
    let to = args.to.or(for_stdout).or_else(|| Format::from_path(&args.output));
    let to = to.ok_or_else(|| {
        let output = args.output.display();
        let hint = "use .txt, .trial, .maz or .num, or --to FORMAT";
        UsageError::new("mazes convert", format!("unknown format of {output} ({hint})"))
    })?;
    let maze = read(&args.input, &args.encoding)?;
    let bare = Maze::new(maze.walls().clone(), Cell::new(0, 0), CellSet::EMPTY)?;
    let content = match (to.write(&maze), to.write(&bare)) {
        (Err(_), Ok(content)) if args.lossy => {
            note(format_args!("omitted: {}", omitted(&maze, &bare)));
            content
        }
        (Err(error), other) => {
            let hint = if other.is_ok() { " (use --lossy to omit it)" } else { "" };
            return Err(format!("cannot write {}: {error}{hint}", args.output.display()).into());
        }
        (Ok(content), _) => content,
    };
    replace_or_print(&args.output, &content)?;
    Ok(true)
}

fn read(path: &Path, encoding: &EncodingArgs) -> Result<Maze, Box<dyn std::error::Error>> {
    if path.is_dir() {
        let folder = path.display();
        return Err(format!("{folder} is a folder, not a maze (add words of its path)").into());
    }
    let parsed = if is_standard(path) {
        let path = Path::new("stdin");
        let parsed = encoding.choice().read(&read_content_from(io::stdin().lock(), path)?);
        parsed.map_err(|errors| ReadError::Parse { path: path.into(), errors })?
    } else {
        let entry = Selection::encoded(path.as_os_str(), encoding.choice())?.first_entry()?;
        entry.parsed().map_err(ReadError::clone)?.clone()
    };
    let unknown = parsed.notes.iter().filter(|note| note.kind == NoteKind::UnknownWall).count();
    if unknown > 0 {
        let walls = counted(unknown, "unknown wall");
        warn(format_args!("{}: {walls} read as open", path.display()));
    }
    Ok(parsed.maze)
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
        let (found, assumed) = (cells(maze.goals()), cells(bare.goals()));
        marks.push(format!("goal {found}, which will be read as {assumed}"));
    }
    marks.join("; ")
}
