//! The command line of `mmsim mazes`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

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
        /// Print a JSON object
        #[arg(long)]
        json: bool,
    },
    /// Size, goals and shortest path of maze files, or what is wrong with them
    Check {
        /// Maze files, and folders, which are searched with their subfolders but for hidden files
        /// and those that end in .md or .json
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        /// Print a JSON array
        #[arg(long)]
        json: bool,
    },
}
