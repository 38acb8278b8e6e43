//! The command line.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::PossibleValue;
use clap::error::ErrorKind;
use clap::{ArgAction, Args, CommandFactory, Parser, Subcommand, ValueEnum};
use mmsim_maze::{Cell, Escaped, MazeSize};
use mmsim_protocol::DEFAULT_PORT;
use mmsim_solvers::BundledStrategy;

use crate::compare::CompareArgs;
use crate::manual::{CompletionsArgs, ManArgs};
use crate::mazes::MazesArgs;
use crate::meant::meant;
use crate::mms::MmsArgs;
use crate::render::RenderArgs;
use crate::trial::TrialArgs;

/// A micromouse maze simulator. Without a command it serves a maze: it tells a search client only
/// the walls around the mouse, and keeps every state that the client reports.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) serve: ServeArgs,
    #[command(flatten)]
    pub(crate) talk: TalkArgs,
}

/// How much a command says on stderr.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct TalkArgs {
    /// Say nothing but what went wrong
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Say more; with -vv every refused request and every connection too
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub(crate) verbose: u8,
}

const AFTER_HELP: &str = "\
Examples:
  mmsim demo                           watch a flood-fill mouse search a maze
  mmsim                                serve a maze on port 6574 for your own mouse
  mmsim mazes/ --maze \"apec 2018\"      serve a maze of your own collection
  mmsim solve weight-increment         run a bundled mouse against a simulator
  mmsim render run.mcap -o run.gif     make an animation of a recorded search
  mmsim compare mazes/                 let all bundled mice search each maze, as a table
  mmsim trial mazes/                   let a robot explore and race in each maze, and score it
  mmsim mms --open -- ./my-mouse       run a mouse for the simulator mms, and watch it
  mmsim mazes fetch                    download real contest mazes
  mmsim mazes check my-maze.txt        see whether a maze file is in order
  mmsim completions bash               let the shell complete all this

`mmsim COMMAND --help` has examples and all options of a command, `mmsim man` the same as a page.";

impl Cli {
    /// What the command line says.
    pub(crate) fn read() -> Self {
        let arguments = talk_behind_command(env::args_os().collect());
        Self::try_parse_from(&arguments).unwrap_or_else(|error| {
            // Help and version come as errors, too.
            let is_wrong = error.use_stderr();
            if let Some(name) = command_behind_options(&arguments).filter(|_| is_wrong) {
                options_before(name);
            }
            if let Some(word) = unknown_word(&arguments).filter(|_| is_wrong) {
                let was = meant(word).map(|meant| format!("; was {meant} meant?"));
                let expected = "expected a command, or a file or folder of mazes";
                wrong_usage("", &format!("{expected}, found {word:?}{}", was.unwrap_or_default()));
            }
            // Of the command line it may quote what a terminal would obey.
            let escaped = arguments.iter().map(|argument| Escaped(argument.display()).to_string());
            Self::try_parse_from(escaped).err().unwrap_or(error).exit()
        })
    }

    /// Whether there is a command of this name; `help` is one, which clap adds.
    pub(crate) fn has_command(name: &OsStr) -> bool {
        name == "help"
            || Self::command().get_subcommands().any(|command| command.get_name() == name)
    }
}

/// Ends the program: options of the server stand before this command, to which they mean nothing.
pub(crate) fn options_before(command: &OsStr) -> ! {
    let name = command.display();
    let expected = format!("options of a command after it, as in `mmsim {name} --help`");
    wrong_usage("", &format!("expected {expected}, found some before it"));
}

/// The command behind options of the server, if there is one.
fn command_behind_options(arguments: &[OsString]) -> Option<&OsStr> {
    let mut names = arguments.iter().enumerate().skip(2);
    let (at, name) = names.find(|(_, name)| Cli::has_command(name))?;
    let are_options = Cli::try_parse_from(&arguments[..at]).is_ok_and(|cli| cli.command.is_none());
    are_options.then_some(name)
}

/// The first word, if it is neither a command nor a path.
fn unknown_word(arguments: &[OsString]) -> Option<&str> {
    let word = arguments.get(1)?.to_str()?;
    (!word.starts_with('-') && !Cli::has_command(OsStr::new(word)) && !Path::new(word).exists())
        .then_some(word)
}

/// `mmsim -q solve` as `mmsim solve -q`. What stands behind any other option is no command but a
/// folder, which may be called `mazes`.
fn talk_behind_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let is_talk = |argument: &&OsString| {
        let short = argument.as_encoded_bytes().strip_prefix(b"-").unwrap_or_default();
        let is_short = !short.is_empty() && short.iter().all(|letter| b"qv".contains(letter));
        is_short || *argument == "--quiet" || *argument == "--verbose"
    };
    let talk = arguments.iter().skip(1).take_while(is_talk).count();
    match arguments.get_mut(1..talk + 2) {
        // It takes no options.
        Some([.., name]) if name == "help" => drop(arguments.drain(1..=talk)),
        Some(until_command @ [.., _])
            if until_command.last().is_some_and(|name| Cli::has_command(name)) =>
        {
            until_command.rotate_right(1);
        }
        _ => {}
    }
    arguments
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a bundled strategy against a simulator, this one or the reference one.
    Solve(SolveArgs),
    /// Serve a maze and let a flood-fill mouse search it, all in one.
    Demo(DemoArgs),
    /// Show a recording: the maze, and any state of the search.
    Replay(ReplayArgs),
    /// Draw a maze or a recording into a file: SVG, PNG or animated GIF.
    Render(RenderArgs),
    /// Compare the bundled strategies in whole collections of mazes.
    Compare(CompareArgs),
    /// Let robots explore mazes and race through them: the two-run trial.
    Trial(TrialArgs),
    /// List, show, check and convert mazes; fetch a collection, generate new ones.
    Mazes(MazesArgs),
    /// Run a mouse that was written for the simulator mms.
    Mms(MmsArgs),
    /// Print what lets a shell complete commands, options and their values.
    Completions(CompletionsArgs),
    /// Print the manual page of this command or another, or write those of all.
    Man(ManArgs),
}

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// A maze file, or a folder that is searched with its subfolders [default: ~/.mmsim where
    /// that exists, else the bundled mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// The host name or address to listen on, * for all of this machine's
    #[arg(short = 'H', long, default_value = "127.0.0.1")]
    pub(crate) host: String,
    /// The port to listen on, 0 for any that is free
    #[arg(short, long, default_value_t = DEFAULT_PORT)]
    pub(crate) port: u16,
    #[command(flatten)]
    pub(crate) maze: MazeArg,
    #[command(flatten)]
    pub(crate) keep: KeepArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
    /// Print a JSON object once it serves: the address, that of the page, what `info` says of the
    /// maze
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ViewerArgs {
    /// The port of the page on which a browser shows the search, 0 for any that is free [default:
    /// 6575, and no page if that is taken]
    #[arg(long, value_name = "PORT")]
    pub(crate) viewer_port: Option<u16>,
    /// Serve no page
    #[arg(long, conflicts_with_all = ["viewer_port", "open"])]
    pub(crate) no_viewer: bool,
    /// Open the page in a browser
    #[arg(long)]
    pub(crate) open: bool,
}

#[derive(Debug, Default, Args)]
pub(crate) struct KeepArgs {
    /// Record each simulation, from reset to reset, into a file of its own in this folder; `mmsim
    /// replay` reads it
    #[arg(long, value_name = "DIR")]
    pub(crate) record: Option<PathBuf>,
    /// Limit the history to MIB mebibytes, about 100,000 states each, and refuse further states until
    /// reset; the recordings that are open on the page may take as much again [default: half of the
    /// free memory, for recordings a quarter]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) history_limit: Option<u64>,
}

/// What a command that reads recordings may hold in memory.
#[derive(Debug, Args)]
pub(crate) struct ReadingArgs {
    /// Limit the memory for open recordings to MIB mebibytes, about 100,000 states each, and refuse
    /// to open larger ones [default: half of the free memory]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) history_limit: Option<u64>,
}

#[derive(Debug, Args)]
pub(crate) struct MazeArg {
    /// Serve the first maze whose path holds all these words, in any case [default: the first
    /// maze whose goal can be reached]
    #[arg(long = "maze", value_name = "WORDS")]
    pub(crate) words: Vec<String>,
}

#[derive(Debug, Args)]
#[command(override_usage = "mmsim solve <STRATEGY> [OPTIONS]")]
pub(crate) struct SolveArgs {
    /// The strategy
    pub(crate) strategy: Strategy,
    /// Where the simulator listens, as tcp://HOST:PORT; it may start later
    #[arg(long, value_name = "ENDPOINT", default_value_t = format!("tcp://127.0.0.1:{DEFAULT_PORT}"))]
    pub(crate) connect: String,
    #[command(flatten)]
    pub(crate) told: ToldArgs,
    /// Give up after sending this many states, one more than the steps between them [default: 1000;
    /// for swing and shortest-path-search, which explore the maze and come back first, 10000]
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_steps: Option<u32>,
    /// Wait this long after each step; a terminal shows the mouse on its way then
    #[arg(long, value_name = "MS", default_value_t = 0)]
    pub(crate) pace: u64,
    /// Record the states that are sent into this new file; `mmsim replay` reads it
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Give up when a reply takes longer, in seconds [default: wait for the simulator to start
    /// for ever, then 10 for each reply]
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    pub(crate) timeout: Option<Duration>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// What a mouse is told of the maze of a simulator.
#[derive(Debug, Args)]
pub(crate) struct ToldArgs {
    /// Cells of the maze from west to east and from south to north [default: 16x16, with --goal
    /// server what the server says]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<MazeSize>,
    /// The goal cells, such as 7,7 8,7, or `server` to ask the server, which only this project's
    /// server understands [default: the central cells]
    #[arg(long, value_name = "x,y|server", num_args = 1.., value_parser = parse_goal)]
    pub(crate) goal: Vec<Goal>,
}

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// A maze file, or a folder that is searched with its subfolders [default: ~/.mmsim where
    /// that exists, else the bundled mazes]
    pub(crate) mazes: Option<PathBuf>,
    /// The port to listen on, 0 for any that is free
    #[arg(short, long, default_value_t = DEFAULT_PORT)]
    pub(crate) port: u16,
    #[command(flatten)]
    pub(crate) maze: MazeArg,
    #[command(flatten)]
    pub(crate) keep: KeepArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
    /// Wait this long after each step [default: 50 on a terminal, else 0]
    #[arg(long, value_name = "MS")]
    pub(crate) pace: Option<u64>,
    /// End after the search instead of serving on; there is no page then
    #[arg(long)]
    pub(crate) once: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// The recording; one that was cut off in a crash is shown as far as it is whole
    pub(crate) file: PathBuf,
    /// Show the state with this number; the first has 0, so that it is the number of steps before
    /// it [default: the last one]
    #[arg(long, value_name = "N")]
    pub(crate) at: Option<usize>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Show it in a browser, until Ctrl-C
    #[arg(long, conflicts_with_all = ["at", "json"])]
    pub(crate) serve: bool,
    /// The port of the page, 0 for any that is free [default: 6575]
    #[arg(long, value_name = "PORT", requires = "serve")]
    pub(crate) viewer_port: Option<u16>,
    /// Open the page in a browser
    #[arg(long, requires = "serve")]
    pub(crate) open: bool,
}

/// A bundled strategy, as a value of the command line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strategy(pub(crate) BundledStrategy);

impl ValueEnum for Strategy {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [Strategy; BundledStrategy::ALL.len()] = {
            let mut all = [Strategy(BundledStrategy::FloodFill); BundledStrategy::ALL.len()];
            let mut index = 0;
            while index < all.len() {
                all[index] = Strategy(BundledStrategy::ALL[index]);
                index += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.about()))
    }
}

/// Where the mouse shall go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Goal {
    /// To this cell, among others.
    Cell(Cell),
    /// Where the server says.
    Server,
}

/// Ends one of the commands as any other mistake on the command line does.
pub(crate) fn wrong_usage(command: &str, message: &str) -> ! {
    let mut cli = Cli::command();
    cli.build();
    let command = cli.find_subcommand(command).cloned();
    command.unwrap_or(cli).error(ErrorKind::ValueValidation, Escaped(message)).exit()
}

/// Two numbers parted by a character.
fn parse_pair<N: std::str::FromStr>(text: &str, between: char) -> Option<(N, N)> {
    let (first, second) = text.split_once(between)?;
    Some((first.trim().parse().ok()?, second.trim().parse().ok()?))
}

pub(crate) fn parse_size(text: &str) -> Result<MazeSize, String> {
    let (width, height) = parse_pair(&text.to_lowercase(), 'x')
        .ok_or_else(|| "expected a width and a height such as 16x16".to_string())?;
    MazeSize::new(width, height).map_err(|error| error.to_string())
}

fn parse_goal(text: &str) -> Result<Goal, String> {
    if text == "server" {
        return Ok(Goal::Server);
    }
    let (x, y) = parse_pair(text, ',').ok_or("expected a cell such as 7,7, or server")?;
    Ok(Goal::Cell(Cell::new(x, y)))
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.filter(|seconds| !seconds.is_zero()).ok_or("expected seconds, more than 0".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn how_much_is_said_may_stand_before_a_command() {
        let arranged = |line: &str| {
            let arguments = talk_behind_command(line.split(' ').map(OsString::from).collect());
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

    #[test]
    fn sizes_goals_and_seconds_are_read() {
        assert_eq!(parse_size("21X9"), Ok(MazeSize::new(21, 9).unwrap()));
        assert!(parse_size("33x1").unwrap_err().contains("found 33x1"));
        assert!(parse_size("16").is_err());
        assert_eq!(parse_goal("7, 8"), Ok(Goal::Cell(Cell::new(7, 8))));
        assert_eq!(parse_goal("server"), Ok(Goal::Server));
        assert!(parse_goal("7").is_err() && parse_goal("7,256").is_err());
        assert_eq!(parse_seconds("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "1e99", "soon"].map(parse_seconds).iter().all(Result::is_err));
    }
}
