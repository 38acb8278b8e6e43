//! A robot.py with the published interface of the two-run trial, and the Python that runs it.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::iter;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::process::output;
use crate::program::Program;

/// The time after which an interpreter that does not answer is taken as missing.
const PYTHON_TIMEOUT: Duration = Duration::from_secs(10);

/// The Python program that runs a robot.
const ADAPTER: &str = include_str!("published_robot.py");

/// The Python program that finds the faults of a robot.
const CHECK: &str = include_str!("check_robot.py");

/// The interpreters, in order of preference.
#[cfg(not(windows))]
const PYTHONS: &[&[&str]] = &[&["python3"], &["python"], &["python2.7"], &["python2"]];
#[cfg(windows)]
const PYTHONS: &[&[&str]] = &[&["python"], &["py", "-3"], &["py", "-2"], &["python2"]];

/// The reason why there is no Python to run a robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PythonError {
    /// There is no Python.
    #[error(
        "found neither Python 3 nor Python 2 (install one, or give its path with --python EXE)"
    )]
    NoPython,
    /// There are only interpreters that refuse the syntax of the robot.
    #[error(
        "it is not Python {version} ({error}), and no Python {} was found (install it, or give its \
         path with --python EXE)",
        5 - version
    )]
    OtherPython {
        /// The version of Python that was found, 2 or 3.
        version: u8,
        /// The first syntax error.
        error: String,
    },
}

/// The maximum size of a Python file that is searched for a robot, in bytes.
const MAX_ROBOT_BYTES: u64 = 1 << 20;

impl Program {
    /// Returns true if Python runs a file with a class `Robot` that has the published interface of the
    /// two-run trial.
    pub fn is_published_robot(&self) -> bool {
        let starts_python = self.python().is_none_or(|python| {
            let name = Path::new(python).file_stem().unwrap_or_default().to_string_lossy();
            let name = name.to_ascii_lowercase();
            name == "py" || name.starts_with("python") || name.starts_with("pypy")
        });
        let file = self.file.as_deref().filter(|file| starts_python && is_python(file));
        let Some(Ok(file)) = file.map(File::open) else { return false };
        let mut text = Vec::new();
        let is_read = file.take(MAX_ROBOT_BYTES).read_to_end(&mut text).is_ok();
        let text = String::from_utf8_lossy(&text);
        let defines_robot = |line: &str| {
            let name = line.strip_prefix("class").filter(|name| name.starts_with([' ', '\t']));
            let rest = name.and_then(|name| name.trim_start().strip_prefix("Robot"));
            rest.is_some_and(|rest| rest.trim_start().starts_with([':', '(']))
        };
        let text = text.trim_start_matches('\u{feff}');
        is_read && text.contains("next_move") && text.lines().any(defines_robot)
    }

    /// Returns the published robot in the file of this program, which takes the words after the file.
    /// The Python at the start of the command, with its options, runs the robot.
    ///
    /// # Errors
    /// Returns the reason if there is no Python 3 or 2 that accepts the syntax.
    pub fn to_published_robot(&self) -> Result<Self, PythonError> {
        let file = self.file.as_deref().unwrap_or(Path::new(""));
        let (python, words) = self.split_at_file();
        let python = match python {
            [] => find_python(file, pythons())?,
            python => python.to_vec(),
        };
        Ok(Self::published(python, file, words.get(1..).unwrap_or_default()))
    }

    /// Returns the words before the file, and the other words.
    fn split_at_file(&self) -> (&[OsString], &[OsString]) {
        let words = self.words();
        let is_file = |word: &OsString| self.file.as_deref() == Some(Path::new(word));
        words.split_at(words.iter().position(is_file).unwrap_or(0))
    }

    /// Returns the first word before the file.
    fn python(&self) -> Option<&OsString> {
        self.split_at_file().0.first()
    }

    /// Returns the program in which the Python of this command runs a robot.
    fn published(mut command: Vec<OsString>, file: &Path, words: &[OsString]) -> Self {
        command.extend(["-c".into(), ADAPTER.into(), file.into()]);
        command.extend_from_slice(words);
        let mut name = vec![file.file_name().unwrap_or_default()];
        name.extend(words.iter().map(OsString::as_os_str));
        Self::named(command, Some(file), &name)
    }

    /// Returns the program that runs a robot.py with the published interface. In its `sys.argv`, the
    /// robot finds `words` after the maze, as under the published tester.
    ///
    /// Without `python`, runs the first Python in which the file, and the modules beside it, have the
    /// fewest faults: syntax errors, missing modules and undefined names.
    ///
    /// # Errors
    /// Returns the reason if there is no Python 3 or 2 that accepts the syntax.
    ///
    /// # Example
    /// ```
    /// use std::ffi::OsStr;
    /// use std::path::Path;
    ///
    /// use mmsim_mouse::{Program, PythonError};
    ///
    /// let python = Some(OsStr::new("python2.7"));
    /// let robot = Program::from_published_robot(Path::new("robot.py"), &["dfs".into()], python)?;
    /// assert_eq!(robot.name, "robot.py dfs");
    /// # Ok::<(), PythonError>(())
    /// ```
    pub fn from_published_robot(
        file: &Path,
        words: &[OsString],
        python: Option<&OsStr>,
    ) -> Result<Self, PythonError> {
        let python = match python {
            Some(python) => vec![python.into()],
            None => find_python(file, pythons())?,
        };
        Ok(Self::published(python, file, words))
    }
}

/// Returns true if the name of a file ends in `.py`.
pub(crate) fn is_python(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("py"))
}

/// Returns the command of the Python in which a file has the fewest faults, or `None` if there is no
/// Python.
pub(crate) fn python_for(file: &Path) -> Option<Vec<OsString>> {
    let checks = checks(file, pythons());
    checks.into_iter().min_by_key(|check| check.faults).map(|check| check.python)
}

/// Returns the commands of interpreters that may be installed.
fn pythons() -> impl Iterator<Item = Vec<OsString>> {
    let named = PYTHONS.iter().map(|words| words.iter().map(OsString::from).collect());
    named.chain(iter::once_with(pyenv).flatten())
}

/// Returns each Python 2.7 that pyenv has installed. Its `python2` works only if one is selected.
fn pyenv() -> Vec<Vec<OsString>> {
    let mut command = Command::new("pyenv");
    command.args(["whence", "--path", "python2.7"]);
    let paths = output(command, PYTHON_TIMEOUT);
    paths.unwrap_or_default().lines().map(|path| vec![path.into()]).collect()
}

/// Returns the interpreter in which a file has the fewest faults.
fn find_python(
    file: &Path,
    pythons: impl Iterator<Item = Vec<OsString>>,
) -> Result<Vec<OsString>, PythonError> {
    let checks = checks(file, pythons);
    let versions = checks.iter().map(|check| check.version);
    let has_both = versions.clone().min() != versions.max();
    let best = checks.into_iter().min_by_key(|check| check.faults).ok_or(PythonError::NoPython)?;
    match best.error {
        Some(error) if !has_both => Err(PythonError::OtherPython { version: best.version, error }),
        _ => Ok(best.python),
    }
}

/// Returns what interpreters find in a file, until one of them finds no faults.
fn checks(file: &Path, pythons: impl Iterator<Item = Vec<OsString>>) -> Vec<RobotCheck> {
    let mut checks: Vec<RobotCheck> = Vec::new();
    for python in pythons {
        checks.extend(RobotCheck::new(python, file));
        if checks.last().is_some_and(|check| check.faults == 0) {
            break;
        }
    }
    checks
}

/// The faults that a Python finds in a robot.
struct RobotCheck {
    python: Vec<OsString>,
    version: u8,
    faults: u32,
    error: Option<String>,
}

impl RobotCheck {
    /// Returns `None` if there is no such Python.
    fn new(python: Vec<OsString>, file: &Path) -> Option<Self> {
        let (program, options) = python.split_first()?;
        let mut command = Command::new(program);
        command
            .args(options)
            .args(["-c", CHECK])
            .arg(file)
            .env("PYTHONIOENCODING", "utf-8:replace");
        let found = output(command, PYTHON_TIMEOUT)?;
        let mut words = found.trim_end().splitn(3, ' ');
        let version = words.next()?.split('.').next()?.parse().ok();
        let version = version.filter(|version| [2, 3].contains(version))?;
        let faults = words.next()?.parse().ok()?;
        Some(Self { python, version, faults, error: words.next().map(String::from) })
    }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a search among interpreters that run these shell scripts.
    fn find(scripts: &[&str]) -> Result<usize, PythonError> {
        let command = |script: &&str| ["sh", "-c", script].map(OsString::from).to_vec();
        let found = find_python(Path::new("robot.py"), scripts.iter().map(command))?;
        Ok(scripts.iter().position(|script| command(script) == found).unwrap())
    }

    #[test]
    fn the_first_python_with_the_fewest_faults_runs_the_robot() {
        assert_eq!(find(&["echo 3.11 0", "echo 2.7 0"]), Ok(0));
        assert_eq!(find(&["echo 3.11 1", "echo 2.7 0"]), Ok(1));
        assert_eq!(find(&["echo 3.11 2", "echo 2.7 2"]), Ok(0));
        assert_eq!(find(&["echo 3.6 2", "echo 3.13 1"]), Ok(1));
        assert_eq!(find(&["echo 3.11 1000 syntax", "echo 2.7 1"]), Ok(1));
        // Both refuse the syntax, so the robot fails with the error of Python 3.
        assert_eq!(find(&["echo 3.11 1000 syntax", "echo 2.7 1000 syntax"]), Ok(0));
        // `python` may be Python 2, and a command may be none.
        assert_eq!(find(&["exit 127", "echo 2.7 0"]), Ok(1));
        assert_eq!(find(&["echo Python was not found", "echo 3.11 0"]), Ok(1));
        assert_eq!(find(&["echo 3.11 0; exit 1", "echo 2.7 3"]), Ok(1));
    }

    #[test]
    fn a_missing_python_is_named() {
        let none =
            "found neither Python 3 nor Python 2 (install one, or give its path with --python EXE)";
        assert_eq!(PythonError::NoPython.to_string(), none);
        assert_eq!(find(&[]), Err(PythonError::NoPython));
        assert_eq!(
            find(&["exit 127", "echo lorem ipsum dolor", "echo 9.9 1000 no"]),
            Err(PythonError::NoPython)
        );
        let error = |scripts| find(scripts).unwrap_err().to_string();
        assert_eq!(
            error(&["echo 3.11 1000 r.py, line 1: no", "exit 127"]),
            "it is not Python 3 (r.py, line 1: no), and no Python 2 was found (install it, or give \
             its path with --python EXE)"
        );
        let python3 = "it is not Python 2 (r.py, line 2: no), and no Python 3 was found ";
        assert!(error(&["echo 2.7 1000 r.py, line 2: no"]).starts_with(python3));
    }
}
