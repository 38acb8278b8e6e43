//! Defines and parses the command line.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use mmsim_maze::Escaped;

use crate::args::{UsageError, VerbosityArgs};
use crate::check_server::CheckServerArgs;
use crate::compare::CompareArgs;
use crate::contest::ContestArgs;
use crate::demo::DemoArgs;
use crate::export::ExportArgs;
use crate::fast_run::FastRunArgs;
use crate::manual::{CompletionsArgs, ManArgs};
use crate::mazes::MazesArgs;
use crate::replay::ReplayArgs;
use crate::run::RunArgs;
use crate::selection::Selection;
use crate::serve::{ServeArgs, suggest};
use crate::solve::SolveArgs;
use crate::trial::args::TrialArgs;

/// A micromouse maze simulator. Without a command, mmsim serves a maze to search clients. It
/// reports only the walls around the mouse and stores every state that a client sends.
#[derive(Debug, Parser)]
#[command(
    // Otherwise it has the extension .exe on Windows.
    bin_name = "mmsim",
    version,
    long_version = env!("MMSIM_LONG_VERSION"),
    args_conflicts_with_subcommands = true,
    after_help = AFTER_HELP
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) serve: ServeArgs,
    #[command(flatten)]
    pub(crate) verbosity: VerbosityArgs,
}

const AFTER_HELP: &str = "\
Examples:
  mmsim demo                           watch a flood-fill mouse search a maze
  mmsim                                serve a maze on port 6574 for your own mouse
  mmsim harbour                        serve the maze of this name
  mmsim mazes/ apec 2018               serve a maze of your own collection
  mmsim solve weight-increment         run a bundled strategy against a simulator
  mmsim export run.mcap -o run.gif     animate a recorded search
  mmsim export run.mcap -o run.html    save a recorded search as a web page
  mmsim compare mazes/                 compare mice in many mazes
  mmsim fast-run harbour               time the fastest run through a maze
  mmsim contest mazes/                 let mice compete under the rules of a contest
  mmsim trial mazes/                   let a robot explore each maze and race in it
  mmsim run --open ./my-mouse          run and watch your own mouse
  mmsim check-server                   check that a server follows the protocol
  mmsim mazes fetch                    download real contest mazes
  mmsim mazes check my-maze.txt        check a maze file for errors
  mmsim completions bash               generate shell completions

See `mmsim COMMAND --help` for the options and examples of a command, and `mmsim man` for a manual
page.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a bundled strategy against a simulator
    Solve(SolveArgs),
    /// Serve a maze and run a flood-fill mouse in it
    Demo(DemoArgs),
    /// Show the maze and one state of a recording
    Replay(ReplayArgs),
    /// Draw a maze or a recording, write a recording as a web page, or pack it again
    Export(ExportArgs),
    /// Compare bundled strategies and your own mice in many mazes
    Compare(CompareArgs),
    /// Find the fastest run through a maze, in seconds
    FastRun(FastRunArgs),
    /// Let strategies and your own mice compete under the rules of a contest
    Contest(ContestArgs),
    /// Run robots in the two-run trial: explore a maze, then race
    Trial(TrialArgs),
    /// List, show, check, convert, fetch and generate mazes
    Mazes(MazesArgs),
    /// Run your own mouse: a mouse for mms, a client of the protocol, or a robot
    Run(RunArgs),
    /// Check that a server follows the protocol
    CheckServer(CheckServerArgs),
    /// Generate shell completions
    Completions(CompletionsArgs),
    /// Print or write manual pages
    Man(ManArgs),
}

impl Cli {
    /// Parses the command line. Exits if the command line is invalid or asks for help or the
    /// version.
    pub(crate) fn parse_or_exit() -> Self {
        let arguments = verbosity_after_command(env::args_os().collect());
        let parsed = Self::try_parse_from(&arguments);
        let may_have_options_first = match &parsed {
            // The command may have been parsed as a maze.
            Ok(cli) => cli.serve.maze.first().is_some_and(|word| !Path::new(word).exists()),
            Err(error) => error.use_stderr(),
        };
        if may_have_options_first && let Some(name) = command_after_options(&arguments) {
            let name = name.display();
            let message =
                format!("options of {name} must come after {name} (see `mmsim {name} --help`)");
            exit_with_usage(&UsageError::new("", message));
        }
        parsed.unwrap_or_else(|error| exit_with(error, &arguments))
    }
}

/// Prints a usage error in clap's format and exits with code 2.
pub(crate) fn exit_with_usage(error: &UsageError) -> ! {
    let mut cli = Cli::command();
    cli.build();
    let mut names = error.command.split_whitespace();
    let command = names.try_fold(&cli, |command, name| command.find_subcommand(name)).cloned();
    command.unwrap_or(cli).error(ErrorKind::ValueValidation, Escaped(&error.message)).exit()
}

/// Prints the error, help or version that the parser returned, and exits.
fn exit_with(error: clap::Error, arguments: &[OsString]) -> ! {
    if error.use_stderr()
        && let Some(word) = unknown_word(arguments)
    {
        let hint = suggest(word, &Cli::command()).unwrap_or_default();
        let message = format!("no such command or maze: {word:?}{hint}");
        exit_with_usage(&UsageError::new("", message));
    }
    let missing = error.get(ContextKind::InvalidArg);
    if arguments.get(1).is_some_and(|word| word == "run")
        && matches!(missing, Some(ContextValue::Strings(names)) if names[..] == ["<COMMAND>..."])
    {
        let message = "no mouse to run (example: mmsim run --open ./my-mouse)";
        exit_with_usage(&UsageError::new("run", message));
    }
    if arguments.iter().take_while(|word| *word != "--").any(|word| word == "--published")
        && matches!(missing, Some(ContextValue::Strings(names)) if names[..] == ["<MAZE>..."])
    {
        let message = "no maze before --published (put each MAZE first, because all words after \
                       FILE are passed to the robot)";
        exit_with_usage(&UsageError::new("trial", message));
    }
    // The error may quote control characters from the command line.
    let escaped = arguments.iter().map(|argument| Escaped(argument.display()).to_string());
    Cli::try_parse_from(escaped).err().unwrap_or(error).exit()
}

/// Returns true if `name` is a command, including `help`, which clap adds.
fn is_command(name: &OsStr) -> bool {
    name == "help" || Cli::command().get_subcommands().any(|command| command.get_name() == name)
}

/// Returns the first command name in the arguments if all arguments before it are valid server
/// options.
fn command_after_options(arguments: &[OsString]) -> Option<&OsStr> {
    let mut names = arguments.iter().enumerate().skip(2);
    let (at, name) = names.find(|(_, name)| is_command(name))?;
    let before = Cli::try_parse_from(&arguments[..at]);
    let are_options = before.is_ok_and(|cli| cli.command.is_none() && cli.serve.maze.is_empty());
    are_options.then_some(name)
}

/// Returns the first argument if it is neither an option, a command nor a maze.
fn unknown_word(arguments: &[OsString]) -> Option<&str> {
    let word = arguments.get(1)?.to_str()?;
    let is_maze = || Selection::read(OsStr::new(word)).is_ok_and(|found| found.first().is_ok());
    (!word.starts_with('-') && !is_command(OsStr::new(word)) && !is_maze()).then_some(word)
}

/// Moves verbosity options after the command: `mmsim -q solve` becomes `mmsim solve -q`. If other
/// options come first, changes nothing, because a word such as `mazes` may then be the name of a
/// folder instead of a command.
fn verbosity_after_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let is_verbosity = |argument: &&OsString| {
        let short = argument.as_encoded_bytes().strip_prefix(b"-").unwrap_or_default();
        let is_short = !short.is_empty() && short.iter().all(|letter| b"qv".contains(letter));
        is_short || *argument == "--quiet" || *argument == "--verbose"
    };
    let count = arguments.iter().skip(1).take_while(is_verbosity).count();
    match arguments.get_mut(1..count + 2) {
        // `help` takes no options.
        Some([.., name]) if name == "help" => drop(arguments.drain(1..=count)),
        Some(until_command @ [.., _])
            if until_command.last().is_some_and(|name| is_command(name)) =>
        {
            until_command.rotate_right(1);
        }
        _ => {}
    }
    arguments
}

#[cfg(test)]
mod tests {
    use clap::Arg;

    use super::*;

    #[test]
    fn command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    /// Returns each command with the words before its arguments.
    fn commands(command: &clap::Command, words: &[String]) -> Vec<(clap::Command, Vec<String>)> {
        let below = |below: &clap::Command| {
            commands(below, &[words, &[below.get_name().to_string()]].concat())
        };
        let all = command.get_subcommands().filter(|below| below.get_name() != "help");
        [(command.clone(), words.to_vec())].into_iter().chain(all.flat_map(below)).collect()
    }

    /// Parses the words in an order that clap accepts: options, values, and the command after `--`.
    fn parse(command: &[String], arguments: &[&(Arg, String)]) -> Result<Cli, clap::Error> {
        let (options, values): (Vec<_>, Vec<_>) =
            arguments.iter().copied().partition(|(arg, _)| !arg.is_positional());
        let (last, values): (Vec<_>, Vec<_>) = values
            .into_iter()
            .partition(|(arg, _)| arg.is_last_set() || arg.is_trailing_var_arg_set());
        let word = |(_, word): &(Arg, String)| word.clone();
        let end = (!last.is_empty()).then(|| "--".to_string()).into_iter();
        let words = options.into_iter().map(word).chain(values.into_iter().map(word));
        Cli::try_parse_from(
            command.iter().cloned().chain(words).chain(end).chain(last.into_iter().map(word)),
        )
    }

    /// Returns an argument with a word that sets it to a value of its type.
    fn with_value(command: &[String], required: &[&(Arg, String)], arg: &Arg) -> (Arg, String) {
        const VALUES: [&str; 13] = [
            "1", "100", "7,7", "16x16", "0.1", "a.svg", "a.html", "ares", "a=b", "1,1", "1MB",
            "codes", "north",
        ];
        let possible: Vec<_> = arg.get_possible_values();
        let names = possible.iter().map(|value| value.get_name().to_string());
        let values = names.chain(VALUES.map(String::from));
        let is_invalid =
            |kind| matches!(kind, ErrorKind::ValueValidation | ErrorKind::InvalidValue);
        let name = arg.get_long().map(|name| format!("--{name}"));
        let word = |value: String| match &name {
            None => value,
            Some(name) if !arg.get_action().takes_values() => name.clone(),
            Some(name) => format!("{name}={value}"),
        };
        let mut all = values.map(|value| (arg.clone(), word(value)));
        let fits = |it: &(Arg, String)| {
            let parsed = parse(command, &[required, &[it]].concat());
            parsed.err().is_none_or(|error| !is_invalid(error.kind()))
        };
        all.find(fits).unwrap_or_else(|| panic!("{command:?}: no value for {}", arg.get_id()))
    }

    /// If an option requires another one, clap accepts the option alone beside an argument that
    /// conflicts with the other one. The option would then have no effect. Clap never does so if the
    /// other one is in a group and the option requires the group.
    #[test]
    fn no_argument_cancels_the_requirement_of_an_option() {
        let mut faults = Vec::new();
        let mut all = Cli::command();
        all.build();
        for (command, words) in commands(&all, &["mmsim".into()]) {
            let has_value = |arg: &&Arg| {
                !matches!(arg.get_id().as_str(), "help" | "version" | "quiet" | "verbose")
            };
            let (required, others): (Vec<_>, Vec<_>) =
                command.get_arguments().filter(has_value).partition(|arg| arg.is_required_set());
            let required: Vec<_> =
                required.into_iter().map(|arg| with_value(&words, &[], arg)).collect();
            let required: Vec<_> = required.iter().collect();
            let others: Vec<_> =
                others.into_iter().map(|arg| with_value(&words, &required, arg)).collect();
            for option in &others {
                let alone = parse(&words, &[&required[..], &[option]].concat());
                let Err(error) = alone else { continue };
                let Some(ContextValue::Strings(missing)) = error.get(ContextKind::InvalidArg)
                else {
                    continue;
                };
                for other in others.iter().filter(|other| other.0 != option.0) {
                    let name = match (other.0.get_long(), other.0.get_value_names()) {
                        (Some(name), _) => format!("--{name}"),
                        (None, Some([name, ..])) => name.to_string(),
                        (None, _) => continue,
                    };
                    let is_missing = missing.iter().any(|missing| missing.contains(&name));
                    let both = parse(&words, &[&required[..], &[option, other]].concat());
                    if both.is_ok() && !is_missing {
                        faults.push(format!("{} {} {}", words.join(" "), option.1, other.1));
                    }
                }
            }
        }
        assert!(faults.is_empty(), "accepted without effect:\n{}", faults.join("\n"));
    }

    #[test]
    fn help_has_no_line_that_is_wrapped() {
        // The width where there is no terminal.
        const WIDTH: usize = 100;
        let command = Cli::command();
        for command in command.get_subcommands().chain([&command]) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in help.lines() {
                assert!(line.len() <= WIDTH, "{}: {line}", command.get_name());
            }
        }
    }

    #[test]
    fn verbosity_may_precede_a_command() {
        let arranged = |line: &str| {
            let arguments = verbosity_after_command(line.split(' ').map(OsString::from).collect());
            arguments.join(OsStr::new(" ")).into_string().unwrap()
        };
        assert_eq!(arranged("mmsim -q solve swing"), "mmsim solve -q swing");
        assert_eq!(arranged("mmsim -vv --verbose mazes"), "mmsim mazes -vv --verbose");
        assert_eq!(arranged("mmsim -q -q help solve"), "mmsim help solve");
        for other in
            ["mmsim", "mmsim -q", "mmsim -q folder solve", "mmsim -qp 0 mazes", "mmsim - solve"]
        {
            assert_eq!(arranged(other), other);
        }
    }
}
