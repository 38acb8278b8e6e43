//! A program as a mouse: its command line, its process with all child processes, and its exit.

use std::io::{self, BufRead, BufReader, ErrorKind, PipeReader, PipeWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};
use std::{env, thread};

use mmsim_client::RunError;
use mmsim_maze::Escaped;
use mmsim_protocol::CRASH_PREFIX;
use mmsim_run::{Cause, EndFacts, Ending, Exit, Goal, Judge, Phases, Verdict};

use crate::commands::MAX_LINE_BYTES;
use crate::control::{MouseControl, Outcome, StopReason};
use crate::program::{Program, start_hint};
use crate::{ENDPOINT_PLACEHOLDER, ENDPOINT_VARIABLE};

/// The maximum size of the output of a command that is read, in bytes.
const MAX_OUTPUT_BYTES: u64 = 1 << 16;

/// The maximum interval between checks whether a mouse has exited or must stop.
pub(crate) const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// The maximum time to wait for the last line of stderr of a process that has exited.
const LAST_LINE_TIMEOUT: Duration = Duration::from_millis(500);

/// The maximum length of the last line of stderr in an error message, in bytes.
const MAX_REASON_BYTES: usize = 200;

/// The variable that makes Python write to a pipe at once. Otherwise, a mouse that is killed loses what it
/// has written.
const UNBUFFERED: &str = "PYTHONUNBUFFERED";

/// Shortens a text to at most this number of bytes.
pub(crate) fn cut(text: &mut String, max_bytes: usize) {
    let end = (0..=max_bytes.min(text.len())).rev().find(|&end| text.is_char_boundary(end));
    text.truncate(end.unwrap_or(0));
}

/// A shortage of the system, such as too many open files. It says nothing about the mouse.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Shortage(pub String);

/// The reason why a mouse could not start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartError {
    /// The program cannot be run.
    #[error("{0}")]
    Mouse(String),
    /// The system lacks something that the mouse needs.
    #[error(transparent)]
    Shortage(Shortage),
}

/// Converts a failure of this process, which is no fault of the mouse.
impl From<String> for StartError {
    fn from(text: String) -> Self {
        Self::Shortage(Shortage(text))
    }
}

impl From<StartError> for String {
    fn from(error: StartError) -> Self {
        error.to_string()
    }
}

/// Returns true if the system lacks memory, processes or open files, or if the guard of the mouse has
/// failed.
fn is_shortage(error: &io::Error) -> bool {
    #[cfg(unix)]
    let too_many_files = [rustix::io::Errno::MFILE, rustix::io::Errno::NFILE]
        .map(|errno| Some(errno.raw_os_error()))
        .contains(&error.raw_os_error());
    // The codes of too many open files, and of too few resources or too little virtual memory.
    #[cfg(windows)]
    let too_many_files = matches!(error.raw_os_error(), Some(4 | 1450 | 1455));
    too_many_files
        || matches!(error.kind(), ErrorKind::OutOfMemory | ErrorKind::WouldBlock | ErrorKind::Other)
}

/// A running mouse. Dropping it kills the process and its descendants.
#[derive(Debug)]
pub struct MouseProcess {
    /// The mouse or, if the mouse has a guard, the guard.
    child: Child,
    group: system::Group,
}

impl MouseProcess {
    /// Starts a mouse that reads nothing from its stdin. In its environment and in place of
    /// `{endpoint}` in its arguments, it finds the address of the simulator.
    ///
    /// # Errors
    /// Returns the reason if the mouse cannot start.
    pub fn start(program: &Program, endpoint: &str) -> Result<Self, StartError> {
        Self::spawn(program, Some(endpoint), None, [Stdio::inherit(), Stdio::inherit()])
    }

    /// Starts a mouse that reads from a pipe and writes to another one.
    pub(crate) fn start_piped(
        program: &Program,
        endpoint: Option<&str>,
        stderr: Stdio,
    ) -> Result<(Self, PipeWriter, ChildStdout), StartError> {
        let pipe_error = |error| format!("cannot open the pipes of the mouse: {error}");
        let (reader, stdin) = io::pipe().map_err(pipe_error)?;
        let streams = [Stdio::piped(), stderr];
        let mut process = Self::spawn(program, endpoint, Some(reader), streams)?;
        let stdout = process.child.stdout.take();
        let stdout = stdout.ok_or_else(|| pipe_error(ErrorKind::BrokenPipe.into()))?;
        Ok((process, stdin, stdout))
    }

    fn spawn(
        program: &Program,
        endpoint: Option<&str>,
        stdin: Option<PipeReader>,
        streams: [Stdio; 2],
    ) -> Result<Self, StartError> {
        let mut command = program.command();
        if let Some(endpoint) = endpoint {
            command = program.with_argument(ENDPOINT_PLACEHOLDER, endpoint).command();
            command.env(ENDPOINT_VARIABLE, endpoint);
        }
        if stdin.is_some() && env::var_os(UNBUFFERED).is_none() {
            command.env(UNBUFFERED, "1");
        }
        system::spawn(command, stdin, streams).map(|(child, group)| Self { child, group }).map_err(
            |error| {
                let command = program.command();
                let file = Path::new(command.get_program());
                let hint = start_hint(&error, file);
                let text = format!("cannot start the mouse {}: {error}{hint}", file.display());
                if is_shortage(&error) { text.into() } else { StartError::Mouse(text) }
            },
        )
    }

    /// Returns the stderr of the mouse if it is a pipe.
    pub(crate) fn take_stderr(&mut self) -> Option<ChildStderr> {
        self.child.stderr.take()
    }

    /// Returns the exit status of the mouse if it has exited, or a message if there is no status.
    pub(crate) fn status(&mut self) -> Result<Option<ExitStatus>, String> {
        let status = system::status(&mut self.child, &mut self.group);
        status.map_err(|error| format!("cannot get the exit status of the mouse: {error}"))
    }

    /// Kills the process and its descendants, which may keep its pipes open after it has exited.
    pub(crate) fn kill_group(&mut self) {
        system::kill(&mut self.group);
    }

    /// Waits until the mouse exits or must stop.
    pub fn wait(&mut self, control: &MouseControl) -> ExitCause {
        let mut interval = Duration::from_millis(1);
        loop {
            let status = self.status();
            // Ctrl-C may have reached both processes.
            let wait = if matches!(status, Ok(None)) { interval } else { Duration::ZERO };
            if let Some(reason) = control.wait_for_stop(wait) {
                return ExitCause::Stopped(reason);
            }
            match status {
                Ok(Some(status)) => return ExitCause::Exited(status),
                Ok(None) => interval = CHECK_INTERVAL.min(2 * interval),
                Err(error) => return ExitCause::Failed(error),
            }
        }
    }
}

impl Drop for MouseProcess {
    fn drop(&mut self) {
        system::end(&mut self.child, &mut self.group);
    }
}

/// The reason why a mouse is not running.
#[derive(Debug)]
pub enum ExitCause {
    /// It has exited.
    Exited(ExitStatus),
    /// It exceeded this number of turns and cells.
    Limit(u32),
    /// It was stopped.
    Stopped(StopReason),
    /// The simulator failed.
    LostSimulator(RunError),
    /// It could not start.
    NotStarted(String),
    /// It could not go on.
    Failed(String),
}

impl From<RunError> for ExitCause {
    fn from(error: RunError) -> Self {
        let may_be_misread = match &error {
            RunError::Refused { reason, .. } => reason.starts_with(CRASH_PREFIX),
            RunError::Contradiction(_) => true,
            _ => false,
        };
        if may_be_misread {
            let hint =
                "if the simulator misreads walls, use mmsim run --misread instead of --connect";
            return Self::Failed(format!("{error} ({hint})"));
        }
        Self::LostSimulator(error)
    }
}

impl ExitCause {
    /// Returns an error if the mouse must stop.
    pub(crate) fn check(control: &MouseControl) -> Result<(), Self> {
        control.wait_for_stop(Duration::ZERO).map_or(Ok(()), |reason| Err(Self::Stopped(reason)))
    }

    /// Adds how the run ended to what the mouse sent.
    pub(crate) fn add_to(&self, sent: EndFacts) -> EndFacts {
        let (_, ending, _) = self.describe();
        let exit = match self {
            Self::Exited(status) => exit_failure(*status),
            _ => None,
        };
        EndFacts { ending, exit, ..sent }
    }

    /// Returns the reason in words, how the run ended, and the exit code.
    fn describe(&self) -> (String, Ending, i32) {
        match self {
            Self::Exited(status) => {
                let ending = if status.success() { Ending::Finished } else { Ending::Failed };
                (exit_text(*status), ending, exit_code(*status))
            }
            Self::Limit(limit) => {
                (format!("stopped: exceeded --limit {limit}"), Ending::StepLimit, 1)
            }
            Self::Stopped(reason) => (reason.text(), reason.ending(), reason.exit_code()),
            Self::LostSimulator(error) => (format!("stopped: {error}"), Ending::Failed, 1),
            Self::NotStarted(error) => (error.clone(), Ending::Failed, 1),
            Self::Failed(error) => (format!("stopped: {error}"), Ending::Failed, 1),
        }
    }

    /// Returns the end of the run of a mouse that did this. `details` follow the words about the goal. The
    /// judge, who has seen the same states, and the facts decide the cause of a failure.
    pub fn end(
        &self,
        phases: &Phases,
        details: &str,
        judge: Option<&Judge>,
        facts: &EndFacts,
    ) -> RunEnd {
        let (how, ending, code) = self.describe();
        let judge = judge.filter(|_| !phases.is_goal_reached());
        let cause = judge.and_then(|judge| judge.cause(facts));
        let error = Some(how.clone()).filter(|_| ending != Ending::Finished);
        let verdict = Verdict::new(phases, ending, error, cause);
        let was_started = !matches!(self, Self::NotStarted(_));
        let text = if was_started {
            let is_reached = verdict.goal_reached;
            let goal = Goal { is_reached, error: None };
            let (how, why) = match (phases.jump_error(), verdict.cause) {
                (Some(jump), _) => (how, format!(": {jump}")),
                (None, Some(exited @ Cause::Exited { .. })) => (exited.to_string(), String::new()),
                (None, Some(cause)) => (how, format!(": {cause}")),
                (None, None) => (how, String::new()),
            };
            format!("{how}; {goal}{details}{why}")
        } else {
            how
        };
        let code = if verdict.ending == Ending::Failed && code == 0 { 1 } else { code };
        RunEnd { outcome: Outcome { verdict, text }, code, was_started }
    }
}

/// The end of one run.
#[derive(Debug)]
pub struct RunEnd {
    /// The outcome.
    pub outcome: Outcome,
    /// The exit code of this process if no further run follows: the exit code of the mouse, 128 plus
    /// the number of the signal that killed the mouse, 130 after Ctrl-C, or 1 in all other cases, for
    /// example if the mouse has jumped.
    pub code: i32,
    /// False if the mouse could not start.
    pub was_started: bool,
}

/// Returns the exit code of a mouse, or 128 plus the number of the signal that killed it.
fn exit_code(status: ExitStatus) -> i32 {
    status.code().or_else(|| Some(128 + signal(status)?)).unwrap_or(1)
}

/// Returns how a process ended.
fn exit(status: ExitStatus) -> Exit {
    match signal(status) {
        Some(signal) => Exit::Signal(signal),
        None => Exit::ExitCode(exit_code(status)),
    }
}

/// Returns how a process failed, or `None` if it succeeded.
pub fn exit_failure(status: ExitStatus) -> Option<Exit> {
    (!status.success()).then(|| exit(status))
}

/// Returns a description such as `exited with code 0`.
pub fn exit_text(status: ExitStatus) -> String {
    exit(status).to_string()
}

/// Returns the signal that killed a process.
#[cfg(unix)]
pub(crate) fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
pub(crate) const fn signal(_: ExitStatus) -> Option<i32> {
    None
}

/// The last line that a mouse writes to stderr.
#[derive(Debug)]
pub(crate) struct LastLine(Receiver<String>);

impl LastLine {
    /// Reads the stderr of a mouse from now on. If `is_copied` is true, copies it to the stderr of this
    /// process.
    pub(crate) fn from_process(
        process: &mut MouseProcess,
        is_copied: bool,
    ) -> Result<Self, String> {
        let (sender, line) = mpsc::channel();
        if let Some(stderr) = process.take_stderr() {
            let copy = is_copied.then(io::stderr);
            spawn("stderr", move || {
                // Nobody may be interested in it.
                let _ = sender.send(read_last_line(stderr, copy));
            })?;
        }
        Ok(Self(line))
    }

    /// Returns the line of a mouse that has exited, or an empty string.
    pub(crate) fn get(&self) -> String {
        self.0.recv_timeout(LAST_LINE_TIMEOUT).unwrap_or_default()
    }
}

/// Runs a command with an empty stdin, and kills it and its descendants after `limit`. Returns its
/// stdout if it succeeds before, or else `None`.
pub(crate) fn output(command: Command, limit: Duration) -> Option<String> {
    let (child, group) = system::spawn(command, None, [Stdio::piped(), Stdio::null()]).ok()?;
    let mut process = MouseProcess { child, group };
    let mut stdout = process.child.stdout.take()?.take(MAX_OUTPUT_BYTES);
    let (sender, output) = mpsc::channel();
    let read = move || {
        let mut bytes = Vec::new();
        let _ = stdout.read_to_end(&mut bytes).map(|_| sender.send(bytes));
    };
    spawn("stdout", read).ok()?;
    let start = Instant::now();
    let status = loop {
        match process.status().ok()? {
            Some(status) => break status,
            None if start.elapsed() < limit => thread::sleep(Duration::from_millis(1)),
            None => return None,
        }
    };
    // Kills what keeps the pipe open.
    drop(process);
    let bytes = output.recv_timeout(LAST_LINE_TIMEOUT).ok().filter(|_| status.success())?;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

/// Starts a thread that ends when a pipe of the mouse ends.
pub(crate) fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), String> {
    let spawned = thread::Builder::new().name(name.into()).spawn(work);
    spawned.map(drop).map_err(|error| format!("cannot start a thread: {error}"))
}

/// Reads to the end and returns the last line that is not blank, without control characters.
fn read_last_line(input: impl Read, mut copy: Option<impl Write>) -> String {
    let (mut input, mut last, mut line) = (BufReader::new(input), Vec::new(), Vec::new());
    while let Ok(read @ [_, ..]) = input.fill_buf() {
        // A terminal that has closed must not stop the mouse.
        let _ = copy.as_mut().map(|copy| copy.write_all(read));
        for piece in read.split_inclusive(|&byte| byte == b'\n') {
            line.extend(&piece[..piece.len().min(MAX_LINE_BYTES.saturating_sub(line.len()))]);
            if !line.trim_ascii().is_empty() {
                last.clone_from(&line);
            }
            if piece.ends_with(b"\n") {
                line.clear();
            }
        }
        let length = read.len();
        input.consume(length);
    }
    let mut text = Escaped(String::from_utf8_lossy(last.trim_ascii())).to_string();
    cut(&mut text, MAX_REASON_BYTES);
    text
}

/// A mouse with a guard or, if this process has none for its mice, a process group.
#[cfg(unix)]
mod system {
    use std::io::{self, PipeReader};
    use std::os::unix::process::CommandExt;
    use std::process::{Child, Command, ExitStatus, Stdio};

    use rustix::process::{Pid, Signal, kill_process_group};

    use crate::guard::{self, Guarded};

    #[derive(Debug)]
    pub(super) enum Group {
        Guarded(Guarded),
        Processes(Pid),
    }

    pub(super) fn spawn(
        mut command: Command,
        stdin: Option<PipeReader>,
        [stdout, stderr]: [Stdio; 2],
    ) -> io::Result<(Child, Group)> {
        if let Some(mut guard) = guard::command(&command) {
            let started = Guarded::start(guard.stdout(stdout).stderr(stderr), stdin.as_ref());
            return started.map(|(guard, guarded)| (guard, Group::Guarded(guarded)));
        }
        command.process_group(0).stdin(stdin.map_or_else(Stdio::null, Stdio::from));
        let child = command.stdout(stdout).stderr(stderr).spawn()?;
        let group = Group::Processes(Pid::from_child(&child));
        Ok((child, group))
    }

    pub(super) fn status(child: &mut Child, group: &mut Group) -> io::Result<Option<ExitStatus>> {
        match group {
            Group::Guarded(guarded) => guarded.status(),
            Group::Processes(_) => child.try_wait(),
        }
    }

    pub(super) fn kill(group: &mut Group) {
        match group {
            Group::Guarded(guarded) => guarded.kill(),
            Group::Processes(leader) => {
                let _ = kill_process_group(*leader, Signal::KILL);
            }
        }
    }

    pub(super) fn end(child: &mut Child, group: &mut Group) {
        kill(group);
        if let Group::Guarded(guarded) = group {
            guarded.wait(child);
        } else {
            let _ = child.kill().and_then(|()| child.wait());
        }
    }
}

#[cfg(windows)]
mod system {
    use std::io::{self, PipeReader};
    use std::os::windows::io::AsRawHandle;
    use std::process::{Child, Command, ExitStatus, Stdio};

    use win32job::{ExtendedLimitInfo, Job};

    /// A job object. Windows kills its processes when its last handle is closed, also if this process
    /// is killed.
    pub(super) type Group = Option<Job>;

    pub(super) fn spawn(
        mut command: Command,
        stdin: Option<PipeReader>,
        [stdout, stderr]: [Stdio; 2],
    ) -> io::Result<(Child, Group)> {
        let mut limits = ExtendedLimitInfo::new();
        let job = Job::create_with_limit_info(limits.limit_kill_on_job_close());
        command.stdin(stdin.map_or_else(Stdio::null, Stdio::from));
        let child = command.stdout(stdout).stderr(stderr).spawn()?;
        // Without a job object, only the process itself can be killed. A job object contains only
        // processes that are started after its first process has been added.
        let job = job.ok().filter(|job| job.assign_process(child.as_raw_handle() as isize).is_ok());
        Ok((child, job))
    }

    pub(super) fn status(child: &mut Child, _: &mut Group) -> io::Result<Option<ExitStatus>> {
        child.try_wait()
    }

    pub(super) fn kill(group: &mut Group) {
        drop(group.take());
    }

    pub(super) fn end(child: &mut Child, group: &mut Group) {
        kill(group);
        let _ = child.kill().and_then(|()| child.wait());
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::*;

    fn program(command: &[&str]) -> Program {
        Program::new(&command.iter().map(OsString::from).collect::<Vec<_>>())
    }

    #[test]
    fn the_last_line_of_stderr_is_read_while_it_is_copied() {
        let long = "y".repeat(2 * MAX_LINE_BYTES);
        for (output, last) in [
            ("", ""),
            ("one\n \n", "one"),
            ("one\ntwo\x1b[2J", "two\\u{1b}[2J"),
            (&format!("one\n{long}\n"), &long[..MAX_REASON_BYTES]),
        ] {
            let mut copy = Vec::new();
            assert_eq!(read_last_line(output.as_bytes(), Some(&mut copy)), last);
            assert_eq!(copy, output.as_bytes());
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_command_that_does_not_end_has_no_output() {
        let run = |script: &str, limit| output(program(&["sh", "-c", script]).command(), limit);
        let limit = Duration::from_secs(60);
        assert_eq!(run("echo 3.11 0", limit), Some("3.11 0\n".into()));
        assert_eq!(run("echo 3.11 0; exit 1", limit), None);
        assert_eq!(run("sleep 1000 & echo 3.11 0", limit), Some("3.11 0\n".into()));
        assert_eq!(run("while :; do echo endless; done", limit), None);
        assert_eq!(run("echo 3.11 0; sleep 1000; echo late", CHECK_INTERVAL), None);
    }

    /// The child process keeps the pipe open, so the pipe ends only if it is killed too.
    #[test]
    fn child_processes_are_killed() {
        let program = if cfg!(windows) {
            program(&["cmd", "/c", "echo started& cmd /c pause"])
        } else {
            program(&["sh", "-c", "echo started; sleep 1000; exit"])
        };
        let (mut process, _stdin, stdout) =
            MouseProcess::start_piped(&program, None, Stdio::inherit()).unwrap();
        let mut output = BufReader::new(stdout);
        let (sender, end) = mpsc::channel();
        thread::spawn(move || {
            let mut line = String::new();
            output.read_line(&mut line).unwrap();
            assert_eq!(line.trim_end(), "started");
            process.kill_group();
            while output.read_line(&mut line).unwrap() > 0 {}
            sender.send(()).unwrap();
        });
        end.recv_timeout(Duration::from_secs(300)).expect("the end of the output");
    }
}
