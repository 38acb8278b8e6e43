//! A mouse that is a program: its command line, its process and its exit.

use std::ffi::{OsStr, OsString};
use std::io::{self, BufRead, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::Duration;
use std::{env, iter, mem};

use mmsim_maze::{Escaped, needs_escape};
use mmsim_protocol::MAX_NAME_BYTES;
use mmsim_viewer::{MouseControl, StopReason};

use crate::interrupt::Interrupt;
use crate::mms::child::MAX_LINE_BYTES;
use crate::process_group::ProcessGroup;

/// The maximum interval between checks whether a mouse has exited.
const MAX_POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The maximum time to wait for the last line of stderr of a process that has exited.
pub(crate) const LAST_LINE_TIMEOUT: Duration = Duration::from_millis(500);

/// The maximum length of the last line of stderr in an error message, in bytes.
const MAX_REASON_BYTES: usize = 200;

/// The command line of a mouse.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Program {
    /// The program and its arguments.
    command: Vec<OsString>,
    /// The file of the mouse: the program itself or, for an installed program such as an
    /// interpreter, the first argument that is a file. `None` if there is no such file.
    pub(crate) file: Option<PathBuf>,
    /// The name of the file, such as `Main.py`. If there is no file, the file name of the program
    /// and its arguments.
    pub(crate) name: String,
}

impl Program {
    pub(crate) fn new(command: &[OsString]) -> Self {
        let program = command.first().map_or(Path::new(""), Path::new);
        let file = if is_installed(program) {
            command.iter().skip(1).map(Path::new).find(|path| path.is_file())
        } else {
            Some(program).filter(|path| path.is_file())
        };
        let mut name = if let Some(file) = file.and_then(Path::file_name) {
            file.to_string_lossy().into_owned()
        } else {
            let program = program.file_name().unwrap_or_default();
            let words = iter::once(program).chain(command.iter().skip(1).map(AsRef::as_ref));
            words.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
        };
        name.retain(|c| !needs_escape(c));
        cut(&mut name, MAX_NAME_BYTES);
        Self { command: command.to_vec(), file: file.map(Path::to_path_buf), name }
    }

    /// Returns the path of the program if it is not installed and does not exist.
    pub(crate) fn missing_file(&self) -> Option<&Path> {
        let program = self.command.first().map(Path::new)?;
        (!is_installed(program) && !program.exists()).then_some(program)
    }

    /// Returns the command.
    pub(crate) fn command(&self) -> Command {
        let (program, arguments) = self.command.split_first().unzip();
        let mut command = Command::new(program.map_or(OsStr::new(""), OsString::as_os_str));
        command.args(arguments.unwrap_or_default());
        command
    }

    /// Replaces each `placeholder` in the arguments.
    pub(crate) fn with_argument(&self, placeholder: &str, replacement: &str) -> Self {
        let replace = |argument: &OsString| match argument.to_str() {
            Some(text) => text.replace(placeholder, replacement).into(),
            None => argument.clone(),
        };
        let (program, arguments) = self.command.split_first().unzip();
        let arguments = arguments.unwrap_or_default().iter().map(replace);
        let command = program.cloned().into_iter().chain(arguments).collect();
        Self { command, ..self.clone() }
    }
}

/// Returns true for a program on the `PATH` and for a program of a Python virtual environment, which
/// is usually a link to a Python interpreter.
fn is_installed(program: &Path) -> bool {
    let Some(folder) = program.parent().filter(|&folder| folder != Path::new("")) else {
        return true;
    };
    let folders = env::var_os("PATH").unwrap_or_default();
    let is_on_path = env::split_paths(&folders).any(|installed| installed == folder);
    is_on_path || folder.join("../pyvenv.cfg").is_file()
}

/// Shortens a text to at most this number of bytes.
pub(crate) fn cut(text: &mut String, max_bytes: usize) {
    let end = (0..=max_bytes.min(text.len())).rev().find(|&end| text.is_char_boundary(end));
    text.truncate(end.unwrap_or(0));
}

/// A running mouse. Dropping it kills the process and its child processes.
pub(crate) struct MouseProcess(pub(crate) Child, ProcessGroup);

impl MouseProcess {
    pub(crate) fn start(command: &mut Command) -> Result<Self, String> {
        ProcessGroup::spawn(command).map(|(child, group)| Self(child, group)).map_err(|error| {
            let needs_path =
                " (if the program is not on the PATH, give its path, such as ./my-mouse)";
            let hint = if error.kind() == ErrorKind::NotFound { needs_path } else { "" };
            format!("cannot start the mouse {}: {error}{hint}", command.get_program().display())
        })
    }

    /// Returns the exit status of the mouse if it has exited.
    pub(crate) fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }

    /// Kills the process and its child processes, which may keep its pipes open after it has exited.
    pub(crate) fn kill_group(&mut self) {
        self.1.kill();
    }

    /// Waits until the mouse exits. Returns an error as soon as the mouse must stop.
    pub(crate) fn wait(&mut self, control: &MouseControl) -> Result<ExitStatus, WaitError> {
        let mut interval = Duration::from_millis(1);
        loop {
            let status = self.status();
            // Ctrl-C may have reached both processes.
            let wait = if matches!(status, Ok(None)) { interval } else { Duration::ZERO };
            if let Some(reason) = control.wait_for_stop(wait) {
                return Err(WaitError::Stopped(reason));
            }
            match status {
                Ok(Some(status)) => return Ok(status),
                Ok(None) => interval = MAX_POLL_INTERVAL.min(2 * interval),
                Err(error) => return Err(WaitError::Failed(error)),
            }
        }
    }
}

/// The reason why waiting for a mouse ended before the mouse exited.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WaitError {
    #[error("{}", .0.text())]
    Stopped(StopReason),
    #[error("cannot get the exit status of the mouse: {0}")]
    Failed(io::Error),
}

impl Drop for MouseProcess {
    fn drop(&mut self) {
        self.kill_group();
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns the exit code of the mouse, or 128 plus the number of the signal that killed the mouse.
pub(crate) fn exit_code(status: ExitStatus) -> i32 {
    status.code().or_else(|| Some(128 + signal(status)?)).unwrap_or(1)
}

/// Returns the exit code of this process after a run that was stopped for this reason.
pub(crate) fn stop_code(reason: StopReason) -> i32 {
    if reason == StopReason::Exit { Interrupt::CODE } else { 1 }
}

/// Returns a description such as `exited with code 0`.
pub(crate) fn exit_text(status: ExitStatus) -> String {
    match signal(status) {
        Some(signal) => format!("killed by signal {signal}"),
        None => format!("exited with code {}", exit_code(status)),
    }
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

/// Reads to the end and returns the last line that is not blank, without control characters.
pub(crate) fn read_last_line(mut input: impl BufRead) -> String {
    let (mut last, mut line) = (Vec::new(), Vec::new());
    loop {
        line.clear();
        let read = input.by_ref().take(MAX_LINE_BYTES as u64).read_until(b'\n', &mut line);
        if !matches!(read, Ok(1..)) {
            break;
        }
        if !line.trim_ascii().is_empty() {
            mem::swap(&mut last, &mut line);
        }
    }
    let mut text = Escaped(String::from_utf8_lossy(last.trim_ascii())).to_string();
    cut(&mut text, MAX_REASON_BYTES);
    text
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn program(command: &[&str]) -> Program {
        Program::new(&command.iter().map(OsString::from).collect::<Vec<_>>())
    }

    /// Creates an empty file and returns its path.
    fn create(folder: &tempfile::TempDir, name: &str) -> String {
        let path = folder.path().join(name);
        fs::write(&path, "").unwrap();
        path.to_str().unwrap().to_string()
    }

    /// Asserts that a command runs the mouse in this file, whose name is that of the mouse.
    fn assert_file(command: &[&str], file: &str) {
        let found = program(command);
        assert_eq!(found.file.as_deref(), Some(Path::new(file)), "{command:?}");
        assert_eq!(found.name, Path::new(file).file_name().unwrap().to_str().unwrap());
        assert_eq!(found.missing_file(), None);
    }

    #[test]
    fn the_name_and_the_file_are_those_of_the_mouse() {
        let folder = tempfile::tempdir().unwrap();
        let (mouse, maze) = (create(&folder, "mouse.py"), create(&folder, "maze.txt"));
        assert_file(&["python3", "-u", &mouse, &maze], &mouse);
        assert_file(&[&mouse, "--fast"], &mouse);
        // The mouse may write to its arguments.
        assert_file(&[&mouse, &maze], &mouse);
        #[cfg(unix)]
        assert_file(&["/bin/sh", &mouse], &mouse);
        let other = program(&["/opt/jdk/java", "Mouse", "--style=fast\u{1b}[2J"]);
        assert_eq!((&*other.name, other.file), ("java Mouse --style=fast[2J", None));
        assert_eq!(program(&[&"\u{e9}".repeat(80)]).name, "\u{e9}".repeat(50));
        let missing = program(&["./no-such-mouse", &maze]);
        assert_eq!((&missing.file, missing.name.starts_with("no-such-mouse ")), (&None, true));
        assert_eq!(missing.missing_file(), Some(Path::new("./no-such-mouse")));
        assert_eq!(program(&["no-such-mouse"]).missing_file(), None, "may be on the PATH");
    }

    #[cfg(unix)]
    #[test]
    fn an_interpreter_of_a_virtual_environment_is_not_the_mouse() {
        let folder = tempfile::tempdir().unwrap();
        let mouse = create(&folder, "mouse.py");
        let bin = folder.path().join("bin");
        fs::create_dir(&bin).unwrap();
        let python = bin.join("python");
        std::os::unix::fs::symlink("/bin/sh", &python).unwrap();
        let python = python.to_str().unwrap();
        assert_file(&[python, &mouse], python);
        create(&folder, "pyvenv.cfg");
        assert_file(&[python, &mouse], &mouse);
    }

    #[test]
    fn placeholders_are_replaced_in_arguments() {
        let command =
            program(&["{e}", "--to={e}", "x"]).with_argument("{e}", "tcp://a:1").command();
        assert_eq!(command.get_program(), "{e}");
        assert!(command.get_args().eq(["--to=tcp://a:1", "x"]));
    }
}
