//! The command line of `mmsim mazes`.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use mmsim_maze::Format;

#[derive(Debug, Args)]
pub(crate) struct MazesArgs {
    #[command(subcommand)]
    pub(crate) command: MazesCommand,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MazesCommand {
    /// What mazes there are
    List {
        /// A maze file or a folder [default: ~/.mmsim where that exists, else the bundled mazes]
        mazes: Option<PathBuf>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Draw a maze with the distance of each cell to the goal, in steps
    Show {
        /// A maze file, or words of the path of a maze
        #[arg(required = true)]
        name: Vec<String>,
        /// Where to look for it [default: ~/.mmsim where that exists, else the bundled mazes]
        #[arg(long, value_name = "PATH")]
        mazes: Option<PathBuf>,
        /// Read NAME, a maze file, as one in this format [default: told by its content]
        #[arg(long, value_parser = format(|_| true), conflicts_with = "mazes")]
        format: Option<Format>,
        /// Print a JSON object
        #[arg(long)]
        json: bool,
    },
    /// Size, goals and shortest path of maze files, and what is wrong with them
    ///
    /// Errors, which make the exit code 1: a file that cannot be read, cells that contradict each
    /// other, gaps in the outer wall, a goal that cannot be reached. Warnings: posts without a
    /// wall, cells that cannot be reached, unknown walls, a maze that another file holds as well.
    Check {
        /// Maze files, and folders, which are searched with their subfolders but for hidden files
        /// and those that end in .md or .json
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        /// Read all files as in this format [default: told by their content]
        #[arg(long, value_parser = format(|_| true))]
        format: Option<Format>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
    /// Write a maze file in another format
    Convert(ConvertArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// The maze file, - for the standard input
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// The file to write, - for the standard output: its ending .txt, .trial, .maz or .num says
    /// the format, unless --to does. A file that is there is replaced
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// The format of IN [default: told by its content]
    #[arg(long, value_parser = format(|_| true))]
    pub(crate) format: Option<Format>,
    /// The format of OUT [default: told by its ending, text for the standard output]
    #[arg(long, value_parser = format(Format::is_writable))]
    pub(crate) to: Option<Format>,
    /// Leave out start and goal where the format has no place for them
    #[arg(long)]
    pub(crate) lossy: bool,
}

/// The names of some formats.
fn format(of: fn(Format) -> bool) -> impl TypedValueParser<Value = Format> {
    let names = Format::ALL.into_iter().filter(move |&format| of(format)).map(Format::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Format>())
}
