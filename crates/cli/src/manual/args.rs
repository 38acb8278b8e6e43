//! Arguments of `mmsim completions` and `mmsim man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

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
    pub(crate) shell: Shell,
}

#[derive(Debug, Args)]
#[command(after_help = AFTER_MAN_HELP)]
pub(crate) struct ManArgs {
    /// Command to document, such as `solve` or `mazes check` [default: mmsim itself]
    #[arg(conflicts_with = "output")]
    pub(crate) command: Vec<String>,
    /// Write the manual pages for all commands to DIR
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}
