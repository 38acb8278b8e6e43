//! `mmsim`: serve a maze.

use std::path::Path;

use clap::CommandFactory;
use mmsim_server::Server;
use mmsim_server::limits::MAX_CONNECTIONS;
use mmsim_solvers::MazeFacts;
use mmsim_viewer::{MAX_VIEWER_CONNECTIONS, Show};

use crate::Outcome;
use crate::args::{Cli, ServeArgs};
use crate::interrupt::Interrupt;
use crate::output::{goal_away, say};
use crate::selection::{Collection, Selected};
use crate::{keep, watching};

/// Files that may be open at the same time: all connections, and some more.
const DESCRIPTORS: u64 = (MAX_CONNECTIONS + MAX_VIEWER_CONNECTIONS) as u64 + 100;

/// What it means to listen on anything but loopback.
const ANYBODY: &str = "whoever reaches this port can read walls, add states and delete the \
    history: the protocol has neither password nor encryption";

pub(crate) fn run(args: &ServeArgs) -> Outcome {
    if let Some(command) = args.mazes.as_deref().filter(|path| is_command(path)) {
        let command = command.display();
        return Err(
            format!("expected options after the command, as in `mmsim {command} --help`").into()
        );
    }
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&args.maze.words.join(" "))?;
    let recorder = keep::recorder(&args.keep)?;
    let server = bind(&args.host, args.port)?;
    let viewer = watching::bind(&args.viewer, &args.host)?;
    let (interrupt, stop) = (Interrupt::catch()?, server.stop_handle());
    say(announce(&selected, server.address()));
    if !server.is_loopback() {
        say(ANYBODY);
    }
    let show = Show::default()
        .with_live(&server, &selected.path)
        .with_mazes(collection.catalogue)
        .with_recordings(args.keep.record.clone());
    let mut simulation = keep::simulation(selected, &args.keep);
    keep::announce(&args.keep, &simulation);
    watching::begin(viewer, show, &args.viewer)?;
    std::thread::spawn(move || {
        interrupt.wait();
        stop.stop();
    });
    server.with_recorder(recorder).run(&mut simulation)?;
    Ok(true)
}

/// Whether what stands in the place of mazes is a command that came after an option.
fn is_command(path: &Path) -> bool {
    let commands = Cli::command();
    !path.exists()
        && commands.get_subcommands().any(|command| Path::new(command.get_name()) == path)
}

/// Listens, or says what to try where that fails.
pub(crate) fn bind(host: &str, port: u16) -> Result<Server, String> {
    // Some systems let a process open only 256 files unless it asks for more. Where it gets
    // fewer, fewer clients are connected at the same time.
    let _ = rlimit::increase_nofile_limit(DESCRIPTORS);
    Server::bind(host, port).map_err(|error| match error {
        mmsim_server::BindError::InUse { .. } => format!("{error} Try another --port"),
        error => error.to_string(),
    })
}

/// What is served and where.
pub(crate) fn announce(selected: &Selected, address: &str) -> String {
    let Selected { path, maze, .. } = selected;
    let goal = goal_away(MazeFacts::of(maze).shortest_path);
    format!("serving {} ({}, {goal}) at {address}; Ctrl-C ends it", path.display(), maze.size())
}
