//! Servers: listening on a port, and a server in this process for a mouse that this process runs.

use std::error::Error;

use mmsim_formats::Catalogue;
use mmsim_recording::Recorder;
use mmsim_server::limits::MAX_CONNECTIONS;
use mmsim_server::{Background, BindError, Server, Simulation};
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{MAX_VIEWER_CONNECTIONS, ViewerConfig};

use crate::args::{RetentionArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::output::{goal_away, note, warn};
use crate::retention::{self, MemoryLimits};
use crate::selection::Selected;
use crate::{page, stderr};

/// The address on which a server for this process's own mouse listens.
const HOST: &str = "127.0.0.1";

/// The warning about an address that other machines can reach.
const EXPOSED: &str = "anyone who can reach this port can read walls, add states and delete the \
    history: the protocol has no authentication and no encryption";

/// The number of files that may be open at a time: all connections, and some more.
const DESCRIPTORS: u64 = (MAX_CONNECTIONS + MAX_VIEWER_CONNECTIONS) as u64 + 100;

/// A server that is ready to run.
pub(crate) struct ReadyServer {
    pub(crate) server: Server,
    pub(crate) simulation: Simulation,
    pub(crate) interrupt: Interrupt,
    /// The address of the viewer page.
    pub(crate) page: Option<String>,
}

/// Serves the selected maze on a thread of its own, and catches Ctrl-C from then on.
pub(crate) fn start(
    selected: Selected,
    mazes: Catalogue,
    port: u16,
    retention: &RetentionArgs,
    viewer: Option<&ViewerArgs>,
) -> Result<(Background, Interrupt), Box<dyn Error>> {
    let ready = prepare(selected, mazes, (HOST, port), retention, viewer)?;
    Ok((ready.server.spawn(ready.simulation), ready.interrupt))
}

/// Prepares to serve the selected maze, reports its address, and catches Ctrl-C from then on. Serves
/// the viewer page, which also offers `mazes`, unless `viewer` is `None`.
pub(crate) fn prepare(
    selected: Selected,
    mazes: Catalogue,
    (host, port): (&str, u16),
    retention: &RetentionArgs,
    viewer: Option<&ViewerArgs>,
) -> Result<ReadyServer, Box<dyn Error>> {
    stderr::write_in_background();
    let limits = MemoryLimits::new(retention);
    let recorder = retention.record.as_deref().map(Recorder::new).transpose()?;
    let server = bind(host, port)?;
    let bound = viewer.map(|args| page::bind(args, host)).transpose()?.flatten();
    let interrupt = Interrupt::catch()?;
    note(announcement(&selected, server.address()));
    if !server.is_loopback() {
        warn(EXPOSED);
    }
    let config = ViewerConfig::default()
        .with_live(&server, &selected.path)
        .with_mazes(mazes)
        .with_recordings(retention.record.clone())
        .with_budget(limits.recordings);
    let simulation =
        Simulation::new(&selected.name, selected.maze).with_history_limit(limits.history);
    retention::report(retention, &simulation);
    let page = viewer.map(|args| page::serve(bound, config, args)).transpose()?.flatten();
    Ok(ReadyServer { server: server.with_recorder(recorder), simulation, interrupt, page })
}

/// Listens on a port.
fn bind(host: &str, port: u16) -> Result<Server, String> {
    // Some systems let a process open only 256 files unless it asks for more. With fewer, fewer
    // clients can be connected at a time.
    let _ = rlimit::increase_nofile_limit(DESCRIPTORS);
    Server::bind(host, port).map_err(|error| match error {
        BindError::InUse { .. } => format!("{error} (try --port 0)"),
        error => error.to_string(),
    })
}

/// Returns a line that says which maze is served and where.
fn announcement(selected: &Selected, address: &str) -> String {
    let Selected { path, maze, .. } = selected;
    let goal = goal_away(MazeFacts::new(maze).shortest_path);
    let (path, size) = (path.display(), maze.size());
    format!("serving {path} ({size}, {goal}) at {address}; press Ctrl-C to stop")
}
