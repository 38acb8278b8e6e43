//! Arguments of `mmsim` without a command.

use std::path::PathBuf;

use clap::Args;
use mmsim_protocol::DEFAULT_PORT;

use crate::args::{MazeArg, RetentionArgs, ViewerArgs};

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it exists, else the bundled
    /// mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// Host name or address to listen on; * for all interfaces
    #[arg(short = 'H', long, default_value = "127.0.0.1")]
    pub(crate) host: String,
    /// Port to listen on; 0 picks a free port
    #[arg(short, long, default_value_t = DEFAULT_PORT)]
    pub(crate) port: u16,
    #[command(flatten)]
    pub(crate) maze: MazeArg,
    #[command(flatten)]
    pub(crate) retention: RetentionArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
    /// Print a JSON object when ready: the addresses of the server and the viewer page, and the `info`
    /// of the maze
    #[arg(long)]
    pub(crate) json: bool,
}
