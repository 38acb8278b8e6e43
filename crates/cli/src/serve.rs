//! `mmsim`: serve a maze.

use std::error::Error;
use std::path::PathBuf;

use clap::{Args, Command};
use mmsim_protocol::Info;
use mmsim_viewer::ViewerConfig;
use serde::Serialize;

use crate::args::{CommandResult, ServerArgs, UsageError};
use crate::local_server::{ReadyServer, prepare};
use crate::output::{note, own_command, print_json};
use crate::selection::{DEFAULT_MAZES, MAZE_HELP, Selection, SelectionError, join};

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    #[arg(value_name = "MAZE", help = format!("{MAZE_HELP} [default: {DEFAULT_MAZES}]"))]
    pub(crate) maze: Vec<PathBuf>,
    /// Host name or address to listen on; * for all interfaces
    #[arg(short = 'H', long, default_value = "127.0.0.1")]
    host: String,
    #[command(flatten)]
    pub(crate) server: ServerArgs,
    /// When the server is ready, print its address, the URL of the viewer page and a description of
    /// the maze as a JSON object
    #[arg(long)]
    json: bool,
}

/// Serves a maze. If the words match none, the error may suggest one of `commands`.
pub(crate) fn run(args: &ServeArgs, commands: &Command) -> CommandResult {
    let selection = Selection::read(&join(&args.maze))?;
    let selected = selection.first().map_err(|error| no_such(error, &args.maze, commands))?;
    let ServerArgs { port, retention, viewer, misread } = &args.server;
    let is_bundled = selection.is_bundled();
    let config = ViewerConfig::default().with_mazes(selection.catalogue);
    let address = (&args.host[..], *port);
    let ReadyServer { server, mut simulation, interrupt, page } =
        prepare(selected, misread.misreadings(), config, address, retention, Some(viewer), None)?;
    if is_bundled {
        let fetch = own_command("mazes fetch");
        note(format_args!("for real contest mazes, run {fetch}"));
    }
    if args.json {
        let report = ServerReport { address: server.address(), page, info: simulation.info() };
        print_json(&report)?;
    }
    let stop = server.stop_handle();
    interrupt.then(move || stop.stop());
    server.run(&mut simulation)?;
    Ok(true)
}

/// The JSON report for programs that start a simulator.
#[derive(Serialize)]
struct ServerReport<'a> {
    address: &'a str,
    /// The URL of the viewer page.
    page: Option<String>,
    info: Info,
}

/// Returns another error if the words may be meant as a command, a usage error if one is similar.
fn no_such(error: SelectionError, maze: &[PathBuf], commands: &Command) -> Box<dyn Error> {
    let (words, hint) = match error {
        SelectionError::NoMatch { words, hint, .. } if join(maze) == *words => (words, hint),
        _ => return error.into(),
    };
    let first = words.split(' ').next().unwrap_or_default();
    match suggest(first, commands) {
        Some(suggestion) => {
            UsageError::new("", format!("no such command or maze: {first:?}{suggestion}")).into()
        }
        None => format!("no such command or maze: {words:?} ({hint})").into(),
    }
}

/// Returns a suggestion for the unknown command `mmsim WORD`: a command with a similar name, or else a
/// subcommand of `mmsim mazes`.
pub(crate) fn suggest(word: &str, commands: &Command) -> Option<String> {
    let similar = |commands: &Command, typos: usize| {
        let mut names = commands.get_subcommands().map(Command::get_name);
        let name = names.find(|name| strsim::damerau_levenshtein(word, name) <= typos);
        name.map(str::to_string)
    };
    let for_mazes = || Some(format!("mazes {}", similar(commands.find_subcommand("mazes")?, 1)?));
    let command = similar(commands, 2).or_else(for_mazes)?;
    Some(format!(" (did you mean {}?)", own_command(&format!("{command} …"))))
}
