//! Servers: listening on a port, and a server in this process for a mouse that this process runs.

use std::error::Error;

use mmsim_formats::Catalogue;
use mmsim_server::limits::MAX_CONNECTIONS;
use mmsim_server::{Background, BindError, Server};
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{MAX_VIEWER_CONNECTIONS, ViewerConfig};

use crate::args::{RetentionArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::output::{goal_away, note};
use crate::retention::{self, MemoryLimits};
use crate::selection::Selected;
use crate::{page, stderr};

/// The address on which a server for this process's own mouse listens.
pub(crate) const HOST: &str = "127.0.0.1";

/// The number of files that may be open at a time: all connections, and some more.
const DESCRIPTORS: u64 = (MAX_CONNECTIONS + MAX_VIEWER_CONNECTIONS) as u64 + 100;

/// Serves the selected maze on a thread of its own, reports its address, and catches Ctrl-C from then
/// on. The viewer page also offers `mazes`. There is no page if `viewer` is `None`.
pub(crate) fn start(
    selected: Selected,
    mazes: Catalogue,
    port: u16,
    retention: &RetentionArgs,
    viewer: Option<&ViewerArgs>,
) -> Result<(Background, Interrupt), Box<dyn Error>> {
    stderr::write_in_background();
    let limits = MemoryLimits::new(retention);
    let recorder = retention::recorder(retention)?;
    let server = bind(HOST, port)?;
    let page = viewer.map(|args| page::bind(args, HOST)).transpose()?.flatten();
    let interrupt = Interrupt::catch()?;
    note(announcement(&selected, server.address()));
    let config = ViewerConfig::default()
        .with_live(&server, &selected.path)
        .with_mazes(mazes)
        .with_recordings(retention.record.clone())
        .with_budget(limits.recordings.clone());
    let simulation = limits.simulation(selected);
    retention::report(retention, &simulation);
    let server = server.with_recorder(recorder).spawn(simulation);
    if let Some(args) = viewer {
        page::serve(page, config, args)?;
    }
    Ok((server, interrupt))
}

/// Listens on a port.
pub(crate) fn bind(host: &str, port: u16) -> Result<Server, String> {
    // Some systems let a process open only 256 files unless it asks for more. With fewer, fewer
    // clients can be connected at a time.
    let _ = rlimit::increase_nofile_limit(DESCRIPTORS);
    Server::bind(host, port).map_err(|error| match error {
        BindError::InUse { .. } => format!("{error} (try --port 0)"),
        error => error.to_string(),
    })
}

/// Returns a line that says which maze is served and where.
pub(crate) fn announcement(selected: &Selected, address: &str) -> String {
    let Selected { path, maze, .. } = selected;
    let goal = goal_away(MazeFacts::new(maze).shortest_path);
    let (path, size) = (path.display(), maze.size());
    format!("serving {path} ({size}, {goal}) at {address}; press Ctrl-C to stop")
}
