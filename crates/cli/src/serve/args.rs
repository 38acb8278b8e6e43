//! Arguments of `mmsim` without a command.

use std::path::PathBuf;

use clap::Args;

use crate::args::ServerArgs;

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it has mazes, else the
    /// bundled mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// Host name or address to listen on; * for all interfaces
    #[arg(short = 'H', long, default_value = "127.0.0.1")]
    pub(crate) host: String,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
    /// When the server is ready, print its address, the URL of the viewer page and a description of
    /// the maze as a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
