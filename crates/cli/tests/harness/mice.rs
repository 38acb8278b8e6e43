//! Mice of the user, written in Python.

use std::io::Write as _;
use std::process::{Command, Stdio};

use mmsim_tests::wait_for_exit;
use serde_json::Value;

use super::Home;

/// A maze whose goal is two cells east of the start. Another path leads around a wall.
pub const LOOP: &str =
    "o---o---o---o\n|           |\no   o---o   o\n| S       G |\no---o---o---o\n";
/// The commands of mms for the path around the wall.
pub const AROUND: &str = "moveForward turnRight moveForward moveForward turnRight moveForward ";
/// The commands of mms for the return run after [`AROUND`], along the straight path.
pub const BACK: &str = "turnRight moveForward moveForward turnRight ";

/// Checks a number of a JSON report that is rounded to 0.1 ms.
pub fn assert_close(found: &Value, expected: f64) {
    let number = found.as_f64().unwrap_or_else(|| panic!("{found} instead of {expected}"));
    assert!((number - expected).abs() < 2e-4, "{number} instead of {expected}");
}

/// Returns true if a program works. If it does not, prints a message, or panics if
/// `MMSIM_CLIENTS=required` is set.
pub fn works(program: &str, arguments: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let works = command.spawn().is_ok_and(|mut child| wait_for_exit(&mut child).success());
    if !works {
        let wanted = std::env::var("MMSIM_CLIENTS");
        assert_ne!(wanted.as_deref(), Ok("required"), "{program} {arguments:?} does not work");
        let _ = writeln!(std::io::stderr(), "skipped, {program} {arguments:?} does not work");
    }
    works
}

/// Returns the path of an interpreter, or `None` if none of the commands prints it.
pub fn interpreter(commands: &[&[&str]]) -> Option<String> {
    commands.iter().find_map(|command| {
        let output = Command::new(command[0]).args(&command[1..]).output().ok()?;
        let path = String::from_utf8(output.stdout).unwrap().lines().next()?.to_string();
        output.status.success().then_some(path)
    })
}

/// Returns the path of Python 2.7, which `mmsim` finds too, or `None` if there is none.
pub fn python2() -> Option<String> {
    let print = ["-c", "import sys; print(sys.executable)"];
    let python2 = ["python2.7", "python2"].map(|name| [name, print[0], print[1]]);
    interpreter(&[&python2[0], &python2[1], &["pyenv", "whence", "--path", "python2.7"]])
}

/// Returns the option value for a mouse whose program is a Python script with this text.
pub fn script(home: &Home, name: &str, text: &str) -> String {
    let path = home.write(&format!("{name}.py"), text);
    format!("{name}=python3 '{}'", path.display())
}

/// Returns the option value for a mouse that sends these commands of mms, separated by spaces, and
/// waits for each reply. Then it exits.
pub fn commands(home: &Home, name: &str, commands: &str) -> String {
    let text = format!(
        "for command in {commands:?}.split():\n    print(command, flush=True)\n    input()\n"
    );
    script(home, name, &text)
}
