//! What somebody may have meant who typed something else.

use clap::{Command, CommandFactory};

use crate::args::Cli;
use crate::output::own_command;
use crate::selection::Collection;

/// The command that this word may stand for: one of a similar name, one of those for mazes, or the
/// one that serves a maze of this name.
pub(crate) fn meant(word: &str) -> Option<String> {
    let commands = Cli::command();
    let similar = |commands: &Command, typos: usize| {
        let mut names = commands.get_subcommands().map(Command::get_name);
        let name = names.find(|name| strsim::damerau_levenshtein(word, name) <= typos);
        name.map(str::to_string)
    };
    if let Some(command) = similar(&commands, 2) {
        return Some(own_command(&format!("{command} …")));
    }
    let for_mazes = commands.find_subcommand("mazes").and_then(|mazes| similar(mazes, 1));
    if let Some(command) = for_mazes {
        return Some(own_command(&format!("mazes {command} …")));
    }
    let maze = Collection::at(None).ok()?.select(word).ok();
    maze.map(|_| own_command(&format!("--maze {word}")))
}
