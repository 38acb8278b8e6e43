//! `mmsim run`: run a mouse that connects over ZeroMQ.

use std::error::Error;
use std::sync::Arc;

use clap::Args;
use mmsim_maze::counted;
use mmsim_mouse::{
    ENDPOINT_VARIABLE, ExitCause, Gateway, MouseControl, MouseProcess, Program, Progress, RunEnd,
};
use mmsim_server::listen;

use crate::local_server::{HOST, bind_or_free};
use crate::output::warn;
use crate::own_mouse::OwnMouseArgs;

const AFTER_HELP: &str = "\
Examples:
  mmsim run --open -- python3 mouse.py           watch the mouse in a browser
  mmsim run --open --watch -- python3 mouse.py   run it again each time mouse.py changes
  mmsim run --maze hedgerow -- ./my-mouse {endpoint}
                                                 pass the address as an argument
  mmsim run --record runs -- ./my-mouse          record each run to a new file

The mouse connects to the address in the environment variable MMSIM_ENDPOINT. In the arguments of
the mouse, {endpoint} stands for the same address. A mouse that always connects to port 6574 works
too, unless another simulator uses this port. While the mouse runs, other clients can only read.

On the viewer page, you can run the mouse again, stop it, pause it, and change its pace. The
simulator holds its reply to a state until the next step is due, so the mouse should wait for
replies without a timeout.

The exit code is that of the mouse, or 128 plus the number of the signal that killed it; 1 if the
mouse jumped, did not start, was stopped or exceeded --time-limit; 130 after Ctrl-C.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    own: OwnMouseArgs,
}

/// Runs the mouse and returns the exit code.
pub(crate) fn run(args: &RunArgs) -> Result<i32, Box<dyn Error>> {
    let own = &args.own;
    let program = own.program();
    let control = own.control("run", &program, false)?;
    // The simulator itself listens on another port: the gateway answers on this one.
    let listener = bind_or_free(own.server.port, |port| listen(HOST, port))?;
    let address = format!("tcp://{}", listener.local_addr()?);
    let misreadings = own.server.misread.misreadings();
    own.serve(&program, &control, Some(0), Some(&address), misreadings, |monitor| {
        let gateway = Gateway::start(listener, monitor, Arc::clone(&control))?;
        let (program, control) = (&program, &control);
        Ok(move || run_once(program, &gateway, control))
    })
}

/// Runs the mouse once, in the maze that is being served.
fn run_once(
    program: &Program,
    gateway: &Gateway,
    control: &MouseControl,
) -> Result<RunEnd, Box<dyn Error>> {
    let run = gateway.begin_run()?;
    let cause = match MouseProcess::start(program, run.address()) {
        Ok(mut process) => process.wait(control),
        Err(error) => {
            warn(format_args!("mmsim: {error}"));
            ExitCause::NotStarted(error.into())
        }
    };
    let Progress { requests, refused, crashes, phases } = run.finish();
    let details = match (requests, phases.states) {
        (0, _) => format!(", no states reported (does it connect to {ENDPOINT_VARIABLE}?)"),
        (_, 0) => ", no states reported".into(),
        (_, states) => format!(", {}", counted(states, "state")),
    };
    let refused = (refused > 0).then(|| format!(", {} refused", counted(refused, "request")));
    let crashes = (crashes > 0).then(|| format!(", {}", counted(crashes, "crashed movement")));
    let details = details + &crashes.unwrap_or_default() + &refused.unwrap_or_default();
    Ok(cause.end(&phases, &details))
}
