//! `mmsim run`: run a mouse that connects over ZeroMQ.

pub(crate) mod args;

use std::error::Error;
use std::process::Stdio;
use std::sync::Arc;

use mmsim_maze::counted;
use mmsim_mouse::{
    ENDPOINT_PLACEHOLDER, ENDPOINT_VARIABLE, ExitCause, Gateway, MouseControl, MouseProcess,
    Program, Progress, RunEnd,
};
use mmsim_server::listen;

use crate::local_server::{HOST, bind_or_free};
use crate::output::warn;
use crate::own_mouse;
use args::RunArgs;

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &RunArgs) -> Result<i32, Box<dyn Error>> {
    let (server, repeat) = (&args.server, &args.repeat);
    let program = Program::new(&args.command);
    let control = own_mouse::control("run", &program, repeat, &server.viewer, false)?;
    // The simulator itself listens on another port, because the replies on this one are delayed.
    let listener = bind_or_free(server.port, |port| listen(HOST, port))?;
    let address = format!("tcp://{}", listener.local_addr()?);
    own_mouse::serve(
        args.mazes.as_deref(),
        (&program, &control),
        (server, repeat),
        (Some(0), Some(address)),
        |monitor| {
            let gateway = Gateway::start(listener, monitor, Arc::clone(&control))?;
            let program = program.with_argument(ENDPOINT_PLACEHOLDER, gateway.address());
            let control = &control;
            Ok(move || run_once(&program, &gateway, control))
        },
    )
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
    let cause = match MouseProcess::start(&mut command) {
        Ok(mut process) => process.wait(control),
        Err(error) => {
            warn(format_args!("mmsim: {error}"));
            ExitCause::NotStarted(error)
        }
    };
    let Progress { requests, refused, phases } = gateway.progress();
    let details = match (requests, phases.states) {
        (0, _) => format!(", no states reported (does it connect to {ENDPOINT_VARIABLE}?)"),
        (_, 0) => ", no states reported".into(),
        (_, states) => format!(", {}", counted(states, "state")),
    };
    let refused = (refused > 0).then(|| format!(", {} refused", counted(refused, "request")));
    Ok(cause.end(&phases, &(details + &refused.unwrap_or_default())))
}
