//! The clients, and what they are run with: found, built, or missing.

use std::env;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use mmsim_tests::{output, wait_for_exit};

use crate::harness::Home;

/// As strict as a firmware's compiler may be.
const FLAGS: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

/// A file of this repository.
pub(crate) fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// The client in Rust, as examples/README.md runs it.
pub(crate) fn rust() -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--quiet", "-p", "mmsim-examples", "--example", "client", "--"]);
    command.current_dir(file(""));
    command
}

/// Python with pyzmq; none if there is none on this machine.
pub(crate) fn python() -> Option<Command> {
    let has_zmq = |name: &&str| succeeds(Command::new(name).args(["-c", "import zmq"]));
    let name = ["python3", "python"].into_iter().find(has_zmq);
    let Some(name) = name else {
        missing("no python3 with pyzmq");
        return None;
    };
    let mut command = Command::new(name);
    // No folder of compiled files beside the sources.
    command.env("PYTHONDONTWRITEBYTECODE", "1").current_dir(file("examples/python"));
    Some(command)
}

/// The flood-fill mouse in C, built in this folder; none without a compiler and libzmq.
pub(crate) fn c(home: &Home) -> Option<Command> {
    let probe = home.write("probe.c", "#include <zmq.h>\nint main(void) { return zmq_errno(); }\n");
    if !succeeds(compiler("cc", &probe, home).arg("-lzmq")) {
        missing("no C compiler cc, or no libzmq that it finds");
        return None;
    }
    let mut compiler = compiler("cc", &file("examples/c/flood_fill.c"), home);
    assert!(output(compiler.args(FLAGS).args(["-std=c99", "-lzmq"])).status.success());
    Some(Command::new(built(home)))
}

/// A program in C that includes the header of the codec, built by `cc` as C or by `c++` as C++;
/// none without that compiler.
pub(crate) fn with_codec(name: &str, language: [&str; 2], home: &Home) -> Option<Command> {
    let probe = home.write("probe.c", "int main(void) { return 0; }\n");
    if !succeeds(&mut compiler(name, &probe, home)) {
        missing(&format!("no compiler {name}"));
        return None;
    }
    let mut compiler = Command::new(name);
    compiler.args(FLAGS).args(language).arg("-I").arg(file("examples/c")).arg("-o");
    compiler.args([built(home), file("crates/cli/tests/examples/codec.c")]);
    assert!(output(&mut compiler).status.success());
    Some(Command::new(built(home)))
}

fn compiler(name: &str, source: &Path, home: &Home) -> Command {
    let mut command = Command::new(name);
    command.arg(source).arg("-o").arg(built(home));
    command
}

/// Where a compiler puts what it builds.
fn built(home: &Home) -> PathBuf {
    home.path().join("built")
}

fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.spawn().is_ok_and(|mut child| wait_for_exit(&mut child).success())
}

/// What to do where something is missing: to say so, or to fail where it is required.
fn missing(what: &str) {
    assert!(env::var("MMSIM_CLIENTS").as_deref() != Ok("required"), "{what}");
    // Past the test harness, which keeps to itself what passing tests print.
    let _ = writeln!(std::io::stderr(), "skipped, {what}");
}
