//! `mmsim run`: run a mouse that connects over ZeroMQ.

pub(crate) mod args;
mod gateway;

use std::error::Error;
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

use mmsim_server::listen;
use mmsim_viewer::{Ending, EndingKind, MouseControl, StopReason};

use crate::args::ServerArgs;
use crate::connection::ENDPOINT_VARIABLE;
use crate::interrupt::Interrupt;
use crate::local_server::{self, HOST, MouseSetup, bind_or_free};
use crate::mouse_process::{MouseProcess, Program, exit_code, exit_text};
use crate::output::{counted, note, warn};
use crate::own_mouse::{self, RunEnd, Runs};
use crate::selection::Collection;
use args::RunArgs;
use gateway::{Gateway, Progress};

/// The placeholder for the address in the arguments of the mouse.
const ENDPOINT_PLACEHOLDER: &str = "{endpoint}";

/// The maximum interval between checks whether the mouse has exited.
const MAX_POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &RunArgs) -> Result<i32, Box<dyn Error>> {
    let ServerArgs { port, words, retention, viewer } = &args.server;
    let program = Program::new(&args.command);
    let control = own_mouse::control("run", &program, &args.repeat, viewer, false)?;
    let collection = Collection::at(args.mazes.as_deref())?;
    let selected = collection.select(&words.join(" "))?;
    // The simulator itself listens on another port, because the replies on this one are delayed.
    let listener = bind_or_free(*port, |port| listen(HOST, port))?;
    let address = format!("tcp://{}", listener.local_addr()?);
    let mouse = MouseSetup { control: Arc::clone(&control), address: Some(address) };
    let ready = local_server::prepare(
        selected,
        collection.catalogue,
        (HOST, Some(0)),
        retention,
        Some(viewer),
        Some(mouse),
    )?;
    let monitor = ready.server.monitor();
    let server = ready.server.spawn(ready.simulation);
    let gateway = Gateway::start(listener, monitor, Arc::clone(&control))?;
    let runs = Runs {
        control: &control,
        address: gateway.address(),
        stays: args.repeat.stays(viewer),
        watches: args.repeat.watch,
        has_page: !viewer.no_viewer,
    };
    let program = program.with_argument(ENDPOINT_PLACEHOLDER, gateway.address());
    let code = runs.run(ready.interrupt, || run_once(&program, &gateway, &control))?;
    server.stop()?;
    Ok(code)
}

/// Runs the mouse once, in the maze that is being served.
fn run_once(
    program: &Program,
    gateway: &Gateway,
    control: &MouseControl,
) -> Result<RunEnd, Box<dyn Error>> {
    gateway.begin_run()?;
    let mut command = program.command();
    command.env(ENDPOINT_VARIABLE, gateway.address()).stdin(Stdio::null());
    let mut process = match MouseProcess::start(&mut command) {
        Ok(process) => process,
        Err(error) => {
            warn(format_args!("mmsim: {error}"));
            let ending = Ending { kind: EndingKind::Failed, text: error };
            return Ok(RunEnd { ending, code: 1, was_started: false });
        }
    };
    let mut interval = Duration::from_millis(1);
    let (how, code, kind) = loop {
        if let Some(reason) = control.wait_for_stop(interval) {
            let code = if reason == StopReason::Exit { Interrupt::CODE } else { 1 };
            break (reason.text().to_string(), code, Some(EndingKind::Stopped));
        }
        match process.status() {
            Ok(Some(status)) => {
                let kind = (!status.success()).then_some(EndingKind::Failed);
                break (exit_text(status), exit_code(status), kind);
            }
            Ok(None) => interval = MAX_POLL_INTERVAL.min(2 * interval),
            Err(error) => {
                break (
                    format!("stopped: cannot get its exit status: {error}"),
                    1,
                    Some(EndingKind::Failed),
                );
            }
        }
    };
    drop(process);
    let progress = gateway.progress();
    let found = if progress.is_goal_reached { EndingKind::Goal } else { EndingKind::GaveUp };
    let text = format!("{how}; {}", describe(progress));
    note(format_args!("mouse {text}"));
    let ending = Ending { kind: kind.unwrap_or(found), text };
    Ok(RunEnd { ending, code, was_started: true })
}

/// Describes the progress of the mouse, such as `goal reached, 412 states`.
fn describe(Progress { states, is_goal_reached }: Progress) -> String {
    if states == 0 {
        return format!("no states reported (does it connect to {ENDPOINT_VARIABLE}?)");
    }
    let goal = if is_goal_reached { "goal reached" } else { "goal not reached" };
    format!("{goal}, {}", counted(states, "state"))
}
