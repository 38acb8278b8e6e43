//! `mmsim run`: run a mouse that connects over ZeroMQ.

pub(crate) mod args;
mod gateway;

use std::error::Error;
use std::process::Stdio;
use std::sync::Arc;

use mmsim_server::listen;
use mmsim_viewer::{Ending, EndingKind, MouseControl};

use crate::args::ServerArgs;
use crate::connection::ENDPOINT_VARIABLE;
use crate::local_server::{self, HOST, MouseSetup, bind_or_free};
use crate::mouse_process::{MouseProcess, Program, WaitError, exit_code, exit_text, stop_code};
use crate::output::{counted, warn};
use crate::own_mouse::{self, RunEnd, Runs};
use crate::selection::Collection;
use args::RunArgs;
use gateway::{Gateway, Progress};

/// The placeholder for the address in the arguments of the mouse.
pub(crate) const ENDPOINT_PLACEHOLDER: &str = "{endpoint}";

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
    let gateway = Gateway::start(listener, monitor.clone(), Arc::clone(&control))?;
    let program = program.with_argument(ENDPOINT_PLACEHOLDER, gateway.address());
    let runs = Runs {
        control: &control,
        monitor: Some(&monitor),
        address: gateway.address(),
        stays: args.repeat.stays(viewer),
        watched: program.file.as_deref().filter(|_| args.repeat.watch),
        has_page: !viewer.no_viewer,
    };
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
    let (how, code, kind) = match process.wait(control) {
        Ok(status) => {
            let kind = (!status.success()).then_some(EndingKind::Failed);
            (exit_text(status), exit_code(status), kind)
        }
        Err(WaitError::Stopped(reason)) => {
            (reason.text().into(), stop_code(reason), Some(EndingKind::Stopped))
        }
        Err(error @ WaitError::Failed(_)) => {
            (format!("stopped: {error}"), 1, Some(EndingKind::Failed))
        }
    };
    drop(process);
    let progress = gateway.progress();
    let found = if progress.is_goal_reached { EndingKind::Goal } else { EndingKind::GaveUp };
    let text = format!("{how}; {}", describe(progress));
    let ending = Ending { kind: kind.unwrap_or(found), text };
    Ok(RunEnd { ending, code, was_started: true })
}

/// Describes the progress of the mouse, such as `goal reached, 412 states`.
fn describe(Progress { requests, refused, states, is_goal_reached }: Progress) -> String {
    if requests == 0 {
        return format!("no states reported (does it connect to {ENDPOINT_VARIABLE}?)");
    }
    let progress = match (states, is_goal_reached) {
        (0, _) => "no states reported".into(),
        (_, true) => format!("goal reached, {}", counted(states, "state")),
        (_, false) => format!("goal not reached, {}", counted(states, "state")),
    };
    let refused = (refused > 0).then(|| format!(", {} refused", counted(refused, "request")));
    format!("{progress}{}", refused.unwrap_or_default())
}
