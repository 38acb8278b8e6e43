//! The guard of a mouse: a process between this process and the mouse. It ends the mouse and all
//! descendants of the mouse as soon as this process ends, even by `kill -9`, or drops the mouse.
//!
//! ```text
//!   this process ◄── socket ──► guard ──► mouse ──► its descendants
//! ```
//!
//! The stdin of the guard is the socket, and its other streams are those of the mouse. The guard
//! receives the stdin of the mouse and sends the process ID of the mouse, and then its wait status.
//! When the socket closes, it kills. On Linux, the guard becomes the parent of each descendant whose
//! parent exits, so none can escape it, not even a process of another session.

use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, ErrorKind, IoSlice, IoSliceMut, PipeReader, Read, Write};
use std::mem::MaybeUninit;
use std::net::Shutdown;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio};
use std::sync::OnceLock;

use rustix::cmsg_space;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};
use rustix::process::{
    Pid, Signal, WaitOptions, WaitStatus, kill_process, kill_process_group, wait,
};

/// The interval between attempts to kill processes that appear while others are killed.
const KILL_INTERVAL: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// The argument that makes a program a guard. The command line of the mouse follows.
const ARGUMENT: &str = "--mouse-guard";

/// The environment variables with which a program has restarted itself so that glibc uses one arena for
/// all its threads: that of glibc, and one that says so. Mice do not see them.
pub const ONE_ARENA: [&str; 2] = ["MALLOC_ARENA_MAX", "MMSIM_ONE_ARENA"];

/// The program that guards mice.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Makes this program guard its mice, so that none outlives it. Call this first in `main`. If this
/// process was started as a guard, returns its exit code once it has done its work.
pub fn guard_mice() -> Option<ExitCode> {
    let mut arguments = env::args_os().skip(1);
    if arguments.next().is_some_and(|argument| argument == ARGUMENT) {
        let is_done = run(arguments).is_ok();
        return Some(if is_done { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    // The file of this program may be replaced while it runs.
    let link = Path::new("/proc/self/exe");
    let program = if link.exists() { Ok(link.into()) } else { env::current_exe() };
    program.into_iter().for_each(use_guard);
    None
}

/// Makes a program that calls [`guard_mice`] guard the mice of this process, unless another one already
/// does.
pub fn use_guard(program: PathBuf) {
    let _ = PROGRAM.set(program);
}

/// Returns the command of the guard of the mouse that `mouse` starts, if there is a guard.
pub(crate) fn command(mouse: &Command) -> Option<Command> {
    let mut command = Command::new(PROGRAM.get()?);
    command.arg(ARGUMENT).arg(mouse.get_program()).args(mouse.get_args());
    if env::var_os(ONE_ARENA[1]).is_some() {
        for name in ONE_ARENA {
            command.env_remove(name);
        }
    }
    command.envs(mouse.get_envs().filter_map(|(name, value)| Some((name, value?))));
    Some(command)
}

/// A mouse with a guard.
#[derive(Debug)]
pub(crate) struct Guarded {
    socket: UnixStream,
    mouse: Pid,
    status: Option<ExitStatus>,
}

impl Guarded {
    /// Starts the guard, and waits until it has started the mouse. `command` is that of the guard.
    /// Without a pipe, the stdin of the mouse is empty.
    pub(crate) fn start(
        command: &mut Command,
        stdin: Option<&PipeReader>,
    ) -> io::Result<(Child, Self)> {
        let (mut socket, its_socket) = UnixStream::pair()?;
        send_pipe(&socket, stdin)?;
        let its_stdin = Stdio::from(OwnedFd::from(its_socket));
        let mut guard = command.process_group(0).stdin(its_stdin).spawn()?;
        // Closes our copy of the guard's end, so that the end of the guard ends the stream.
        command.stdin(Stdio::null());
        let mut started = [0; 4];
        let answer = socket.read_exact(&mut started).map_err(|_| ended());
        let mouse = answer.and_then(|()| match i32::from_ne_bytes(started) {
            error @ ..0 => Err(io::Error::from_raw_os_error(-error)),
            id => Pid::from_raw(id).ok_or_else(ended),
        });
        let mouse = mouse.inspect_err(|_| {
            // It has no mouse.
            let _ = guard.kill().and_then(|()| guard.wait());
        })?;
        socket.set_nonblocking(true)?;
        Ok((guard, Self { socket, mouse, status: None }))
    }

    /// Returns the exit status of the mouse if it has exited.
    pub(crate) fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        let mut status = [0; 4];
        if self.status.is_none() {
            match self.socket.read(&mut status) {
                Ok(4) => self.status = Some(ExitStatus::from_raw(i32::from_ne_bytes(status))),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Ok(_) | Err(_) => return Err(ended()),
            }
        }
        Ok(self.status)
    }

    /// Makes the guard kill the mouse and its descendants.
    pub(crate) fn kill(&self) {
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    /// Waits for the end of the mouse and its descendants, which were killed.
    pub(crate) fn wait(&self, guard: &mut Child) {
        // The mouse may have stopped it.
        let _ = kill_process(Pid::from_child(guard), Signal::CONT);
        if !guard.wait().is_ok_and(|status| status.success()) {
            // Somebody has killed the guard.
            let _ = kill_process_group(self.mouse, Signal::KILL);
        }
    }
}

fn ended() -> io::Error {
    io::Error::other("its guard process has ended")
}

/// Sends the pipe from which the mouse reads.
fn send_pipe(socket: &UnixStream, pipe: Option<&PipeReader>) -> io::Result<()> {
    let mut space = [MaybeUninit::uninit(); cmsg_space!(ScmRights(1))];
    let mut message = SendAncillaryBuffer::new(&mut space);
    let pipe = pipe.map(AsFd::as_fd);
    if pipe.is_some() {
        message.push(SendAncillaryMessage::ScmRights(pipe.as_slice()));
    }
    sendmsg(socket, &[IoSlice::new(&[0])], &mut message, SendFlags::empty())?;
    Ok(())
}

fn receive_pipe(socket: &UnixStream) -> io::Result<Option<OwnedFd>> {
    let mut space = [MaybeUninit::uninit(); cmsg_space!(ScmRights(1))];
    let mut message = RecvAncillaryBuffer::new(&mut space);
    recvmsg(socket, &mut [IoSliceMut::new(&mut [0])], &mut message, RecvFlags::empty())?;
    let pipe = message.drain().find_map(|part| match part {
        RecvAncillaryMessage::ScmRights(mut pipes) => pipes.next(),
        _ => None,
    });
    // The copy is closed on exec, the received descriptor is not.
    pipe.map(|pipe| pipe.try_clone()).transpose()
}

/// Starts the mouse and guards it. Returns an error if a descendant may live on.
fn run(mut command: impl Iterator<Item = OsString>) -> io::Result<()> {
    let mut socket = UnixStream::from(rustix::stdio::stdin().try_clone_to_owned()?);
    let stdin = receive_pipe(&socket)?.map_or_else(Stdio::null, Stdio::from);
    // Makes the guard the parent of descendants whose parents exit. Without this, those in the process
    // group of the mouse are still killed.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_child_subreaper(Some(rustix::process::getpid()));
    let (mut exits, exit) = UnixStream::pair()?;
    exits.set_nonblocking(true)?;
    signal_hook::low_level::pipe::register(signal_hook::consts::SIGCHLD, exit)?;
    let null = File::options().write(true).open("/dev/null")?;
    let program = command.next().unwrap_or_default();
    let mouse = Command::new(program).args(command).process_group(0).stdin(stdin).spawn();
    let mouse = match mouse {
        Ok(mouse) => Pid::from_child(&mouse),
        Err(error) => {
            let code = error.raw_os_error().unwrap_or(Errno::INVAL.raw_os_error());
            return socket.write_all(&(-code).to_ne_bytes());
        }
    };
    // Only the mouse may keep its streams open. From here on, an error must not end the guard before
    // the mouse.
    let closed = rustix::stdio::dup2_stdout(&null).and_then(|()| rustix::stdio::dup2_stderr(&null));
    // If nobody reads, the socket is closed.
    let _ = socket.write_all(&mouse.as_raw_pid().to_ne_bytes());
    let (mut is_ending, mut is_reaped) = (closed.is_err(), false);
    loop {
        let has_children = reap(|process, status| {
            if process == mouse {
                is_reaped = true;
                let _ = socket.write_all(&status.as_raw().to_ne_bytes());
            }
        });
        if is_ending {
            if !has_children {
                return Ok(());
            }
            kill_children(mouse)?;
        }
        let mut ready = [&socket, &exits].map(|socket| PollFd::new(socket, PollFlags::IN));
        let watched = if is_ending { &mut ready[1..] } else { &mut ready };
        let _ = poll(watched, is_ending.then_some(&KILL_INTERVAL));
        if !is_ending && !ready[0].revents().is_empty() {
            is_ending = true;
            // All at once, so that a mouse that forks without end cannot outrun the guard.
            if !is_reaped || cfg!(not(target_os = "linux")) {
                let _ = kill_process_group(mouse, Signal::KILL);
            }
        }
        while exits.read(&mut [0; 64]).is_ok_and(|length| length > 0) {}
    }
}

/// Reaps the children that have exited. Returns false if there are no more children.
fn reap(mut exited: impl FnMut(Pid, WaitStatus)) -> bool {
    loop {
        match wait(WaitOptions::NOHANG) {
            Ok(Some((process, status))) => exited(process, status),
            Err(Errno::INTR) => {}
            Ok(None) => return true,
            Err(_) => return false,
        }
    }
}

/// Kills the children. Their children are then children of this process. Returns an error if the
/// system does not permit killing any of them, or cannot list them.
#[cfg(target_os = "linux")]
fn kill_children(_mouse: Pid) -> io::Result<()> {
    let children = std::fs::read_to_string("/proc/thread-self/children")?;
    let children = children.split_whitespace().filter_map(|id| Pid::from_raw(id.parse().ok()?));
    let killed: Vec<_> = children.map(|child| kill_process(child, Signal::KILL)).collect();
    let is_refused = !killed.is_empty() && killed.iter().all(|it| *it == Err(Errno::PERM));
    if is_refused { Err(Errno::PERM.into()) } else { Ok(()) }
}

/// Kills the mouse, the only child.
#[cfg(not(target_os = "linux"))]
fn kill_children(mouse: Pid) -> io::Result<()> {
    Ok(kill_process(mouse, Signal::KILL)?)
}
