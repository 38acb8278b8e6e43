//! Arguments of `mmsim replay`.

use std::path::PathBuf;

use clap::Args;
use mmsim_fastrun::Vehicle;

use crate::args::ReadingArgs;
use crate::vehicle::parse_vehicle;

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Recording file; if the file is truncated, the intact part is shown
    pub(crate) file: PathBuf,
    /// Further recordings to show beside the first one
    #[arg(value_name = "FILE", requires = "serve")]
    pub(crate) others: Vec<PathBuf>,
    /// Show state N, counted from 0 [default: the last state]
    #[arg(long, value_name = "N")]
    pub(crate) at: Option<usize>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Show the recording in a browser until Ctrl-C
    #[arg(long, conflicts_with_all = ["at", "json"])]
    pub(crate) serve: bool,
    /// Port of the viewer page; 0 picks a free port [default: 6575]
    #[arg(long, value_name = "PORT", requires = "serve")]
    pub(crate) viewer_port: Option<u16>,
    /// Open the viewer page in a browser
    #[arg(long, requires = "serve")]
    pub(crate) open: bool,
    /// Offer the vehicle in FILE (TOML) for fast runs on the viewer page; may be repeated
    #[arg(long, value_name = "FILE", value_parser = parse_vehicle, requires = "serve")]
    pub(crate) vehicle: Vec<Vehicle>,
}
