//! Functions that wait with a timeout, so that a test fails with a message instead of hanging.

use std::io::Read;
use std::panic::resume_unwind;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_server::{Background, Simulation};

/// The default timeout for tests, long enough for a busy machine.
pub const TIMEOUT: Duration = Duration::from_secs(300);

/// [`TIMEOUT`] in milliseconds, for `ZeroMQ` sockets.
pub const TIMEOUT_MS: i32 = 300_000;

/// The timeout for a command. Some commands take a minute on an idle machine.
const COMMAND_TIMEOUT: Duration = Duration::from_secs(600);

/// The shortest pause between two polls.
const MIN_POLL_INTERVAL: Duration = Duration::from_millis(1);

/// The longest pause between two polls.
const MAX_POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Polls until `poll` returns a value.
///
/// # Panics
/// Panics if `poll` returns no value within [`TIMEOUT`].
#[track_caller]
pub fn wait_for<T>(what: &str, poll: impl FnMut() -> Option<T>) -> T {
    let Some(found) = poll_for(TIMEOUT, poll) else { panic!("waited {TIMEOUT:?} for {what}") };
    found
}

fn poll_for<T>(timeout: Duration, mut poll: impl FnMut() -> Option<T>) -> Option<T> {
    let start = Instant::now();
    loop {
        if let Some(found) = poll() {
            return Some(found);
        }
        let waited = start.elapsed();
        if waited > timeout {
            return None;
        }
        // Fewer polls leave more processor time to the event.
        thread::sleep((waited / 8).clamp(MIN_POLL_INTERVAL, MAX_POLL_INTERVAL));
    }
}

/// Runs a function on a separate thread, because the function might block forever.
///
/// # Panics
/// Panics if the function panics or takes longer than [`TIMEOUT`].
#[track_caller]
pub fn within<T: Send + 'static>(what: &str, run: impl FnOnce() -> T + Send + 'static) -> T {
    let (send, result) = mpsc::channel();
    // After a timeout there is no receiver.
    let thread = thread::spawn(move || drop(send.send(run())));
    match result.recv_timeout(TIMEOUT) {
        Ok(result) => result,
        Err(RecvTimeoutError::Timeout) => panic!("waited {TIMEOUT:?} for {what}"),
        Err(RecvTimeoutError::Disconnected) => match thread.join() {
            Err(panic) => resume_unwind(panic),
            Ok(()) => unreachable!("the thread sends before it ends"),
        },
    }
}

/// Stops a server and returns its simulation.
///
/// # Panics
/// Panics if the server does not stop or has failed.
#[track_caller]
pub fn stop(server: Background) -> Simulation {
    within("the server to stop", || server.stop()).unwrap()
}

/// Runs a command to completion without input and captures its output.
///
/// # Panics
/// Panics if the command cannot be started or takes longer than ten minutes.
#[track_caller]
pub fn output(command: &mut Command) -> Output {
    let pipes = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    wait_with_output(pipes.spawn().unwrap())
}

/// Waits for a process to exit and captures its output.
///
/// # Panics
/// Panics if the process takes longer than ten minutes, or if another process keeps the output
/// pipes open.
#[track_caller]
pub fn wait_with_output(mut child: Child) -> Output {
    drop(child.stdin.take());
    let (stdout, stderr) = (capture(child.stdout.take()), capture(child.stderr.take()));
    let status = wait_for_exit(&mut child);
    let all = |captured: Receiver<_>| captured.recv_timeout(TIMEOUT).expect("the pipes close");
    Output { status, stdout: all(stdout), stderr: all(stderr) }
}

/// Waits for a process to exit.
///
/// # Panics
/// Kills the process and panics if it takes longer than ten minutes.
#[track_caller]
pub fn wait_for_exit(child: &mut Child) -> ExitStatus {
    let status = poll_for(COMMAND_TIMEOUT, || child.try_wait().unwrap());
    let Some(status) = status else {
        let _ = child.kill();
        panic!("waited {COMMAND_TIMEOUT:?} for a command to exit")
    };
    status
}

/// Reads a pipe to its end on a separate thread.
fn capture(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (send, captured) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            pipe.read_to_end(&mut bytes).unwrap();
        }
        let _ = send.send(bytes);
    });
    captured
}
