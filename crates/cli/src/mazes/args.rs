//! Arguments of `mmsim mazes`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Args, Subcommand};
use mmsim_formats::Format;
use mmsim_generator::Style;
use mmsim_maze::MazeSize;

use crate::args::{one_of, parse_size};

#[derive(Debug, Args)]
pub(crate) struct MazesArgs {
    #[command(subcommand)]
    pub(crate) command: MazesCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MazesCommand {
    /// List mazes
    List {
        /// Maze file, or folder to search recursively [default: ~/.mmsim if it has mazes, else the
        /// bundled mazes]
        mazes: Option<PathBuf>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Draw a maze, with the number of steps from each cell to the goal
    Show {
        /// Maze file, or words from the path of a maze
        #[arg(required = true)]
        name: Vec<String>,
        /// File or folder to search for the maze [default: ~/.mmsim if it has mazes, else the
        /// bundled mazes]
        #[arg(long, value_name = "PATH")]
        mazes: Option<PathBuf>,
        /// Format of the maze file NAME [default: detected from its content]
        #[arg(long, value_parser = format(|_| true), conflicts_with = "mazes")]
        format: Option<Format>,
        /// Print a JSON object
        #[arg(long)]
        json: bool,
    },
    /// Check maze files for errors, and print their size, goals and shortest path
    ///
    /// The exit code is 1 if there are errors: unreadable files, contradictory cells, gaps in the
    /// outer wall, or an unreachable goal. Warnings are printed for posts without a wall,
    /// unreachable cells, unknown walls, ambiguous hex digits, and duplicate mazes.
    Check {
        /// Maze files, or folders to search recursively; hidden, .md and .json files in folders are
        /// skipped
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        /// Format of all files [default: detected from their content]
        #[arg(long, value_parser = format(|_| true))]
        format: Option<Format>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Write a maze file in another format
    Convert(ConvertArgs),
    /// Download a public collection of real contest mazes
    #[command(long_about = FETCH)]
    Fetch(FetchArgs),
    /// Generate mazes for contests or training; the same seed gives the same maze
    Generate(GenerateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Maze file; - for stdin
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// File to write; - for stdout. The extension .txt, .trial, .maz or .num selects the format,
    /// unless --to is set. Existing files are replaced
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of IN [default: detected from its content]
    #[arg(long, value_parser = format(|_| true))]
    pub(crate) format: Option<Format>,
    /// Format of OUT [default: selected by its extension; for stdout, the text format]
    #[arg(long, value_parser = format(Format::is_writable))]
    pub(crate) to: Option<Format>,
    /// Omit a start or goal that the format cannot store
    #[arg(long)]
    pub(crate) lossy: bool,
}

const FETCH: &str = "\
Download a public collection of real contest mazes, the maze files of micromouseonline, and write \
the bundled mazes next to them: text files, and mazes of the two-run trial in its own format.

The collection has no licence: the mazes belong to their authors, and you download them for your \
own use.

The mazes are stored in the subfolder `fetched`. Fetching again replaces mazes that have changed in \
the collection, removes mazes that were deleted from it, and keeps files that you have added or \
changed. Nothing outside the subfolder is touched. The environment variables HTTPS_PROXY, HTTP_PROXY \
and NO_PROXY apply.";

#[derive(Debug, Args)]
pub(crate) struct FetchArgs {
    /// Folder for the mazes [default: ~/.mmsim, where mmsim looks for mazes first]
    #[arg(value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
    /// Archive to fetch instead (.tar.gz, .zip or .tar): an https, http or file URL, or a local
    /// file; `bundled` writes only the bundled mazes, without a download
    #[arg(long, value_name = "URL|FILE|bundled")]
    pub(crate) from: Option<String>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Width and height in cells
    #[arg(long, value_name = "WxH", default_value_t = MazeSize::CLASSIC, value_parser = parse_size)]
    pub(crate) size: MazeSize,
    /// Random seed [default: random, printed]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Style of the maze
    #[arg(long, default_value = Style::Contest.name(), value_parser = styles())]
    pub(crate) style: Style,
    /// Number of mazes; each maze after the first uses the next seed
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) count: u32,
    /// File to write. The extension .trial, .maz or .num selects the format; all other files are
    /// text. The path is treated as a folder for files such as contest-16x16-1.txt if it ends in a
    /// separator or is an existing folder, or if --count is above 1 [default: print the mazes,
    /// separated by blank lines]
    #[arg(short, long, value_name = "FILE|DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite existing files whose content differs
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
    /// Print a JSON array
    #[arg(long, conflicts_with = "output")]
    pub(crate) json: bool,
}

fn styles() -> impl TypedValueParser<Value = Style> {
    one_of(Style::ALL.iter().copied(), |style| PossibleValue::new(style.name()).help(style.about()))
}

/// Returns a parser for the names of all formats that satisfy `accepts`.
fn format(accepts: fn(Format) -> bool) -> impl TypedValueParser<Value = Format> {
    let formats = Format::ALL.into_iter().filter(move |&format| accepts(format));
    one_of(formats, |format| format.name().into())
}
