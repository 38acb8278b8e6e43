//! "Did you mean" suggestions.

use clap::Command;

use crate::output::own_command;
use crate::selection::Collection;

/// Suggests a command line instead of `mmsim WORD`: a command with a similar name, a subcommand of
/// `mmsim mazes`, or `--maze` if a maze has this name.
pub(crate) fn suggest(word: &str, commands: &Command) -> Option<String> {
    let similar = |commands: &Command, typos: usize| {
        let mut names = commands.get_subcommands().map(Command::get_name);
        let name = names.find(|name| strsim::damerau_levenshtein(word, name) <= typos);
        name.map(str::to_string)
    };
    if let Some(command) = similar(commands, 2) {
        return Some(own_command(&format!("{command} …")));
    }
    let for_mazes = commands.find_subcommand("mazes").and_then(|mazes| similar(mazes, 1));
    if let Some(command) = for_mazes {
        return Some(own_command(&format!("mazes {command} …")));
    }
    let maze = Collection::at(None).ok()?.select(word).ok();
    maze.map(|_| own_command(&format!("--maze {word}")))
}
