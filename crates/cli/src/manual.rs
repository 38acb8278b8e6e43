//! `mmsim completions` and `mmsim man`: shell completions and manual pages.

use std::fs;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::args::{CommandResult, UsageError};
use crate::output::{note, print};

const AFTER_COMPLETIONS_HELP: &str = "\
Examples:
  eval \"$(mmsim completions bash)\"     in ~/.bashrc
  source <(mmsim completions zsh)        in ~/.zshrc, after compinit
  mmsim completions fish | source        in ~/.config/fish/config.fish
  mmsim completions powershell | Out-String | Invoke-Expression     in $PROFILE";

const AFTER_MAN_HELP: &str = "\
Examples:
  mmsim man | man -l -                    read the manual page of mmsim
  mmsim man mazes check | man -l -        read the page of a command
  mmsim man -o ~/.local/share/man/man1    install all pages for `man mmsim`, `man mmsim-solve`, …";

#[derive(Debug, Args)]
#[command(after_help = AFTER_COMPLETIONS_HELP)]
pub(crate) struct CompletionsArgs {
    /// Shell to generate completions for
    shell: Shell,
}

#[derive(Debug, Args)]
#[command(after_help = AFTER_MAN_HELP)]
pub(crate) struct ManArgs {
    /// Command to document, such as `solve` or `mazes check` [default: mmsim itself]
    #[arg(conflicts_with = "output")]
    command: Vec<String>,
    /// Write the manual pages for all commands to DIR
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Prints shell completions for `mmsim`.
pub(crate) fn complete(args: &CompletionsArgs, mmsim: &mut Command) -> CommandResult {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, mmsim, "mmsim", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(true)
}

/// Prints one manual page of `mmsim`, or writes all pages to a folder.
pub(crate) fn run(args: &ManArgs, mmsim: Command) -> CommandResult {
    let mut all = mmsim.disable_help_subcommand(true);
    all.build();
    let Some(folder) = &args.output else {
        let mut command = &all;
        for name in &args.command {
            let Some(found) = command.find_subcommand(name) else {
                let parent = command.get_bin_name().unwrap_or("mmsim");
                let message = format!("`{parent}` has no command {name:?}");
                return Err(UsageError::new("man", message).into());
            };
            command = found;
        }
        print(&page(command)?)?;
        return Ok(true);
    };
    let error = |error| format!("cannot write to {}: {error}", folder.display());
    fs::create_dir_all(folder).map_err(error)?;
    let commands = with_subcommands(&all);
    for command in &commands {
        let path = folder.join(format!("{}.1", display_name(command)));
        fs::write(path, page(command)?).map_err(error)?;
    }
    note(format_args!("wrote {} pages to {}", commands.len(), folder.display()));
    Ok(true)
}

/// Returns a command and all its subcommands, recursively.
fn with_subcommands(command: &Command) -> Vec<&Command> {
    let below = command.get_subcommands().flat_map(with_subcommands);
    [command].into_iter().chain(below).collect()
}

/// Returns the full name of a command, such as `mmsim-mazes-check`.
fn display_name(command: &Command) -> &str {
    command.get_display_name().unwrap_or_else(|| command.get_name())
}

fn page(command: &Command) -> Result<String, Box<dyn std::error::Error>> {
    let mut page = Vec::new();
    let man = Man::new(command.clone()).title(display_name(command).to_uppercase());
    let man = man.source(concat!("mmsim ", env!("CARGO_PKG_VERSION")));
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    let usage = command.clone().render_usage().to_string().replace("\n       ", "\n");
    page.extend(section("SYNOPSIS", "Usage: ", &usage).bytes());
    man.render_description_section(&mut page)?;
    if command.get_arguments().next().is_some() {
        man.render_options_section(&mut page)?;
    }
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    if let Some(more) = command.get_after_help() {
        page.extend(section("EXAMPLES", "Examples:\n", &more.to_string()).bytes());
    }
    Ok(String::from_utf8(page)?)
}

/// Formats `text` as the section `name` of a manual page. Removes `title` from the start of the
/// text, if present. Keeps line breaks and the alignment of columns.
fn section(name: &str, title: &str, text: &str) -> String {
    let lines: String = text.strip_prefix(title).unwrap_or(text).lines().map(escaped).collect();
    format!(".SH {name}\n.nf\n{lines}.fi\n")
}

/// Escapes a line for `man`, which interprets a leading dot or apostrophe as a command.
fn escaped(line: &str) -> String {
    format!("\\&{}\n", line.replace('\\', "\\e").replace('-', "\\-"))
}
