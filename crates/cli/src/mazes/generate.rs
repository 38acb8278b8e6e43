//! `mmsim mazes generate`: generate mazes.

use std::fs;
use std::path::{self, Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_formats::Format;
use mmsim_generator::{Style, generate, random_seed};
use mmsim_maze::{Maze, MazeSize, counted};
use mmsim_solvers::MazeFacts;
use serde::{Serialize, Serializer};

use crate::args::{CommandResult, one_of, parse_size};
use crate::output::{create_folder, is_file, note, own_command, print, print_pretty_json, replace};

#[derive(Debug, Args)]
pub(super) struct GenerateArgs {
    /// Width and height in cells
    #[arg(long, value_name = "WxH", default_value_t = MazeSize::CLASSIC, value_parser = parse_size)]
    size: MazeSize,
    /// Random seed [default: random, printed]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Style of the maze
    #[arg(long, default_value = Style::Contest.name(), value_parser = styles())]
    style: Style,
    /// Number of mazes; each maze after the first uses the next seed
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// File to write. The extension .trial, .maz or .num selects the format; all other files are
    /// text. The path is treated as a folder for files such as contest-16x16-1.txt if it ends in a
    /// separator or is an existing folder, or if --count is above 1 [default: print the mazes,
    /// separated by blank lines]
    #[arg(short, long, value_name = "FILE|DIR", group = "files")]
    output: Option<PathBuf>,
    /// Overwrite existing files whose content differs
    #[arg(long, requires = "files")]
    force: bool,
    /// Print a JSON array
    #[arg(long, conflicts_with = "output")]
    json: bool,
}

fn styles() -> impl TypedValueParser<Value = Style> {
    one_of(Style::ALL.iter().copied(), |style| PossibleValue::new(style.name()).help(style.about()))
}

/// A generated maze, with its seed, style and properties. The field names are JSON keys.
#[derive(Serialize)]
struct Generated {
    seed: u64,
    style: &'static str,
    width: u8,
    height: u8,
    goals: Vec<[u8; 2]>,
    shortest_path: Option<u16>,
    #[serde(rename = "drawing", serialize_with = "as_text")]
    maze: Maze,
}

fn as_text<S: Serializer>(maze: &Maze, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(maze)
}

pub(super) fn run(args: &GenerateArgs) -> CommandResult {
    let seed = args.seed.unwrap_or_else(|| {
        let seed = random_seed();
        note(format_args!("seed {seed} (repeat with --seed {seed})"));
        seed
    });
    let mazes =
        (0..args.count).map(|number| Generated::new(args, seed.wrapping_add(number.into())));
    match &args.output {
        Some(output) => write(mazes, output, args)?,
        None if args.json => {
            let mazes: Vec<Generated> = mazes.collect();
            print_pretty_json(&mazes)?;
        }
        None => {
            for (number, generated) in mazes.enumerate() {
                let blank = if number == 0 { "" } else { "\n" };
                print(&format!("{blank}{}", generated.maze))?;
            }
        }
    }
    Ok(true)
}

impl Generated {
    fn new(args: &GenerateArgs, seed: u64) -> Self {
        let maze = generate(args.size, seed, args.style);
        Self {
            seed,
            style: args.style.name(),
            width: args.size.width(),
            height: args.size.height(),
            goals: maze.goals().iter().map(|cell| [cell.x, cell.y]).collect(),
            shortest_path: MazeFacts::new(&maze).shortest_path,
            maze,
        }
    }

    fn file_name(&self) -> String {
        let Self { seed, style, width, height, .. } = self;
        format!("{style}-{width}x{height}-{seed}.txt")
    }
}

/// Writes each maze to a file. Without `--force`, returns an error if one of the files already
/// exists with different content.
fn write(
    mazes: impl Iterator<Item = Generated>,
    output: &Path,
    args: &GenerateArgs,
) -> Result<(), String> {
    let asks_for_folder = output.to_string_lossy().ends_with(path::is_separator);
    let is_folder = args.count > 1 || asks_for_folder || output.is_dir();
    if is_folder {
        create_folder(output)?;
    }
    for generated in mazes {
        let path: PathBuf =
            if is_folder { output.join(generated.file_name()) } else { output.into() };
        let format = Format::from_path(&path).unwrap_or(Format::Text);
        let content = format
            .write(&generated.maze)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        // If the file is unreadable, writing it fails.
        match is_file(&path).then(|| fs::read(&path)) {
            Some(Ok(old)) if old == content => {}
            Some(Ok(_)) if !args.force => {
                let path = path.display();
                return Err(format!(
                    "{path} already exists with different content (use --force to replace it)"
                ));
            }
            _ => replace(&path, &content)?,
        }
    }
    let (mazes, place) = (counted(args.count, "maze"), output.display());
    let serve = own_command(&format!("{place}"));
    note(format_args!(
        "wrote {mazes} to {place}; serve {} with {serve}",
        if is_folder { "one" } else { "it" }
    ));
    Ok(())
}
