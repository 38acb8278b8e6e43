//! The command line of a mouse, and what to try if it starts no program.

use std::ffi::{OsStr, OsString};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, iter};

use mmsim_maze::needs_escape;
use mmsim_protocol::MAX_NAME_BYTES;

use crate::process::cut;
use crate::published::{is_python, python_for};

/// The command line of a mouse.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The program and its arguments.
    command: Vec<OsString>,
    /// The file of the mouse: the program itself or, for an installed program such as an
    /// interpreter, the first argument that is a file. `None` if there is no such file.
    pub file: Option<PathBuf>,
    /// The name of the file, such as `Main.py`. If there is no file, the file name of the program
    /// and its arguments.
    pub name: String,
}

impl Program {
    /// Returns the mouse that a command line starts. A Python file that is not executable, or named
    /// without a folder, is run by the Python in which it has the fewest faults.
    pub fn new(command: &[OsString]) -> Self {
        if let Some(file) = command.first().map(Path::new)
            && is_python(file)
            && file.is_file()
            && (!is_executable(file) || file.components().count() == 1)
            && let Some(python) = python_for(file)
        {
            let name = file.file_name().unwrap_or_default();
            return Self::named([&python[..], command].concat(), Some(file), &[name]);
        }
        let program = command.first().map_or(Path::new(""), Path::new);
        let file = if is_installed(program) {
            command.iter().skip(1).map(Path::new).find(|path| path.is_file())
        } else {
            Some(program).filter(|path| path.is_file())
        };
        let words: Vec<&OsStr> = if let Some(name) = file.and_then(Path::file_name) {
            vec![name]
        } else {
            let program = program.file_name().unwrap_or_default();
            iter::once(program).chain(command.iter().skip(1).map(AsRef::as_ref)).collect()
        };
        Self::named(command.to_vec(), file, &words)
    }

    /// Returns the mouse in a file, with the words of its name.
    pub(crate) fn named(command: Vec<OsString>, file: Option<&Path>, words: &[&OsStr]) -> Self {
        let mut name = words.join(OsStr::new(" ")).to_string_lossy().into_owned();
        name.retain(|c| !needs_escape(c));
        cut(&mut name, MAX_NAME_BYTES);
        Self { command, file: file.map(Path::to_path_buf), name }
    }

    /// Returns the path of the program if it is not installed and does not exist.
    pub fn missing_file(&self) -> Option<&Path> {
        let program = self.command.first().map(Path::new)?;
        (!is_installed(program) && !program.exists()).then_some(program)
    }

    /// Returns the program and its arguments.
    pub(crate) fn words(&self) -> &[OsString] {
        &self.command
    }

    /// Returns the command.
    pub fn command(&self) -> Command {
        let (program, arguments) = self.command.split_first().unzip();
        let mut command = Command::new(program.map_or(OsStr::new(""), OsString::as_os_str));
        command.args(arguments.unwrap_or_default());
        command
    }

    /// Replaces each `placeholder` in the arguments.
    pub fn with_argument(&self, placeholder: &str, replacement: &str) -> Self {
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

/// Returns true if the system can run the file.
#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    file.metadata().is_ok_and(|file| file.permissions().mode() & 0o111 != 0)
}

/// Returns true if the system can run the file.
#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    let extension = file.extension().unwrap_or_default();
    ["exe", "com", "bat", "cmd"].iter().any(|name| extension.eq_ignore_ascii_case(name))
}

/// Returns what to try if a program cannot be started.
pub(crate) fn start_hint(error: &io::Error, file: &Path) -> String {
    let shown = file.display();
    let before = format!("if it is a maze, put --maze {shown} before the command");
    if file.is_dir() || shown.to_string().ends_with('/') {
        return format!(" (not a program; {before})");
    }
    if file.is_file() && !is_executable(file) {
        return if is_python(file) {
            " (found no Python to run it)".into()
        } else if cfg!(unix) {
            format!(" (not executable: chmod +x {shown}; {before})")
        } else {
            format!(" (not a program; {before})")
        };
    }
    match error.kind() {
        ErrorKind::NotFound if file.is_file() && file.components().count() == 1 => {
            format!(" (give its path: ./{shown})")
        }
        ErrorKind::NotFound => {
            " (if the program is not on the PATH, give its path, such as ./my-mouse)".into()
        }
        // A script without an interpreter.
        _ if file.is_file() => {
            " (a script needs a first line such as #!/usr/bin/env python3)".into()
        }
        _ => String::new(),
    }
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
