//! Waits that end by themselves, since a test that hangs does not say why.

use std::io::Read;
use std::panic::resume_unwind;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_server::{Background, Simulation};

/// The maximum wait for what always comes, however busy the machine is.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// The same in milliseconds, as sockets of `ZeroMQ` take it.
pub const PATIENCE_MS: i32 = 300_000;

/// The maximum time of a command: some work for a minute on an idle machine.
const COMMAND_PATIENCE: Duration = Duration::from_secs(600);

/// Looks again and again until there is something.
///
/// # Panics
/// There is nothing within [`PATIENCE`].
#[track_caller]
pub fn wait_for<T>(what: &str, look: impl FnMut() -> Option<T>) -> T {
    let Some(found) = look_until(PATIENCE, look) else { panic!("waited {PATIENCE:?} for {what}") };
    found
}

fn look_until<T>(patience: Duration, mut look: impl FnMut() -> Option<T>) -> Option<T> {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return Some(found);
        }
        if begun.elapsed() > patience {
            return None;
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Does what may block for ever, on a thread of its own.
///
/// # Panics
/// It is not done within [`PATIENCE`], or it panics.
#[track_caller]
pub fn within<T: Send + 'static>(what: &str, act: impl FnOnce() -> T + Send + 'static) -> T {
    let (send, result) = mpsc::channel();
    // Nobody receives what comes too late.
    let thread = thread::spawn(move || drop(send.send(act())));
    match result.recv_timeout(PATIENCE) {
        Ok(result) => result,
        Err(RecvTimeoutError::Timeout) => panic!("waited {PATIENCE:?} for {what}"),
        Err(RecvTimeoutError::Disconnected) => match thread.join() {
            Err(panic) => resume_unwind(panic),
            Ok(()) => unreachable!("it sends before it ends"),
        },
    }
}

/// Stops a server and returns its simulation.
///
/// # Panics
/// It does not stop, or has failed before.
#[track_caller]
pub fn stop(server: Background) -> Simulation {
    within("the server to stop", || server.stop()).unwrap()
}

/// Runs a command to its end without input; what it writes is captured.
///
/// # Panics
/// It cannot be started, or does not end within ten minutes.
#[track_caller]
pub fn output(command: &mut Command) -> Output {
    let pipes = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    output_of(pipes.spawn().unwrap())
}

/// Waits for the end of a process; what it writes into pipes is captured.
///
/// # Panics
/// It does not end within ten minutes, or another process holds its pipes open.
#[track_caller]
pub fn output_of(mut child: Child) -> Output {
    drop(child.stdin.take());
    let (stdout, stderr) = (capture(child.stdout.take()), capture(child.stderr.take()));
    let status = exit_of(&mut child);
    let all = |captured: Receiver<_>| captured.recv_timeout(PATIENCE).expect("its pipes close");
    Output { status, stdout: all(stdout), stderr: all(stderr) }
}

/// Waits for the end of a process.
///
/// # Panics
/// It does not end within ten minutes; it is killed then.
#[track_caller]
pub fn exit_of(child: &mut Child) -> ExitStatus {
    let status = look_until(COMMAND_PATIENCE, || child.try_wait().unwrap());
    let Some(status) = status else {
        let _ = child.kill();
        panic!("waited {COMMAND_PATIENCE:?} for the end of a command")
    };
    status
}

/// All that comes out of a pipe.
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
