//! Arguments that several commands share, usage errors, and the result of a command.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bytesize::ByteSize;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args};
use mmsim_fastrun::Vehicle;
use mmsim_maze::{Cell, MazeSize, Misreadings};
use mmsim_recording::NewMessages;
use mmsim_solvers::Tolerance;

use crate::recordings::messages_unless;
use crate::vehicle::{parse_vehicle, timing_vehicle_help};

/// The default pace of a mouse that somebody watches, in milliseconds per step.
pub(crate) const WATCHED_PACE_MS: u64 = 50;

/// Options that control the amount of output on stderr.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct VerbosityArgs {
    /// Print only errors and warnings
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Print more; -vv includes every refused request and every connection
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub(crate) verbose: u8,
}

#[derive(Debug, Default, PartialEq, Args)]
pub(crate) struct ViewerArgs {
    /// Port of the viewer page; 0 picks a free port [default: 6575; if port 6575 is in use, a free
    /// port with --open, else no page]
    #[arg(long, value_name = "PORT")]
    pub(crate) viewer_port: Option<u16>,
    /// Do not serve the viewer page
    #[arg(long, conflicts_with_all = ["viewer_port", "open"])]
    pub(crate) no_viewer: bool,
    /// Open the viewer page in a browser
    #[arg(long)]
    pub(crate) open: bool,
    #[arg(long, value_name = "NAME|FILE", value_parser = parse_vehicle, help = timing_vehicle_help())]
    pub(crate) vehicle: Vec<Vehicle>,
}

/// The group of `--record`. Unlike an argument, clap requires a group even beside arguments that
/// conflict with it.
pub(crate) const RECORDING: &str = "recording";

/// Options for each recording that `--record` writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Args)]
pub(crate) struct RecordingArgs {
    /// Record only the states, without the JSON channels for Foxglove and other tools
    #[arg(long, requires = RECORDING)]
    states_only: bool,
    /// Limit each recording to SIZE before compression, such as 500MB or 2GiB; further states are
    /// not recorded [default: a tenth of the free disk space, at most 4GiB]
    #[arg(long, value_name = "SIZE", requires = RECORDING, value_parser = parse_bytes)]
    record_limit: Option<ByteSize>,
}

impl RecordingArgs {
    /// Returns the messages for other tools, unless the recording must contain only the states.
    pub(crate) fn messages(self) -> Option<NewMessages> {
        messages_unless(self.states_only)
    }

    /// Returns the maximum size in bytes, or `None` for the default.
    pub(crate) fn limit(self) -> Option<u64> {
        self.record_limit.map(|limit| limit.as_u64())
    }
}

/// Options for storing the states that clients send.
#[derive(Debug, Default, PartialEq, Eq, Args)]
pub(crate) struct RetentionArgs {
    /// Record each run, from reset to reset, to a new file in DIR; view it with `mmsim replay`
    #[arg(long, value_name = "DIR", group = RECORDING)]
    pub(crate) record: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// Limit the history to MIB mebibytes; further states are refused until reset. One mebibyte
    /// holds about 100,000 states. Recordings opened in the viewer have a separate limit of MIB
    /// mebibytes [default: half of the free memory for the history, a quarter for recordings]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) history_limit: Option<u64>,
}

/// Options of commands that read recordings.
#[derive(Debug, Default, Args)]
pub(crate) struct ReadingArgs {
    /// Limit the memory for open recordings to MIB mebibytes; larger recordings are refused. One
    /// mebibyte holds about 100,000 states [default: half of the free memory]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) history_limit: Option<u64>,
}

/// Options for wrong wall readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Args)]
pub(crate) struct MisreadArgs {
    /// Misread walls with probability P, such as 1% or 0.01. Outer walls are never misread
    #[arg(long, value_name = "P", value_parser = parse_probability)]
    misread: Option<f64>,
    /// Misread the same walls each time, instead of deciding anew for each reading
    #[arg(long, requires = "misread")]
    misread_fixed: bool,
    /// Random seed for wrong readings; the same seed gives the same wrong readings
    #[arg(long, value_name = "N", default_value_t = 1, requires = "misread")]
    misread_seed: u64,
}

impl MisreadArgs {
    /// Returns the misreadings.
    pub(crate) fn misreadings(self) -> Misreadings {
        Misreadings {
            probability: self.misread.unwrap_or(0.0),
            seed: self.misread_seed,
            are_fixed: self.misread_fixed,
        }
    }
}

/// Options for serving a maze.
#[derive(Debug, Args)]
pub(crate) struct ServerArgs {
    /// Port to listen on; 0 picks a free port [default: 6574]
    #[arg(short, long)]
    pub(crate) port: Option<u16>,
    #[command(flatten)]
    pub(crate) misread: MisreadArgs,
    #[command(flatten)]
    pub(crate) retention: RetentionArgs,
    #[command(flatten)]
    pub(crate) viewer: ViewerArgs,
}

/// Options that define what a mouse knows before its first step: the maze size and the goal.
#[derive(Debug, Args)]
pub(crate) struct KnownMazeArgs {
    /// Width and height of the maze in cells [default: 16x16, or the server's size with --goal
    /// server]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<MazeSize>,
    /// Goal cells, such as `7,7 8,7`, or `server` to ask the server (mmsim only) [default: the
    /// central cells]
    #[arg(long, value_name = "x,y|server", num_args = 1.., value_parser = parse_goal)]
    pub(crate) goal: Vec<Option<Cell>>,
}

/// Returns an argument parser that accepts the names of `values` and returns the named value.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    values: impl IntoIterator<Item = T>,
    describe: fn(T) -> PossibleValue,
) -> impl TypedValueParser<Value = T> {
    let values: Vec<T> = values.into_iter().collect();
    PossibleValuesParser::new(values.iter().map(|&value| describe(value))).try_map(move |name| {
        let named = values.iter().find(|&&value| describe(value).get_name() == name);
        named.copied().ok_or("unknown name")
    })
}

/// Returns the extension of a path in lower case.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Formats the error for an output file with an unexpected extension.
pub(crate) fn wrong_extension(expected: &str, found: &str) -> String {
    match found {
        "" => format!("expected a file ending in {expected}"),
        _ => format!("expected a file ending in {expected}, found .{found}"),
    }
}

/// Returns the selected values, each once. One argument may select several values.
pub(crate) fn each_once<T: Copy + PartialEq>(selected: &[&[T]]) -> Vec<T> {
    let mut values = Vec::new();
    for value in selected.concat() {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

/// Parses two numbers with `separator` between them.
fn parse_pair<N: std::str::FromStr>(text: &str, separator: char) -> Option<(N, N)> {
    let (first, second) = text.split_once(separator)?;
    Some((first.trim().parse().ok()?, second.trim().parse().ok()?))
}

pub(crate) fn parse_size(text: &str) -> Result<MazeSize, String> {
    let (width, height) = parse_pair(&text.to_lowercase(), 'x')
        .ok_or_else(|| "expected a width and a height such as 16x16".to_string())?;
    MazeSize::new(width, height).map_err(|error| error.to_string())
}

/// Parses a positive number of seconds.
pub(crate) fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    let seconds = seconds.filter(|seconds| !seconds.is_zero());
    seconds.ok_or_else(|| "expected a number of seconds greater than 0".into())
}

/// Parses a probability from 0 to 1, or from 0% to 100%.
pub(crate) fn parse_probability(text: &str) -> Result<f64, &'static str> {
    let ratio = text.parse().map(Tolerance::ratio);
    ratio.map_err(|_| "expected a probability from 0 to 100%, such as 1% or 0.01")
}

/// Parses a positive number of bytes, such as `2GiB`.
fn parse_bytes(text: &str) -> Result<ByteSize, String> {
    let bytes = text.parse().ok().filter(|&bytes| bytes > ByteSize(0));
    bytes.ok_or_else(|| "expected a size greater than 0, such as 500MB or 2GiB".into())
}

/// Parses a goal cell. Returns `None` for `server`.
fn parse_goal(text: &str) -> Result<Option<Cell>, String> {
    if text == "server" {
        return Ok(None);
    }
    let (x, y) = parse_pair(text, ',').ok_or("expected `server` or a cell such as 7,7")?;
    Ok(Some(Cell::new(x, y)))
}

/// The result of a command. `Ok(true)` stands for success, `Ok(false)` for a failure that the
/// command has already reported, and `Err` for an error that is still to be reported.
pub(crate) type CommandResult = Result<bool, Box<dyn Error>>;

/// A command-line error that clap does not detect. The process exits with code 2.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(crate) struct UsageError {
    /// The path of the command, such as `mazes convert`, or an empty string for `mmsim` itself.
    pub(crate) command: &'static str,
    pub(crate) message: String,
}

impl UsageError {
    pub(crate) fn new(command: &'static str, message: impl Into<String>) -> Self {
        Self { command, message: message.into() }
    }

    /// Returns the error for an option that takes one thing, such as a maze, where `found` are given.
    pub(crate) fn not_one(command: &'static str, option: &str, thing: &str, found: usize) -> Self {
        Self::new(command, format!("{option} takes one {thing}, found {found}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_seconds() {
        assert_eq!(parse_seconds("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "1e99", "soon"].map(parse_seconds).iter().all(Result::is_err));
    }

    #[test]
    fn parses_probabilities() {
        assert_eq!(
            ["0.1%", "0.01", "1", "100%"].map(parse_probability),
            [Ok(0.001), Ok(0.01), Ok(1.0), Ok(1.0)]
        );
        assert!(["2", "-1%", "nan", "often"].map(parse_probability).iter().all(Result::is_err));
    }

    #[test]
    fn parses_bytes() {
        assert_eq!(parse_bytes("500MB"), Ok(ByteSize(500_000_000)));
        assert_eq!(parse_bytes("2 GiB"), Ok(ByteSize(2 << 30)));
        assert!(["0", "-1", "1XB", "much"].map(parse_bytes).iter().all(Result::is_err));
    }

    #[test]
    fn parses_sizes_and_goals() {
        assert_eq!(parse_size("21X9"), Ok(MazeSize::new(21, 9).unwrap()));
        assert!(parse_size("33x1").unwrap_err().contains("found 33x1"));
        assert!(parse_size("16").is_err());
        assert_eq!(parse_goal("7, 8"), Ok(Some(Cell::new(7, 8))));
        assert_eq!(parse_goal("server"), Ok(None));
        assert!(parse_goal("7").is_err() && parse_goal("7,256").is_err());
    }
}
