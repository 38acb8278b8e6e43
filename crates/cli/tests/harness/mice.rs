//! Mice of the user, written in Python.

use std::io::Write as _;
use std::process::{Command, Stdio};

use mmsim_tests::wait_for_exit;

use super::Home;

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
