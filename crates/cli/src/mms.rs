//! `mmsim mms`: run a mouse written for the mms simulator.

pub(crate) mod args;
mod button;

use std::error::Error;
use std::sync::Arc;

use args::MmsArgs;
use button::press_on_input;
use mmsim_client::Transport;
use mmsim_maze::KnownMaze;
use mmsim_mouse::{ExitCause, MouseControl, Program, RunEnd, Runs, Session};
use mmsim_server::Served;

use crate::args::UsageError;
use crate::connection::{KnownSimulator, ask_maze, connect, endpoint, explain, maze_from_args};
use crate::interrupt::Interrupt;
use crate::local_server::in_process;
use crate::output::{note, print, print_json, warn};
use crate::own_mouse;

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &MmsArgs) -> Result<i32, Box<dyn Error>> {
    let program = Program::new(&args.command);
    match &args.remote.connect {
        None => run_locally(args, &program),
        Some(address) => run_remotely(&endpoint(address), args, &program),
    }
}

fn run_locally(args: &MmsArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let (known, server, repeat) = (&args.remote.known, &args.server, &args.repeat);
    if known.size.is_some() || !known.goal.is_empty() {
        return Err(UsageError::new("mms", "--size and --goal require --connect").into());
    }
    let control = own_mouse::control("mms", program, repeat, &server.viewer, true)?;
    own_mouse::serve(
        args.mazes.as_deref(),
        (program, &control),
        (server, repeat),
        (server.port, None),
        |monitor| {
            press_on_input(Arc::clone(&control));
            let control = &control;
            Ok(move || {
                let Served { info, maze, .. } = monitor.served()?;
                let known = KnownSimulator {
                    name: Some(info.name),
                    map: KnownMaze::unexplored(&maze),
                    start: maze.start(),
                    has_annotations: true,
                };
                search(args, program, in_process(&monitor), &known, control)
            })
        },
    )
}

fn run_remotely(endpoint: &str, args: &MmsArgs, program: &Program) -> Result<i32, Box<dyn Error>> {
    let control = own_mouse::control("mms", program, &args.repeat, &args.server.viewer, true)?;
    let known = maze_from_args("mms", &args.remote.known)?;
    let mut transport = connect(endpoint, None, known.is_none())?;
    let known = known.map_or_else(|| ask_maze(&mut transport, args.remote.known.size), Ok)?;
    // Until the simulator replies, Ctrl-C terminates the process directly.
    transport.exchange(b"ping", &mut Vec::new())?;
    press_on_input(Arc::clone(&control));
    let closing = Arc::clone(&control);
    Interrupt::catch()?.then(move || closing.close());
    Runs::new(&control, endpoint, |text| note(text))
        .run(|| search(args, program, &mut transport, &known, &control))
}

/// Runs the mouse once in the maze, and reports the outcome.
fn search(
    args: &MmsArgs,
    program: &Program,
    transport: impl Transport,
    known: &KnownSimulator,
    control: &MouseControl,
) -> Result<RunEnd, Box<dyn Error>> {
    let session = Session {
        program,
        maze: &known.map,
        rules: args.scores,
        limit: args.limit,
        has_annotations: known.has_annotations,
        is_remote: args.remote.connect.is_some(),
        control,
        warn: |text| warn(text),
    };
    let exit = session.run(transport)?;
    match &exit.cause {
        ExitCause::LostSimulator(error) => warn(format_args!("mmsim: {}", explain(error))),
        ExitCause::NotStarted(error) | ExitCause::Failed(error) => {
            warn(format_args!("mmsim: {error}"));
        }
        ExitCause::Exited(_) | ExitCause::Limit(_) | ExitCause::Stopped(_) => {}
    }
    let end = exit.end();
    if args.json {
        print_json(&exit.report(known.name.as_deref()))?;
    } else if args.score && end.was_started {
        print(&exit.scores())?;
    }
    Ok(end)
}
