//! Connecting a mouse to a simulator.

use std::env;
use std::time::Duration;

use mmsim_client::{Exchange, RunError, Timeout, TransportError, Waiting, Zmq};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose};
use mmsim_mouse::ENDPOINT_VARIABLE;
use mmsim_protocol::DEFAULT_PORT;

use crate::args::{KnownMazeArgs, UsageError};
use crate::output::{own_command, warn};

/// The form of the addresses of simulators.
#[cfg(not(feature = "libzmq"))]
pub(crate) const ENDPOINT_FORM: &str = "tcp://HOST:PORT";
#[cfg(feature = "libzmq")]
pub(crate) const ENDPOINT_FORM: &str = "tcp://HOST:PORT or ipc://PATH";

/// What a mouse knows about a simulator before it starts.
pub(crate) struct KnownSimulator {
    /// The name of the maze, or `None` if a simulator in another process was not asked.
    pub(crate) name: Option<String>,
    pub(crate) map: KnownMaze,
    pub(crate) start: Pose,
    /// True if the simulator has said that it accepts annotations.
    pub(crate) has_annotations: bool,
}

/// Returns the help of an argument for the address of a simulator, which is called `what`.
pub(crate) fn endpoint_help(what: &str) -> String {
    format!(
        "{what} as {ENDPOINT_FORM}\n[default: the environment variable {ENDPOINT_VARIABLE}, or else \
        tcp://127.0.0.1:{DEFAULT_PORT}]"
    )
}

/// Returns the `ZeroMQ` address of a simulator: the given one or, by default, that of the `mmsim run`
/// that has started this process, or else the default port. The default transport is `tcp://`.
pub(crate) fn endpoint(given: Option<&str>) -> String {
    let variable = || env::var(ENDPOINT_VARIABLE).ok().filter(|address| !address.is_empty());
    let default = || format!("127.0.0.1:{DEFAULT_PORT}");
    let address = given.map(String::from).or_else(variable).unwrap_or_else(default);
    if address.contains("://") { address } else { format!("tcp://{address}") }
}

/// Connects a mouse to a simulator. By default, replies have no time limit if the simulator is the
/// `mmsim run` that has started this process: it holds its replies while the mouse is paused.
pub(crate) fn connect(
    endpoint: &str,
    timeout: Option<Duration>,
    asks_server: bool,
) -> Result<Zmq<'static>, TransportError> {
    let is_run = env::var(ENDPOINT_VARIABLE).is_ok_and(|variable| variable == endpoint);
    let default = if is_run { Timeout::Never } else { Timeout::Default };
    #[cfg(not(feature = "libzmq"))]
    let connect = Zmq::connect;
    #[cfg(feature = "libzmq")]
    let connect = Zmq::connect_with_libzmq;
    connect(endpoint, timeout.map_or(default, Timeout::After), move |waiting: Waiting<'_>| {
        if !(is_run && waiting.answered) {
            report_waiting(&waiting, asks_server);
        }
    })
}

/// Returns the maze that the arguments define, or `None` with `--goal server`. A usage error shows the usage of `command`.
pub(crate) fn maze_from_args(
    command: &'static str,
    KnownMazeArgs { size, goal }: &KnownMazeArgs,
) -> Result<Option<KnownSimulator>, UsageError> {
    let size = size.unwrap_or(MazeSize::CLASSIC);
    if goal.contains(&None) {
        if goal.len() > 1 {
            return Err(UsageError::new(command, "--goal takes either server or cells, not both"));
        }
        return Ok(None);
    }
    let cells = goal.iter().flatten().copied();
    if let Some(cell) = cells.clone().find(|&cell| !size.contains(cell)) {
        let message = format!("--goal {},{} is outside the {size} maze", cell.x, cell.y);
        return Err(UsageError::new(command, message));
    }
    let goals: CellSet = cells.collect();
    let start = Pose::new(Cell::new(0, 0), Heading::North);
    let goals = if goals.is_empty() { size.central_cells() } else { goals };
    let map = KnownMaze::new(size, start.cell, goals);
    Ok(Some(KnownSimulator { name: None, map, start, has_annotations: false }))
}

/// Asks the server for its maze. Returns an error if the server's maze does not
/// have the given size.
pub(crate) fn ask_maze(
    transport: &mut Zmq<'_>,
    size: Option<MazeSize>,
) -> Result<KnownSimulator, String> {
    let info = Exchange::new(transport).info().map_err(|error| error.to_string())?;
    let (Some(map), Some(start)) = (info.known_maze(), info.start_pose()) else {
        return Err(format!("expected a maze of 1x1 to 32x32 cells, found {info:?}"));
    };
    let served = map.size();
    if let Some(size) = size.filter(|&size| size != served) {
        return Err(format!("--size is {size}, but the server's maze is {served}"));
    }
    let has_annotations = info.has_annotations();
    Ok(KnownSimulator { name: Some(info.maze), map, start, has_annotations })
}

/// Warns that a reply is late. The transport calls this every second while it waits; for each
/// request, only the first call and every tenth call print a warning.
fn report_waiting(waiting: &Waiting<'_>, asks_server: bool) {
    let Waiting { endpoint, elapsed, notices, answered } = waiting;
    if *notices != 1 && notices % 10 != 0 {
        return;
    }
    let seconds = elapsed.as_secs();
    let hint = match (answered, asks_server) {
        (true, _) => String::new(),
        (false, false) => format!(" (start a simulator with {})", own_command("")),
        (false, true) => " (--goal server needs mmsim as the simulator)".into(),
    };
    warn(format_args!(
        "no reply from {endpoint} for {seconds} s, still waiting{hint}; press Ctrl-C to give up"
    ));
}

/// Formats the error, with a hint if the maze size or the goal may be wrong, or if no simulator
/// replies.
pub(crate) fn explain(error: &RunError) -> String {
    match error {
        RunError::Refused { request: "S", .. } | RunError::LargerMaze { .. } => {
            format!("{error} (set --size and --goal to match the maze, or use --goal server)")
        }
        RunError::Transport(TransportError::NoReply { .. }) => {
            format!("{error} (start a simulator with {})", own_command(""))
        }
        _ => error.to_string(),
    }
}
