//! A mouse that is a program: its command line, its process and its exit.

use std::ffi::{OsStr, OsString};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::{env, iter};

use mmsim_maze::needs_escape;
use mmsim_protocol::MAX_NAME_BYTES;

/// The command line of a mouse.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    /// The program and its arguments.
    command: Vec<OsString>,
    /// The existing files that the command line names, without installed programs.
    pub(crate) files: Vec<PathBuf>,
    /// The name of the first file, such as `Main.py`. If there are no files, the file name of the
    /// program and its arguments.
    pub(crate) name: String,
}

impl Program {
    pub(crate) fn new(command: &[OsString]) -> Self {
        let program = command.first().map_or(Path::new(""), Path::new);
        let own = iter::once(program).filter(|program| !is_installed(program));
        let arguments = command.iter().skip(1).map(Path::new);
        let files = own.chain(arguments).filter(|path| path.is_file());
        let files: Vec<PathBuf> = files.map(Path::to_path_buf).collect();
        let mut name = if let Some(file) = files.first().and_then(|file| file.file_name()) {
            file.to_string_lossy().into_owned()
        } else {
            let program = program.file_name().unwrap_or_default();
            let words = iter::once(program).chain(command.iter().skip(1).map(AsRef::as_ref));
            words.map(OsStr::to_string_lossy).collect::<Vec<_>>().join(" ")
        };
        name.retain(|c| !needs_escape(c));
        cut(&mut name, MAX_NAME_BYTES);
        Self { command: command.to_vec(), files, name }
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

/// Returns true for a program that is found on the `PATH`, such as an interpreter.
fn is_installed(program: &Path) -> bool {
    match program.parent() {
        Some(folder) if folder != Path::new("") => {
            let folders = env::var_os("PATH").unwrap_or_default();
            env::split_paths(&folders).any(|installed| installed == folder)
        }
        _ => true,
    }
}

/// Shortens a text to at most this number of bytes.
pub(crate) fn cut(text: &mut String, max_bytes: usize) {
    let end = (0..=max_bytes.min(text.len())).rev().find(|&end| text.is_char_boundary(end));
    text.truncate(end.unwrap_or(0));
}

/// A running mouse. Dropping it kills the process and, on Unix, its child processes.
pub(crate) struct MouseProcess(pub(crate) Child);

impl MouseProcess {
    pub(crate) fn start(command: &mut Command) -> Result<Self, String> {
        // The mouse gets a process group, so its child processes can be killed too.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        command.spawn().map(Self).map_err(|error| {
            let needs_path =
                " (if the program is not on the PATH, give its path, for example: -- ./my-mouse)";
            let hint = if error.kind() == ErrorKind::NotFound { needs_path } else { "" };
            format!("cannot start the mouse {}: {error}{hint}", command.get_program().display())
        })
    }

    /// Returns the exit status of the mouse if it has exited.
    pub(crate) fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        self.0.try_wait()
    }
}

impl Drop for MouseProcess {
    fn drop(&mut self) {
        #[cfg(unix)]
        if let Some(group) = rustix::process::Pid::from_raw(self.0.id().cast_signed()) {
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns the exit code of the mouse, or 128 plus the number of the signal that killed the mouse.
pub(crate) fn exit_code(status: ExitStatus) -> i32 {
    status.code().or_else(|| Some(128 + signal(status)?)).unwrap_or(1)
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn program(command: &[&str]) -> Program {
        Program::new(&command.iter().map(OsString::from).collect::<Vec<_>>())
    }

    #[test]
    fn the_name_and_the_files_are_those_of_the_mouse() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| {
            let path = folder.path().join(name);
            fs::write(&path, "").unwrap();
            path.to_str().unwrap().to_string()
        };
        let (mouse, maze) = (file("mouse.py"), file("maze.txt"));
        let script = program(&["python3", "-u", &mouse, &maze]);
        assert_eq!((&*script.name, script.files.len()), ("mouse.py", 2));
        let own = program(&[&mouse, "--fast"]);
        assert_eq!((&*own.name, &own.files), ("mouse.py", &vec![PathBuf::from(&mouse)]));
        assert_eq!(program(&[&mouse, &maze]).name, "mouse.py");
        let other = program(&["/opt/jdk/java", "Mouse", "--style=fast\u{1b}[2J"]);
        assert_eq!((&*other.name, other.files.len()), ("java Mouse --style=fast[2J", 0));
        assert_eq!(program(&[&"\u{e9}".repeat(80)]).name, "\u{e9}".repeat(50));
        #[cfg(unix)]
        assert_eq!(program(&["/bin/sh", &mouse]).name, "mouse.py");
    }

    #[test]
    fn placeholders_are_replaced_in_arguments() {
        let command =
            program(&["{e}", "--to={e}", "x"]).with_argument("{e}", "tcp://a:1").command();
        assert_eq!(command.get_program(), "{e}");
        assert!(command.get_args().eq(["--to=tcp://a:1", "x"]));
    }
}
