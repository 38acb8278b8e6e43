//! `mmsim mms`: run a mouse written for the mms simulator.

mod annotations;
pub(crate) mod args;
mod button;
mod child;
mod exit;
mod log;
mod refusals;
mod session;
mod simulator;
mod stop;

use std::error::Error;
use std::time::Duration;

use annotations::mouse_name;
use args::MmsArgs;
use child::Child;
use exit::{ExitCause, MouseExit};
use log::MouseLog;
use mmsim_client::{Transport, Zmq};
use mmsim_maze::KnownMaze;
use mmsim_mms::SimulatedMouse;
use session::Session;
use simulator::{Annotator, Simulator};
use stop::Stop;

use crate::args::ServerArgs;
use crate::connection::{
    KnownSimulator, ask_maze, endpoint, explain, maze_from_args, report_waiting,
};
use crate::interrupt::Interrupt;
use crate::local_server;
use crate::output::{note, print, print_json, warn};
use crate::selection::Collection;
use crate::usage::UsageError;

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
    let exit = search(args, transport, &map, true, &interrupt)?;
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
    let KnownSimulator { map, has_annotations, .. } = match known {
        Some(known) => known,
        None => ask_maze(&mut transport, args.remote.known.size)?,
    };
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    let interrupt = Interrupt::catch()?;
    search(args, transport, &map, has_annotations, &interrupt).map(|exit| exit.code())
}

/// Runs the mouse in a maze with the size, start and goal of `map`, and reports the outcome.
fn search(
    args: &MmsArgs,
    transport: impl Transport,
    map: &KnownMaze,
    has_annotations: bool,
    interrupt: &Interrupt,
) -> Result<MouseExit, Box<dyn Error>> {
    let mouse = SimulatedMouse::new(map.size(), map.start().cell, *map.goals())
        .with_score_rules(args.scores);
    let stop = Stop::new(interrupt, args.time_limit);
    let pace = Duration::from_millis(args.pace);
    let log = has_annotations.then(MouseLog::default);
    let annotator = log.clone().map(|log| Annotator { name: mouse_name(&args.command), log });
    let simulator = Simulator::new(transport, map.size(), &stop, pace, annotator)?;
    let child = Child::start(&args.command, log.as_ref());
    let exit = Session::new(mouse, simulator, &stop, args.limit).run(child);
    match &exit.cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_)
        | ExitCause::Limit(_)
        | ExitCause::TimeLimit(_)
        | ExitCause::Interrupted => {}
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
