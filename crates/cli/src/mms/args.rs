//! The command line of `mmsim mms`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use mmsim_protocol::DEFAULT_PORT;

use crate::args::{KeepArgs, MazeArg, ToldArgs, ViewerArgs};

const AFTER_HELP: &str = "\
Examples:
  mmsim mms --open -- ./my-mouse                 watch its search in a browser
  mmsim mms --maze hedgerow -- python3 Main.py   in the first maze whose path holds this word
  mmsim mms --pace 50 -- java -jar mouse.jar     slowly
  mmsim mms --score --limit 2000 -- ./my-mouse   score it
  mmsim mms --connect tcp://127.0.0.1:6574 -- ./my-mouse

Enter presses the reset button. The exit code is the mouse's own, or 128 and the number of the
signal that ended it; 1 if it could not be started, came to --limit or lost the simulator; 130
after Ctrl-C.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct MmsArgs {
    /// A maze file, or a folder that is searched with its subfolders [default: ~/.mmsim where
    /// that exists, else the bundled mazes]
    #[arg(conflicts_with = "connect")]
    pub(crate) mazes: Option<PathBuf>,
    /// The program that is the mouse, and its arguments
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<OsString>,
    /// Print the scores when the mouse has ended
    #[arg(long)]
    pub(crate) score: bool,
    /// Print a JSON object when the mouse has ended
    #[arg(long, conflicts_with = "score")]
    pub(crate) json: bool,
    /// End the mouse once its turns and its effective distance come to more than this
    #[arg(long, value_name = "N")]
    pub(crate) limit: Option<u32>,
    /// Wait this long after each cell and each turn
    #[arg(long, value_name = "MS", default_value_t = 0)]
    pub(crate) pace: u64,
    /// Serve on when the mouse has ended, so that its search can be looked at, until Ctrl-C; --open
    /// implies it
    #[arg(long, conflicts_with = "connect")]
    pub(crate) stay: bool,
    /// The port to listen on, 0 for any that is free
    #[arg(short, long, default_value_t = DEFAULT_PORT, conflicts_with = "connect")]
    pub(crate) port: u16,
    #[command(flatten)]
    pub(crate) maze: MazeArg,
    #[command(flatten)]
    pub(crate) keep: KeepArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
    #[command(flatten)]
    pub(crate) elsewhere: ElsewhereArgs,
}

/// What concerns a simulator in another process.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options of --connect")]
pub(crate) struct ElsewhereArgs {
    /// Search the maze of the simulator that listens here, this one or the reference one, as
    /// tcp://HOST:PORT, instead of serving one
    #[arg(
        long,
        value_name = "ENDPOINT",
        conflicts_with_all = ["words", "record", "history_limit", "viewer_port", "no_viewer", "open"],
    )]
    pub(crate) connect: Option<String>,
    #[command(flatten)]
    pub(crate) told: ToldArgs,
}

impl MmsArgs {
    /// Whether to serve on when the mouse has ended.
    pub(crate) const fn stays(&self) -> bool {
        self.stay || self.viewer.open
    }
}
