//! `mmsim`, a micromouse maze simulator. It serves mazes to search clients, runs and compares
//! bundled strategies, runs mice of the user, and scores robots in the two-run trial.
#![forbid(unsafe_code)]

mod args;
mod check_server;
mod cli;
mod compare;
mod connection;
mod contest;
mod demo;
mod export;
mod fast_run;
mod grid;
mod interrupt;
mod local_server;
mod manual;
mod mazes;
mod memory;
mod output;
mod page;
mod phase_table;
mod picture;
mod recording_transport;
mod recordings;
mod replay;
mod run;
mod screen;
mod searches;
mod selection;
mod serve;
mod solve;
mod stderr;
mod terminal;
mod trial;
mod vehicle;

use std::env;
use std::fmt::{self, Debug};
use std::io;
use std::process::{self, ExitCode};

use args::{UsageError, VerbosityArgs};
use clap::CommandFactory as _;
use cli::{Cli, Command};
use mmsim_maze::Escaped;
use output::warn;
use stderr::Stderr;
use tracing::Level;
use tracing::field::Field;
use tracing_subscriber::field::MakeExt as _;
use tracing_subscriber::filter::{ParseError, Targets};
use tracing_subscriber::fmt::format::{Writer, debug_fn};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

fn main() -> ExitCode {
    #[cfg(unix)]
    if let Some(code) = mmsim_mouse::guard_mice() {
        return code;
    }
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    memory::share_arena();
    survive_file_size_limit();
    let cli = Cli::parse_or_exit();
    configure_messages(cli.verbosity);
    let result = match cli.command {
        None => serve::run(&cli.serve, &Cli::command()),
        Some(Command::Solve(args)) => solve::run(&args),
        Some(Command::Demo(args)) => demo::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::FastRun(args)) => fast_run::run(&args),
        Some(Command::Contest(args)) => contest::run(&args),
        Some(Command::Trial(args)) => trial::run(&args),
        Some(Command::Mazes(args)) => mazes::run(&args),
        Some(Command::Run(args)) => run::run(&args).map(|code| exit(code)),
        Some(Command::CheckServer(args)) => check_server::run(&args),
        Some(Command::Completions(args)) => manual::complete(&args, &mut Cli::command()),
        Some(Command::Man(args)) => manual::run(&args, Cli::command()),
    };
    let code = match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            if let Some(error) = error.downcast_ref::<UsageError>() {
                cli::exit_with_usage(error);
            }
            output::warn_error(&*error);
            ExitCode::FAILURE
        }
    };
    stderr::flush();
    code
}

/// Exits with the exit code of a mouse. On some systems, exit codes do not fit in an `ExitCode`.
fn exit(code: i32) -> ! {
    stderr::flush();
    process::exit(code)
}

/// Catches SIGXFSZ, so that a write beyond the file size limit (`ulimit -f`) fails instead of
/// killing the process. The signal is caught instead of ignored, because child processes inherit
/// ignored signals.
#[cfg(unix)]
fn survive_file_size_limit() {
    let caught = std::sync::Arc::<std::sync::atomic::AtomicBool>::default();
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, caught);
}

#[cfg(not(unix))]
const fn survive_file_size_limit() {}

/// Sets how much is printed to stderr. Verbosity options override `RUST_LOG`.
fn configure_messages(verbosity: VerbosityArgs) {
    let filter = match verbosity {
        VerbosityArgs { quiet: true, .. } => Targets::new().with_default(Level::ERROR),
        VerbosityArgs { verbose: 0, .. } => (env::var("RUST_LOG").ok())
            .and_then(|directives| {
                let ignored =
                    |error: &_| warn(format_args!("ignoring RUST_LOG={directives}: {error}"));
                parse_targets(&directives).inspect_err(ignored).ok()
            })
            .unwrap_or_else(|| Targets::new().with_default(Level::WARN)),
        VerbosityArgs { verbose: 1, .. } => Targets::new().with_default(Level::INFO),
        VerbosityArgs { .. } => Targets::new().with_default(Level::DEBUG),
    };
    if verbosity.quiet {
        output::set_quiet();
    }
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(|| Stderr)
        .fmt_fields(debug_fn(write_field).delimited(" "))
        .with_ansi(terminal::has_colours(&io::stderr()))
        .with_target(false)
        // A log that cannot be written must not stop a server.
        .log_internal_errors(false)
        .without_time();
    tracing_subscriber::registry().with(lines).with(filter).init();
}

/// Parses a value of `RUST_LOG`, such as `warn,mmsim_zmtp=debug`. Without a level for all targets, no
/// others are logged.
fn parse_targets(directives: &str) -> Result<Targets, ParseError> {
    let directives = directives.split(',').map(str::trim).filter(|one| !one.is_empty());
    directives.collect::<Vec<_>>().join(",").parse()
}

/// Writes a field of a log line. The text is escaped, because it may come from a file or a client.
fn write_field(line: &mut Writer<'_>, field: &Field, value: &dyn Debug) -> fmt::Result {
    let value = Escaped(format_args!("{value:?}"));
    match field.name() {
        "message" => write!(line, "{value}"),
        name => write!(line, "{name}={value}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directives_select_levels_by_target() {
        let enabled = |directives, target| {
            let filter = parse_targets(directives).unwrap();
            let levels = [Level::ERROR, Level::WARN, Level::INFO, Level::DEBUG, Level::TRACE];
            levels.iter().filter(|level| filter.would_enable(target, level)).count()
        };
        assert_eq!([enabled("info", "a"), enabled("TRACE", "a"), enabled("off", "a")], [3, 5, 0]);
        let directives = "warn, mmsim_zmtp=debug,mmsim_zmtp::codec=off,";
        let targets = ["mmsim_server", "mmsim_zmtp", "mmsim_zmtp::codec"];
        assert_eq!(targets.map(|target| enabled(directives, target)), [2, 4, 0]);
        assert_eq!(enabled("mmsim_zmtp=debug", "mmsim_server"), 0);
        assert_eq!(enabled("", "mmsim_server"), 1, "errors only");
        assert!(parse_targets("mmsim=loud").is_err());
    }
}
