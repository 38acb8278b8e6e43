//! `mmsim`, a micromouse maze simulator: serves mazes to search clients and runs bundled
//! strategies against a simulator.

mod args;
mod demo;
mod embedded;
mod interrupt;
mod mazes;
mod selection;
mod serve;
mod solve;

use std::env;
use std::error::Error;
use std::io::{self, ErrorKind, IsTerminal};
use std::process::ExitCode;

use args::{Cli, Command};
use clap::Parser;
use tracing_subscriber::EnvFilter;

/// Whether the work was done: the goal reached, every maze valid. An error says why it could not
/// even be tried.
type Outcome = Result<bool, Box<dyn Error>>;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        .init();
    let outcome = match cli.command {
        None => serve::run(&cli.serve),
        Some(Command::Solve(args)) => solve::run(&args),
        Some(Command::Demo(args)) => demo::run(&args),
        Some(Command::Mazes(args)) => mazes::run(&args),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        // Whoever read our output has read enough, as `head` does.
        Err(error) if is_broken_pipe(&*error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("mmsim: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A number of things, such as `1 step` or `2 steps`.
fn counted(count: impl Into<u64>, thing: &str) -> String {
    let count = count.into();
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// How to run another command of ours, given how this one was run.
fn own_command(arguments: &str) -> String {
    let run = if env::var_os("CARGO_MANIFEST_DIR").is_some() {
        "cargo run --release --"
    } else {
        "mmsim"
    };
    format!("`{}`", format!("{run} {arguments}").trim_end())
}

fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == ErrorKind::BrokenPipe)
}
