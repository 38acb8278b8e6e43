//! Arguments of `mmsim demo`.

use std::path::PathBuf;

use clap::Args;

use crate::args::ServerArgs;

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it has mazes, else the
    /// bundled mazes]
    pub(crate) mazes: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
    /// Wait MS milliseconds after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS")]
    pub(crate) pace: Option<u64>,
    /// Exit after the search, without serving a viewer page
    #[arg(long)]
    pub(crate) once: bool,
}
