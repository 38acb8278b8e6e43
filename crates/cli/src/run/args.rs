//! Arguments of `mmsim run`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use crate::args::{MouseArgs, PORT_HELP, ServerArgs, VIEWER_PORT_HELP};

const AFTER_HELP: &str = "\
Examples:
  mmsim run --open -- python3 mouse.py           watch the mouse in a browser
  mmsim run --open --watch -- python3 mouse.py   run it again each time mouse.py changes
  mmsim run --maze hedgerow -- ./my-mouse {endpoint}
                                                 pass the address as an argument
  mmsim run --record runs -- ./my-mouse          record each run to a new file

The mouse connects to the address in the environment variable MMSIM_ENDPOINT. In the arguments of
the mouse, {endpoint} stands for the same address. A mouse that always connects to port 6574 works
too, unless another simulator uses this port.

On the viewer page, you can run the mouse again, stop it, pause it, and change its pace. The
simulator holds its reply to a state until the next step is due, so the mouse should wait for
replies without a timeout.

The exit code is that of the mouse, or 128 plus the number of the signal that killed it; 1 if the
mouse jumped, did not start, was stopped or exceeded --time-limit; 130 after Ctrl-C.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("port", |port| port.help(PORT_HELP)))]
#[command(mut_arg("viewer_port", |port| port.help(VIEWER_PORT_HELP)))]
pub(crate) struct RunArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it has mazes, else the
    /// bundled mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// Program to run as the mouse, and its arguments
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<OsString>,
    #[command(flatten)]
    pub(crate) repeat: MouseArgs,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
}
