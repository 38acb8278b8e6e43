//! `mmsim mms`: run a mouse written for the mms simulator.

pub(crate) mod args;
mod button;
mod child;
mod exit;
mod simulator;

use std::error::Error;
use std::sync::mpsc::RecvTimeoutError::{Disconnected, Timeout};
use std::time::Duration;

use args::MmsArgs;
use button::Button;
use child::{Child, Line, MAX_LINE_BYTES};
use exit::{ExitCause, MouseExit};
use mmsim_client::{Transport, Zmq};
use mmsim_maze::KnownMaze;
use mmsim_mms::{Command, CommandError, Response, SimulatedMouse, excerpt};
use simulator::Simulator;

use crate::args::ServerArgs;
use crate::connection::{
    KnownSimulator, ask_maze, endpoint, explain, maze_from_args, report_waiting,
};
use crate::interrupt::Interrupt;
use crate::local_server;
use crate::output::{note, print, print_json, warn};
use crate::selection::Collection;
use crate::usage::UsageError;

/// The interval between checks for Ctrl-C while the mouse computes.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The time after which an incomplete line is reported. Must be a multiple of [`POLL_INTERVAL`].
const INCOMPLETE_LINE_TIMEOUT: Duration = Duration::from_secs(1);

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    match &args.remote.connect {
        None => run_locally(args),
        Some(connect) => run_remotely(&endpoint(connect), args),
    }
}

fn run_locally(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let known = &args.remote.known;
    if known.size.is_some() || !known.goal.is_empty() {
        return Err(UsageError::new("mms", "--size and --goal require --connect").into());
    }
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&args.server.words.join(" "))?;
    let map = KnownMaze::unexplored(&selected.maze);
    let ServerArgs { port, retention, viewer, .. } = &args.server;
    let (server, interrupt) =
        local_server::start(selected, collection.catalogue, *port, retention, Some(viewer))?;
    let address = server.address();
    let transport = Zmq::connect(address, None, |waiting| report_waiting(&waiting, false))?;
    let exit = search(args, transport, &map, &interrupt)?;
    if matches!(exit.cause, ExitCause::Interrupted | ExitCause::NotStarted(_)) {
        // There is nothing left to watch.
    } else if args.stays() {
        note(format_args!("still serving at {address}; press Ctrl-C to stop"));
        interrupt.wait();
    } else if !viewer.no_viewer {
        note("viewer page closed because the run has ended; use --stay to keep it open");
    }
    server.stop()?;
    Ok(exit.code())
}

fn run_remotely(endpoint: &str, args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let known = maze_from_args("mms", &args.remote.known)?;
    let asks_server = known.is_none();
    let mut transport =
        Zmq::connect(endpoint, None, |waiting| report_waiting(&waiting, asks_server))?;
    let KnownSimulator { map, .. } = match known {
        Some(known) => known,
        None => ask_maze(&mut transport, args.remote.known.size)?,
    };
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    search(args, transport, &map, &Interrupt::catch()?).map(|exit| exit.code())
}

/// Runs the mouse in a maze with the size, start and goal of `map`, and reports the outcome.
fn search(
    args: &MmsArgs,
    transport: impl Transport,
    map: &KnownMaze,
    interrupt: &Interrupt,
) -> Result<MouseExit, Box<dyn Error>> {
    let pace = Duration::from_millis(args.pace);
    let mut session = Session {
        simulator: Simulator::new(transport, map.size(), interrupt, pace)?,
        interrupt,
        button: Button::from_stdin(),
        mouse: SimulatedMouse::new(map.size(), map.start().cell, *map.goals()),
        limit: args.limit,
        lines: 0,
        crashes: 0,
        refused: 0,
    };
    let cause = match Child::start(&args.command) {
        Ok(child) => session.run(child).unwrap_or_else(|cause| cause),
        Err(error) => ExitCause::NotStarted(error),
    };
    let Session { mouse, crashes, refused, .. } = session;
    let exit = MouseExit { mouse, cause, crashes, refused };
    match &exit.cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_) | ExitCause::Limit(_) | ExitCause::Interrupted => {}
    }
    let was_started = !matches!(exit.cause, ExitCause::NotStarted(_));
    if was_started {
        note(exit.summary());
    }
    if args.json {
        print_json(&exit.report())?;
    } else if args.score && was_started {
        print(&exit.scores())?;
    }
    Ok(exit)
}

/// The state of a running mouse.
struct Session<'a, T> {
    simulator: Simulator<'a, T>,
    interrupt: &'a Interrupt,
    button: Button,
    mouse: SimulatedMouse,
    limit: Option<u32>,
    lines: u64,
    crashes: u64,
    refused: u64,
}

impl<T: Transport> Session<'_, T> {
    /// Executes the mouse's commands until the mouse exits or is stopped.
    fn run(&mut self, mut child: Child) -> Result<ExitCause, ExitCause> {
        self.simulator.update(&self.mouse)?;
        let mut silence = Duration::ZERO;
        loop {
            if self.interrupt.wait_for(Duration::ZERO) {
                return Err(ExitCause::Interrupted);
            }
            match child.next_line(POLL_INTERVAL) {
                Ok(line) => {
                    self.answer(&line, &child)?;
                    silence = Duration::ZERO;
                }
                // A process that the mouse has started may keep the pipe open after the mouse
                // exits.
                Err(Timeout) if child.status().is_ok_and(|status| status.is_some()) => break,
                Err(Timeout) => {
                    let start = child.incomplete_line();
                    silence =
                        if start.is_empty() { Duration::ZERO } else { silence + POLL_INTERVAL };
                    if silence == INCOMPLETE_LINE_TIMEOUT {
                        self.report_incomplete(&start);
                    }
                }
                Err(Disconnected) => break,
            }
        }
        child.end_replies();
        // The mouse may have set markers after the last state was sent.
        self.simulator.update(&self.mouse)?;
        let mut interval = Duration::from_millis(1);
        loop {
            let status = child.status();
            // Ctrl-C may have reached both processes.
            let timeout = if matches!(status, Ok(None)) { interval } else { Duration::ZERO };
            if self.interrupt.wait_for(timeout) {
                return Err(ExitCause::Interrupted);
            }
            match status {
                Ok(Some(status)) => return Ok(ExitCause::Exited(status)),
                Ok(None) => interval = POLL_INTERVAL.min(2 * interval),
                Err(error) => return Err(ExitCause::Failed(error.to_string())),
            }
        }
    }

    /// Reports an incomplete line, because the mouse may be waiting for a reply to it.
    fn report_incomplete(&self, start: &[u8]) {
        let (line, start) = (self.lines + 1, excerpt(start));
        warn(format_args!("mms: line {line}: waiting for a newline after {start}"));
    }

    fn answer(&mut self, line: &Line, child: &Child) -> Result<(), ExitCause> {
        self.lines += 1;
        if matches!(line, Line::Whole(line) if line.trim_ascii().is_empty()) {
            return Ok(());
        }
        if self.button.was_pressed() {
            self.mouse.press_reset();
        }
        let command = match self.command(line) {
            Ok(command) => command,
            Err(error) => {
                self.refused += 1;
                warn(format_args!("mms: line {}: {error}", self.lines));
                return Ok(());
            }
        };
        let is_movement = matches!(command, Command::Forward { .. } | Command::Turn { .. });
        let reply = self.mouse.execute(command, &mut self.simulator)?;
        self.crashes += u64::from(reply == Some(Response::Crash));
        if let Some(limit) = self.limit.filter(|_| is_movement)
            && self.mouse.scores().total().cost() > limit.into()
        {
            return Err(ExitCause::Limit(limit));
        }
        reply.map_or(Ok(()), |reply| child.reply(reply)).map_err(ExitCause::Failed)
    }

    fn command<'l>(&self, line: &'l Line) -> Result<Command<'l>, String> {
        match line {
            Line::Whole(line) => Command::parse(line, self.mouse.map().size())
                .map_err(|error: CommandError| error.to_string()),
            Line::TooLong(start) => Err(format!(
                "expected at most {MAX_LINE_BYTES} bytes, found a longer line that starts with {}",
                excerpt(start)
            )),
            Line::Unfinished(line) => {
                Err(format!("expected a newline, found the end of output after {}", excerpt(line)))
            }
        }
    }
}
