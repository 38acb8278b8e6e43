//! `mmsim`: serve a maze.

use std::error::Error;

use clap::{Args, Command};
use mmsim_protocol::Info;
use mmsim_viewer::ViewerConfig;
use serde::Serialize;

use crate::args::{CommandResult, ServerArgs};
use crate::local_server::{ReadyServer, prepare};
use crate::output::{note, own_command, print_json};
use crate::selection::{Collection, SelectionError};

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
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

/// Serves a maze. If the given path does not exist, the error may suggest one of `commands`.
pub(crate) fn run(args: &ServeArgs, commands: &Command) -> CommandResult {
    let collection = Collection::at(args.server.mazes.as_deref())
        .map_err(|error| with_suggestion(error, args, commands))?;
    let ServerArgs { words, port, retention, viewer, misread, .. } = &args.server;
    let selected = collection.select(&words.join(" "))?;
    let is_bundled = collection.is_bundled();
    let config = ViewerConfig::default().with_mazes(collection.catalogue);
    let address = (&args.host[..], *port);
    let ReadyServer { server, mut simulation, interrupt, page } =
        prepare(selected, misread.misreadings(), config, address, retention, Some(viewer), None)?;
    if is_bundled {
        let fetch = own_command("mazes fetch");
        note(format_args!("for real contest mazes, run {fetch}"));
    }
    if args.json {
        let report = ServerReport { address: server.address(), page, maze: simulation.info() };
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
    maze: Info,
}

/// Adds a suggestion to the error if the given path does not exist.
fn with_suggestion(error: SelectionError, args: &ServeArgs, commands: &Command) -> Box<dyn Error> {
    let missing = args.server.mazes.iter().filter(|path| !path.exists());
    match missing.filter_map(|path| path.to_str()).find_map(|word| suggest(word, commands)) {
        Some(suggestion) => format!("{error}{suggestion}").into(),
        None => error.into(),
    }
}

/// Returns a suggestion for the unknown command `mmsim WORD`. The suggestion is a command with a
/// similar name, a subcommand of `mmsim mazes` with a similar name, or `--maze WORD` if a maze
/// matches, in that order of preference.
pub(crate) fn suggest(word: &str, commands: &Command) -> Option<String> {
    let similar = |commands: &Command, typos: usize| {
        let mut names = commands.get_subcommands().map(Command::get_name);
        let name = names.find(|name| strsim::damerau_levenshtein(word, name) <= typos);
        name.map(str::to_string)
    };
    let for_mazes = || Some(format!("mazes {}", similar(commands.find_subcommand("mazes")?, 1)?));
    let arguments = if let Some(command) = similar(commands, 2).or_else(for_mazes) {
        format!("{command} …")
    } else {
        Collection::at(None).ok()?.select(word).ok()?;
        format!("--maze {word}")
    };
    Some(format!(" (did you mean {}?)", own_command(&arguments)))
}
