//! `mmsim completions` and `mmsim man`: what is known of the command line, for shells and for `man`.

use std::fs;
use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::Outcome;
use crate::args::{Cli, wrong_usage};
use crate::output::{print, say};

const AFTER_COMPLETIONS_HELP: &str = "\
Examples:
  eval \"$(mmsim completions bash)\"     in ~/.bashrc
  source <(mmsim completions zsh)        in ~/.zshrc, behind compinit
  mmsim completions fish | source        in ~/.config/fish/config.fish
  mmsim completions powershell | Out-String | Invoke-Expression     in $PROFILE";

const AFTER_MAN_HELP: &str = "\
Examples:
  mmsim man | man -l -                 read it
  mmsim man mazes check | man -l -     that of a command
  mmsim man -o ~/.local/share/man/man1    then `man mmsim` and `man mmsim-solve` find them";

#[derive(Debug, Args)]
#[command(after_help = AFTER_COMPLETIONS_HELP)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

#[derive(Debug, Args)]
#[command(after_help = AFTER_MAN_HELP)]
pub(crate) struct ManArgs {
    /// The command whose page is wanted, such as `solve` or `mazes check` [default: mmsim itself]
    #[arg(conflicts_with = "output")]
    command: Vec<String>,
    /// Write the pages of all commands into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

pub(crate) fn complete(args: &CompletionsArgs) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "mmsim", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(true)
}

pub(crate) fn run(args: &ManArgs) -> Outcome {
    let mut all = Cli::command().disable_help_subcommand(true);
    all.build();
    let Some(folder) = &args.output else {
        let mut command = &all;
        for name in &args.command {
            let Some(found) = command.find_subcommand(name) else {
                let of = command.get_bin_name().unwrap_or("mmsim");
                wrong_usage("man", &format!("expected a command of `{of}`, found {name:?}"));
            };
            command = found;
        }
        print(&page(command)?)?;
        return Ok(true);
    };
    let error = |error| format!("{}: cannot be written: {error}", folder.display());
    fs::create_dir_all(folder).map_err(error)?;
    let commands = with_commands_of(&all);
    for command in &commands {
        let path = folder.join(format!("{}.1", display_name(command)));
        fs::write(path, page(command)?).map_err(error)?;
    }
    say(format_args!("{} pages are in {}", commands.len(), folder.display()));
    Ok(true)
}

/// A command and all those below it.
fn with_commands_of(command: &Command) -> Vec<&Command> {
    let below = command.get_subcommands().flat_map(with_commands_of);
    [command].into_iter().chain(below).collect()
}

/// `mmsim-mazes-check` for `mmsim mazes check`.
fn display_name(command: &Command) -> &str {
    command.get_display_name().unwrap_or_else(|| command.get_name())
}

fn page(command: &Command) -> Result<String, Box<dyn std::error::Error>> {
    let mut page = Vec::new();
    let man = Man::new(command.clone()).title(display_name(command).to_uppercase());
    let man = man.source(concat!("mmsim ", env!("CARGO_PKG_VERSION")));
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    page.extend(synopsis(command).bytes());
    man.render_description_section(&mut page)?;
    if command.get_arguments().next().is_some() {
        man.render_options_section(&mut page)?;
    }
    if command.has_subcommands() {
        man.render_subcommands_section(&mut page)?;
    }
    if let Some(more) = command.get_after_help() {
        page.extend(as_it_stands(&more.to_string()).bytes());
    }
    Ok(String::from_utf8(page)?)
}

/// How the command is written: as its help says it.
fn synopsis(command: &Command) -> String {
    let usage = command.clone().render_usage().to_string();
    let lines = usage.strip_prefix("Usage:").unwrap_or(&usage).lines().map(str::trim);
    let lines: String = lines.map(escaped).collect();
    format!(".SH SYNOPSIS\n.nf\n{lines}.fi\n")
}

/// Text whose lines and columns stay, as the examples and tables below a help text need it.
fn as_it_stands(text: &str) -> String {
    let lines = text.strip_prefix("Examples:\n").unwrap_or(text).lines();
    let lines: String = lines.map(escaped).collect();
    format!(".SH EXAMPLES\n.nf\n{lines}.fi\n")
}

/// A line for `man`, with its end, to which a dot or an apostrophe at the beginning would be an instruction.
fn escaped(line: &str) -> String {
    format!("\\&{}\n", line.replace('\\', "\\e").replace('-', "\\-"))
}
