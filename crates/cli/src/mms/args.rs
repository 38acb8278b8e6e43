//! Arguments of `mmsim mms`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_mms::ScoreRules;

use crate::args::{KnownMazeArgs, MouseArgs, PORT_HELP, ServerArgs, VIEWER_PORT_HELP, one_of};
use crate::connection::ENDPOINT_FORM;

const AFTER_HELP: &str = "\
Examples:
  mmsim mms --open -- ./my-mouse                 watch the mouse in a browser
  mmsim mms --maze hedgerow -- python3 Main.py   use the first maze whose path contains this word
  mmsim mms --open --watch -- python3 Main.py    run it again each time Main.py changes
  mmsim mms --pace 50 -- java -jar mouse.jar     run slowly
  mmsim mms --score --limit 2000 -- ./my-mouse   print its scores
  mmsim mms --connect tcp://127.0.0.1:6574 -- ./my-mouse
                                                 use the maze of a running simulator

Press Enter to press the reset button. On the viewer page, you can also run the mouse again, stop
it, pause it, and change its pace. The exit code is that of the mouse, or 128 plus the number of the
signal that killed it; 1 if the mouse did not start, was stopped, exceeded --limit or --time-limit,
or lost the simulator; 130 after Ctrl-C.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
#[command(mut_arg("port", |port| port.help(PORT_HELP)))]
#[command(mut_arg("viewer_port", |port| port.help(VIEWER_PORT_HELP)))]
pub(crate) struct MmsArgs {
    /// Maze file, or folder to search recursively [default: ~/.mmsim if it has mazes, else the
    /// bundled mazes]
    #[arg(conflicts_with = "connect")]
    pub(crate) mazes: Option<PathBuf>,
    /// Program to run as the mouse, and its arguments
    #[arg(last = true, required = true, value_name = "COMMAND")]
    pub(crate) command: Vec<OsString>,
    /// Print the scores when the mouse exits
    #[arg(long)]
    pub(crate) score: bool,
    /// Print a JSON object when the mouse exits
    #[arg(long, conflicts_with = "score")]
    pub(crate) json: bool,
    /// Rules for the scores and for the replies to getStat
    #[arg(long, value_name = "RULES", value_parser = score_rules(), default_value = "mms-1.2")]
    pub(crate) scores: ScoreRules,
    /// Stop the mouse when its number of turns plus its effective distance in cells exceeds N
    #[arg(long, value_name = "N")]
    pub(crate) limit: Option<u32>,
    #[command(flatten)]
    pub(crate) repeat: MouseArgs,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
    #[command(flatten)]
    pub(crate) remote: RemoteArgs,
}

/// Options for a simulator in another process.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options for --connect")]
pub(crate) struct RemoteArgs {
    #[arg(
        long,
        value_name = "ENDPOINT",
        help = format!(
            "Run the mouse in the maze of a simulator at {ENDPOINT_FORM} instead of serving a maze"
        ),
        conflicts_with_all = [
            "stay",
            "watch",
            "port",
            "words",
            "record",
            "history_limit",
            "viewer_port",
            "no_viewer",
            "open",
        ],
    )]
    pub(crate) connect: Option<String>,
    #[command(flatten)]
    pub(crate) known: KnownMazeArgs,
}

fn score_rules() -> impl TypedValueParser<Value = ScoreRules> {
    one_of(ScoreRules::ALL, |rules| {
        PossibleValue::new(rules.name()).help(match rules {
            ScoreRules::Mms12 => {
                "Count half steps, and the full distance of movements that crash, as mms 1.2 does"
            }
            ScoreRules::Cells => "Count the cells that the mouse has travelled",
        })
    })
}
