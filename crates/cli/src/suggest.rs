//! "Did you mean" suggestions.

use clap::Command;

use crate::output::own_command;
use crate::selection::Collection;

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
