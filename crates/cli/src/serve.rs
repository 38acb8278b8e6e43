//! `mmsim`: serve a maze.

pub(crate) mod args;

use std::error::Error;

use clap::Command;
use mmsim_protocol::Info;
use mmsim_viewer::ViewerConfig;
use serde::Serialize;

use crate::interrupt::Interrupt;
use crate::local_server::{announcement, bind};
use crate::output::{note, print_json, warn};
use crate::retention::{self, MemoryLimits};
use crate::selection::{Collection, SelectionError};
use crate::suggest::suggest;
use crate::usage::CommandResult;
use crate::{page, stderr};
use args::ServeArgs;

/// The warning about an address that other machines can reach.
const EXPOSED: &str = "anyone who can reach this port can read walls, add states and delete the \
    history: the protocol has no authentication and no encryption";

/// Serves a maze. `commands` is the command line, to suggest a command instead of a missing folder.
pub(crate) fn run(args: &ServeArgs, commands: &Command) -> CommandResult {
    let collection = Collection::at(args.mazes.as_deref())
        .map_err(|error| with_suggestion(error, args, commands))?;
    let selected = collection.select(&args.maze.words.join(" "))?;
    stderr::write_in_background();
    let limits = MemoryLimits::new(&args.retention);
    let recorder = retention::recorder(&args.retention)?;
    let server = bind(&args.host, args.port)?;
    let viewer = page::bind(&args.viewer, &args.host)?;
    let (interrupt, stop) = (Interrupt::catch()?, server.stop_handle());
    note(announcement(&selected, server.address()));
    if !server.is_loopback() {
        warn(EXPOSED);
    }
    let config = ViewerConfig::default()
        .with_live(&server, &selected.path)
        .with_mazes(collection.catalogue)
        .with_recordings(args.retention.record.clone())
        .with_budget(limits.recordings.clone());
    let mut simulation = limits.simulation(selected);
    retention::report(&args.retention, &simulation);
    let page = page::serve(viewer, config, &args.viewer)?;
    if args.json {
        let report = ServerReport { address: server.address(), page, maze: simulation.info() };
        print_json(&serde_json::to_string(&report)?)?;
    }
    std::thread::spawn(move || {
        interrupt.wait();
        stop.stop();
    });
    server.with_recorder(recorder).run(&mut simulation)?;
    Ok(true)
}

/// The output of `--json`, for a program that starts a simulator and then a mouse.
#[derive(Serialize)]
struct ServerReport<'a> {
    address: &'a str,
    /// The address of the viewer page.
    page: Option<String>,
    maze: Info,
}

/// Adds what the user may have meant instead of a folder that does not exist.
fn with_suggestion(error: SelectionError, args: &ServeArgs, commands: &Command) -> Box<dyn Error> {
    let missing = args.mazes.iter().filter(|path| !path.exists());
    match missing.filter_map(|path| path.to_str()).find_map(|word| suggest(word, commands)) {
        Some(suggestion) => format!("{error} (did you mean {suggestion}?)").into(),
        None => error.into(),
    }
}
