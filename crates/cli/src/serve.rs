//! `mmsim`: serve a maze.

use std::error::Error;
use std::path::Path;

use mmsim_protocol::Info;
use mmsim_server::Server;
use mmsim_server::limits::MAX_CONNECTIONS;
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{MAX_VIEWER_CONNECTIONS, ViewerConfig};
use serde::Serialize;

use crate::Outcome;
use crate::args::{Cli, ServeArgs, options_before};
use crate::interrupt::Interrupt;
use crate::meant::meant;
use crate::output::{complain, goal_away, print_json, say};
use crate::selection::{Collection, Selected, SelectionError};
use crate::{keep, stderr, watching};

/// Files that may be open at the same time: all connections, and some more.
const DESCRIPTORS: u64 = (MAX_CONNECTIONS + MAX_VIEWER_CONNECTIONS) as u64 + 100;

/// What it means to listen on anything but loopback.
const ANYBODY: &str = "whoever reaches this port can read walls, add states and delete the \
    history: the protocol has neither password nor encryption";

pub(crate) fn run(args: &ServeArgs) -> Outcome {
    if let Some(name) = args.mazes.as_deref().filter(|path| is_command(path)) {
        options_before(name.as_os_str());
    }
    let collection = Collection::at(args.mazes.as_deref()).map_err(|error| hint(error, args))?;
    let selected = collection.select(&args.maze.words.join(" "))?;
    stderr::write_in_background();
    let limits = keep::Limits::new(&args.keep);
    let recorder = keep::recorder(&args.keep)?;
    let server = bind(&args.host, args.port)?;
    let viewer = watching::bind(&args.viewer, &args.host)?;
    let (interrupt, stop) = (Interrupt::catch()?, server.stop_handle());
    say(announce(&selected, server.address()));
    if !server.is_loopback() {
        complain(ANYBODY);
    }
    let show = ViewerConfig::default()
        .with_live(&server, &selected.path)
        .with_mazes(collection.catalogue)
        .with_recordings(args.keep.record.clone())
        .with_budget(limits.recordings.clone());
    let mut simulation = limits.simulation(selected);
    keep::announce(&args.keep, &simulation);
    let page = watching::begin(viewer, show, &args.viewer)?;
    if args.json {
        let place = Place { address: server.address(), page, maze: simulation.info() };
        print_json(&serde_json::to_string(&place)?)?;
    }
    std::thread::spawn(move || {
        interrupt.wait();
        stop.stop();
    });
    server.with_recorder(recorder).run(&mut simulation)?;
    Ok(true)
}

/// What `--json` prints once it serves, for a program that starts a simulator and then a mouse.
#[derive(Serialize)]
struct Place<'a> {
    address: &'a str,
    /// The page to watch.
    page: Option<String>,
    maze: Info,
}

/// Whether what stands in the place of mazes is a command that came after an option.
fn is_command(path: &Path) -> bool {
    !path.exists() && Cli::has_command(path.as_os_str())
}

/// The error, and what may have been meant in place of a folder that is not there.
fn hint(error: SelectionError, args: &ServeArgs) -> Box<dyn Error> {
    let missing = args.mazes.iter().filter(|path| !path.exists());
    match missing.filter_map(|path| path.to_str()).find_map(meant) {
        Some(meant) => format!("{error}; was {meant} meant?").into(),
        None => error.into(),
    }
}

/// Listens, or says what to try where that fails.
pub(crate) fn bind(host: &str, port: u16) -> Result<Server, String> {
    // Some systems let a process open only 256 files unless it asks for more. Where it gets
    // fewer, fewer clients are connected at the same time.
    let _ = rlimit::increase_nofile_limit(DESCRIPTORS);
    Server::bind(host, port).map_err(|error| match error {
        mmsim_server::BindError::InUse { .. } => {
            format!("{error} (try --port 0)")
        }
        error => error.to_string(),
    })
}

/// What is served and where.
pub(crate) fn announce(selected: &Selected, address: &str) -> String {
    let Selected { path, maze, .. } = selected;
    let goal = goal_away(MazeFacts::new(maze).shortest_path);
    format!("serving {} ({}, {goal}) at {address}; Ctrl-C ends it", path.display(), maze.size())
}
