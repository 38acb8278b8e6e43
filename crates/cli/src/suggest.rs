//! "Did you mean" suggestions.

use clap::Command;

use crate::output::own_command;
use crate::selection::Collection;

/// Returns a hint for an error about an unknown `mmsim WORD`. It suggests a command with a similar
/// name, a subcommand of `mmsim mazes`, or `--maze` if a maze has this name.
pub(crate) fn suggest(word: &str, commands: &Command) -> Option<String> {
    let similar = |commands: &Command, typos: usize| {
        let mut names = commands.get_subcommands().map(Command::get_name);
        let name = names.find(|name| strsim::damerau_levenshtein(word, name) <= typos);
        name.map(str::to_string)
    };
    let for_mazes = || Some(format!("mazes {}", similar(commands.find_subcommand("mazes")?, 1)?));
    let arguments = match similar(commands, 2).or_else(for_mazes) {
        Some(command) => format!("{command} …"),
        None => {
            Collection::at(None).ok()?.select(word).ok()?;
            format!("--maze {word}")
        }
    };
    Some(format!(" (did you mean {}?)", own_command(&arguments)))
}
