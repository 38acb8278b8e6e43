//! Starts a server, either alone or for a mouse in the same process.

use std::error::Error;
use std::sync::Arc;

use mmsim_client::{InMemory, Transport};
use mmsim_compare::NamedMaze;
use mmsim_maze::Misreadings;
use mmsim_mouse::MouseControl;
use mmsim_protocol::{DEFAULT_PORT, ERROR_PREFIX};
use mmsim_recording::Recorder;
use mmsim_server::{BindError, LIMITS, Monitor, Server, Simulation};
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{MAX_VIEWER_CONNECTIONS, ViewerConfig};

use crate::args::{RetentionArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::output::{goal_away, note, warn, with_port_hint};
use crate::recordings::{self, MemoryLimits};
use crate::{page, stderr};

/// The host address on which a server listens for a mouse in the same process.
pub(crate) const HOST: &str = "127.0.0.1";

/// The warning for a server that other machines can reach.
const EXPOSED: &str = "anyone who can reach this port can read walls, add states and delete the \
    history: the protocol has no authentication and no encryption";

/// The open-file limit to request from the system: one file per possible connection, plus 100 for
/// everything else.
const DESCRIPTORS: u64 = (LIMITS.max_connections + MAX_VIEWER_CONNECTIONS) as u64 + 100;

/// A server that is ready to run.
pub(crate) struct ReadyServer {
    pub(crate) server: Server,
    pub(crate) simulation: Simulation,
    pub(crate) interrupt: Interrupt,
    /// The URL of the viewer page.
    pub(crate) page: Option<String>,
}

/// Returns a transport for the user's own mouse, which does not count as a client of the server.
pub(crate) fn in_process(monitor: &Monitor) -> impl Transport + '_ {
    InMemory::new(|request: &[u8], reply: &mut Vec<u8>| {
        *reply = monitor
            .answer(None, request, 1)
            .map_or_else(|error| format!("{ERROR_PREFIX}{error}").into_bytes(), |(reply, _)| reply);
    })
}

/// The control of the mouse that the viewer page shows, and the address for clients if it differs from
/// that of the server.
pub(crate) type MouseSetup = (Arc<MouseControl>, Option<String>);

/// Prepares a server for the selected maze, whose walls clients may misread, prints the server's
/// address, and starts catching Ctrl-C. Unless `viewer` is `None`, also serves the viewer page.
pub(crate) fn prepare(
    selected: NamedMaze,
    misreadings: Misreadings,
    config: ViewerConfig,
    (host, port): (&str, Option<u16>),
    retention: &RetentionArgs,
    viewer: Option<&ViewerArgs>,
    mouse: Option<MouseSetup>,
) -> Result<ReadyServer, Box<dyn Error>> {
    stderr::write_in_background();
    let limits = MemoryLimits::new(retention);
    let recorder = retention.record.as_deref().map(Recorder::new).transpose()?.map(|recorder| {
        let options = retention.recording;
        recorder.with_messages(options.messages()).with_limit(options.limit())
    });
    let server = bind(host, port, mouse.is_some())?;
    // The page of a mouse is also its control panel.
    let bound = viewer.map(|args| page::bind(args, host, mouse.is_some()));
    let bound = bound.transpose()?.flatten();
    let interrupt = Interrupt::catch()?;
    let NamedMaze { path, name, maze } = selected;
    let (goal, size) = (goal_away(MazeFacts::new(&maze).shortest_path), maze.size());
    let (control, address) = mouse.unwrap_or_default();
    let address = address.as_deref().unwrap_or(server.address());
    let shown = path.display();
    note(format_args!("serving {shown} ({size}, {goal}) at {address}; press Ctrl-C to stop"));
    if !server.is_loopback() {
        warn(EXPOSED);
    }
    let config = config
        .with_live(&server, &path)
        .with_mouse(control)
        .with_address(address)
        .with_recordings(retention.record.clone())
        .with_budget(limits.recordings);
    let simulation = Simulation::new(&name, maze)
        .with_misreadings(misreadings)
        .with_history_limit(limits.history);
    recordings::report(retention, &simulation);
    let page = viewer.map(|args| page::serve(bound, config, args)).transpose()?.flatten();
    Ok(ReadyServer { server: server.with_recorder(recorder), simulation, interrupt, page })
}

/// Lets this process open this many files if possible.
pub(crate) fn raise_file_limit(files: u64) {
    // Other systems limit only the files of the C library.
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
        let allowed = files.min(maximum.unwrap_or(u64::MAX));
        if current.is_some_and(|current| current < allowed) {
            let _ = setrlimit(Resource::Nofile, Rlimit { current: Some(allowed), maximum });
        }
    }
    #[cfg(not(unix))]
    let _ = files;
}

/// Binds a server to a port. If `has_mouse` is true, the default port is optional, because the mouse
/// learns the port from this process.
fn bind(host: &str, port: Option<u16>, has_mouse: bool) -> Result<Server, String> {
    // Some systems let a process open only 256 files unless it requests more. If the request fails,
    // fewer clients can connect.
    raise_file_limit(DESCRIPTORS);
    let bind = |port| Server::bind(host, port);
    if has_mouse {
        return bind_or_free(port, bind);
    }
    bind(port.unwrap_or(DEFAULT_PORT)).map_err(|error| with_port_hint(&error, "--port"))
}

/// Binds `port`. If no port is given, binds the default port, or a free port if the default port is
/// in use.
pub(crate) fn bind_or_free<T>(
    port: Option<u16>,
    bind: impl Fn(u16) -> Result<T, BindError>,
) -> Result<T, String> {
    let bound = match bind(port.unwrap_or(DEFAULT_PORT)) {
        Err(error @ BindError::InUse { .. }) if port.is_none() => {
            note(format_args!("{error}; using a free port instead"));
            bind(0)
        }
        bound => bound,
    };
    bound.map_err(|error| with_port_hint(&error, "--port"))
}
