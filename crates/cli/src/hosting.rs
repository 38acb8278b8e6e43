//! A server in this process, and the page beside it, for a mouse that this process lets search.

use std::error::Error;

use mmsim_formats::Catalogue;
use mmsim_server::Background;
use mmsim_viewer::ViewerConfig;

use crate::args::{KeepArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::output::say;
use crate::selection::Selected;
use crate::serve::{announce, bind};
use crate::{keep, stderr, watching};

/// Only this machine's own mouse and browser come.
pub(crate) const HOST: &str = "127.0.0.1";

/// Serves the selected maze on a thread of its own, says where, and from then on catches Ctrl-C.
/// The page offers `mazes` too. Without `viewer` there is none.
pub(crate) fn begin(
    selected: Selected,
    mazes: Catalogue,
    port: u16,
    keep: &KeepArgs,
    viewer: Option<&ViewerArgs>,
) -> Result<(Background, Interrupt), Box<dyn Error>> {
    stderr::write_in_background();
    let limits = keep::Limits::new(keep);
    let recorder = keep::recorder(keep)?;
    let server = bind(HOST, port)?;
    let page = viewer.map(|args| watching::bind(args, HOST)).transpose()?.flatten();
    let interrupt = Interrupt::catch()?;
    say(announce(&selected, server.address()));
    let show = ViewerConfig::default()
        .with_live(&server, &selected.path)
        .with_mazes(mazes)
        .with_recordings(keep.record.clone())
        .with_budget(limits.recordings.clone());
    let simulation = limits.simulation(selected);
    keep::announce(keep, &simulation);
    let server = server.with_recorder(recorder).spawn(simulation);
    if let Some(args) = viewer {
        watching::begin(page, show, args)?;
    }
    Ok((server, interrupt))
}
