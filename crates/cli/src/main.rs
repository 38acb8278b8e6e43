//! `mmsim`, a micromouse maze simulator: serves mazes to search clients, runs bundled strategies
//! against a simulator and mice written for another one, compares them, and puts robots on the two-run
//! trial.
#![forbid(unsafe_code)]

mod args;
mod compare;
mod demo;
mod embedded;
mod given;
mod grid;
mod hosting;
mod interrupt;
mod keep;
mod manual;
mod mazes;
mod meant;
mod memory;
mod mms;
mod output;
mod parallel;
mod recorded;
mod render;
mod replay;
mod screen;
mod selection;
mod serve;
mod solve;
mod stderr;
mod trial;
mod watching;

use std::env;
use std::error::Error;
use std::fmt::{self, Debug};
use std::io::{self, IsTerminal};
use std::process::{self, ExitCode};

use args::{Cli, Command, TalkArgs};
use mmsim_maze::Escaped;
use output::complain;
use stderr::Stderr;
use tracing::field::Field;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::field::MakeExt as _;
use tracing_subscriber::fmt::format::{Writer, debug_fn};

/// Whether the work was done: the goal reached, every maze valid. An error says why it could not
/// even be tried.
type Outcome = Result<bool, Box<dyn Error>>;

fn main() -> ExitCode {
    outlive_file_size_limit();
    let cli = Cli::read();
    listen_to(cli.talk);
    let outcome = match cli.command {
        None => serve::run(&cli.serve),
        Some(Command::Solve(args)) => solve::run(&args),
        Some(Command::Demo(args)) => demo::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Render(args)) => render::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Trial(args)) => trial::run(&args),
        Some(Command::Mazes(args)) => mazes::run(&args),
        // Other systems have exit codes beyond those of an `ExitCode`.
        Some(Command::Mms(args)) => mms::run(&args).map(|code| {
            stderr::flush();
            process::exit(code)
        }),
        Some(Command::Completions(args)) => manual::complete(&args),
        Some(Command::Man(args)) => manual::run(&args),
    };
    let code = match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            complain(format_args!("mmsim: {error}"));
            ExitCode::FAILURE
        }
    };
    stderr::flush();
    code
}

/// Lets a write beyond `ulimit -f` fail, as on a full disk, where the signal would end the process.
/// Unlike an ignored signal, a handler is not inherited by the commands that are run.
#[cfg(unix)]
fn outlive_file_size_limit() {
    let noticed = std::sync::Arc::<std::sync::atomic::AtomicBool>::default();
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, noticed);
}

#[cfg(not(unix))]
const fn outlive_file_size_limit() {}

/// How much is said from now on. What the command line says of it counts more than `RUST_LOG`.
fn listen_to(talk: TalkArgs) {
    let filter = match talk {
        TalkArgs { quiet: true, .. } => EnvFilter::new("error"),
        TalkArgs { verbose: 0, .. } => {
            EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"))
        }
        TalkArgs { verbose: 1, .. } => EnvFilter::new("info"),
        TalkArgs { .. } => EnvFilter::new("debug"),
    };
    if talk.quiet {
        output::be_quiet();
    }
    let is_colourless = env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(|| Stderr)
        .fmt_fields(debug_fn(write_field).delimited(" "))
        .with_ansi(io::stderr().is_terminal() && !is_colourless)
        .with_target(false)
        // A log that cannot be written shall not end a server.
        .log_internal_errors(false)
        .without_time()
        .init();
}

/// Writes a field of a log line. Its text may come from a file or a client.
fn write_field(line: &mut Writer<'_>, field: &Field, value: &dyn Debug) -> fmt::Result {
    let value = Escaped(format_args!("{value:?}"));
    match field.name() {
        "message" => write!(line, "{value}"),
        name => write!(line, "{name}={value}"),
    }
}
