//! Arguments of `mmsim demo`.

use std::path::PathBuf;

use clap::Args;
use mmsim_protocol::DEFAULT_PORT;

use crate::args::{MazeArg, RetentionArgs, ViewerArgs};

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it exists, else the bundled
    /// mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// Port to listen on; 0 picks a free port
    #[arg(short, long, default_value_t = DEFAULT_PORT)]
    pub(crate) port: u16,
    #[command(flatten)]
    pub(crate) maze: MazeArg,
    #[command(flatten)]
    pub(crate) retention: RetentionArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
    /// Wait MS milliseconds after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS")]
    pub(crate) pace: Option<u64>,
    /// Exit after the search, without serving a viewer page
    #[arg(long)]
    pub(crate) once: bool,
}
