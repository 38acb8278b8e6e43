//! `mmsim mms`: run a mouse written for the mms simulator.

mod annotations;
pub(crate) mod args;
mod button;
pub(crate) mod child;
mod exit;
pub(crate) mod invalid_lines;
mod log;
mod session;
mod simulator;

use std::error::Error;
use std::sync::Arc;

use args::MmsArgs;
use button::press_on_input;
use child::Child;
use exit::ExitCause;
use log::MouseLog;
use mmsim_client::Transport;
use mmsim_maze::KnownMaze;
use mmsim_mms::SimulatedMouse;
use mmsim_server::Served;
use mmsim_viewer::MouseControl;
use session::Session;
use simulator::{Annotator, Simulator};

use crate::args::ServerArgs;
use crate::connection::{KnownSimulator, ask_maze, connect, endpoint, explain, maze_from_args};
use crate::interrupt::Interrupt;
use crate::local_server::{self, HOST, MouseSetup};
use crate::mouse_process::Program;
use crate::output::{print, print_json, warn};
use crate::own_mouse::{self, RunEnd, Runs};
use crate::selection::Collection;
use crate::usage::UsageError;

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    match &args.remote.connect {
        None => run_locally(args),
        Some(address) => run_remotely(&endpoint(address), args),
    }
}

fn run_locally(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let known = &args.remote.known;
    if known.size.is_some() || !known.goal.is_empty() {
        return Err(UsageError::new("mms", "--size and --goal require --connect").into());
    }
    let program = Program::new(&args.command);
    let ServerArgs { port, words, retention, viewer } = &args.server;
    let control = own_mouse::control("mms", &program, &args.repeat, viewer, true)?;
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&words.join(" "))?;
    let mouse = MouseSetup { control: Arc::clone(&control), address: None };
    let ready = local_server::prepare(
        selected,
        collection.catalogue,
        (HOST, *port),
        retention,
        Some(viewer),
        Some(mouse),
    )?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let address = server.address();
    press_on_input(Arc::clone(&control));
    let runs = Runs {
        control: &control,
        monitor: Some(&monitor),
        address,
        stays: args.repeat.stays(viewer),
        watched: program.file.as_deref().filter(|_| args.repeat.watch),
        has_page: !viewer.no_viewer,
    };
    let code = runs.run(ready.interrupt, || {
        let Served { info, maze, .. } = monitor.served()?;
        let maze = NamedMaze { name: Some(info.name), map: KnownMaze::unexplored(&maze) };
        search(args, &program, local_server::in_process(&monitor), &maze, true, &control)
    })?;
    server.stop()?;
    Ok(code)
}

fn run_remotely(endpoint: &str, args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let program = Program::new(&args.command);
    let control = own_mouse::control("mms", &program, &args.repeat, &args.server.viewer, true)?;
    let known = maze_from_args("mms", &args.remote.known)?;
    let mut transport = connect(endpoint, None, known.is_none())?;
    let KnownSimulator { name, map, has_annotations, .. } = match known {
        Some(known) => known,
        None => ask_maze(&mut transport, args.remote.known.size)?,
    };
    let maze = NamedMaze { name, map };
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    press_on_input(Arc::clone(&control));
    let runs = Runs {
        control: &control,
        monitor: None,
        address: endpoint,
        stays: false,
        watched: None,
        has_page: false,
    };
    runs.run(Interrupt::catch()?, || {
        search(args, &program, &mut transport, &maze, has_annotations, &control)
    })
}

/// A maze of which only the size, start and goal are known.
struct NamedMaze {
    /// `None` if a simulator in another process was not asked.
    name: Option<String>,
    map: KnownMaze,
}

/// Runs the mouse once in the maze, and reports the outcome.
fn search(
    args: &MmsArgs,
    program: &Program,
    transport: impl Transport,
    NamedMaze { name, map }: &NamedMaze,
    has_annotations: bool,
    control: &MouseControl,
) -> Result<RunEnd, Box<dyn Error>> {
    let mouse = SimulatedMouse::new(map.size(), map.start().cell, *map.goals())
        .with_score_rules(args.scores);
    let log = has_annotations.then(MouseLog::default);
    let annotator = log.clone().map(|log| Annotator { name: program.name.clone(), log });
    let simulator = Simulator::new(transport, map.size(), control, annotator)?;
    let child = Child::start(program, log.as_ref());
    let is_remote = args.remote.connect.is_some();
    let exit = Session::new(mouse, simulator, is_remote, control, args.limit).run(child);
    match &exit.cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_) | ExitCause::Limit(_) | ExitCause::Stopped(_) => {}
    }
    let end = exit.end();
    if args.json {
        print_json(&exit.report(name.as_deref()))?;
    } else if args.score && end.was_started {
        print(&exit.scores())?;
    }
    Ok(end)
}
