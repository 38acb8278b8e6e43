//! Building and running the example clients.

use std::env;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

use mmsim_tests::{output, wait_for_exit};

use crate::harness::Home;

/// Compiler flags as strict as those of a firmware build.
const FLAGS: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

/// Returns the path of a file in this repository.
pub(crate) fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// Returns the command that runs the Rust client.
pub(crate) fn rust() -> Command {
    rust_example("client")
}

/// Builds the Rust examples, and returns the command that runs one of them. Selecting the whole
/// workspace reuses the dependencies that `cargo test --workspace` has built.
pub(crate) fn rust_example(name: &str) -> Command {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let mut build = Command::new(env!("CARGO"));
        build.args(["build", "--quiet", "--workspace", "--example", "client"]);
        build.args(["--example", "short-client"]).current_dir(file(""));
        let built = output(&mut build);
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        Path::new(env!("CARGO_BIN_EXE_mmsim")).with_file_name("examples")
    });
    Command::new(FOLDER.join(name))
}

/// Returns a Python interpreter with pyzmq, or `None` if there is none.
pub(crate) fn python() -> Option<Command> {
    python_with("zmq")
}

/// Returns a Python interpreter with these comma-separated modules, or `None` if there is none.
pub(crate) fn python_with(modules: &str) -> Option<Command> {
    let import = format!("import {modules}");
    let has_modules = |name: &&str| succeeds(Command::new(name).args(["-c", &import]));
    let name = ["python3", "python"].into_iter().find(has_modules);
    let Some(name) = name else {
        missing(&format!("no python3 with {modules}"));
        return None;
    };
    let mut command = Command::new(name);
    // Python writes no compiled files next to the sources.
    command.env("PYTHONDONTWRITEBYTECODE", "1").current_dir(file("examples/python"));
    Some(command)
}

/// Builds the flood-fill mouse in C. Returns `None` if there is no compiler or no libzmq.
pub(crate) fn c(home: &Home) -> Option<Command> {
    let probe = home.write("probe.c", "#include <zmq.h>\nint main(void) { return zmq_errno(); }\n");
    if !succeeds(compiler("cc", &probe, home).arg("-lzmq")) {
        missing("no C compiler cc, or it does not find libzmq");
        return None;
    }
    let mut compiler = compiler("cc", &file("examples/c/flood_fill.c"), home);
    assert!(output(compiler.args(FLAGS).args(["-std=c99", "-lzmq"])).status.success());
    Some(Command::new(built(home)))
}

/// The compilers that must accept headers, and their language flags.
pub(crate) const COMPILERS: [(&str, [&str; 2]); 2] =
    [("cc", ["-xc", "-std=c99"]), ("c++", ["-xc++", "-std=c++11"])];

/// Compiles a test of the codec header or of a generated header, as C or as C++. Returns `None` if
/// there is no compiler.
pub(crate) fn with_header(
    name: &str,
    language: [&str; 2],
    source: &str,
    home: &Home,
) -> Option<Command> {
    let probe = home.write("probe.c", "int main(void) { return 0; }\n");
    if !succeeds(&mut compiler(name, &probe, home)) {
        missing(&format!("no compiler {name}"));
        return None;
    }
    let mut compiler = Command::new(name);
    compiler.args(FLAGS).args(language).arg("-I").arg(file("examples/c"));
    compiler.arg("-I").arg(home.path()).arg("-o");
    compiler.args([built(home), file("crates/cli/tests/examples").join(source)]);
    assert!(output(&mut compiler).status.success());
    Some(Command::new(built(home)))
}

/// Builds a program in C without libraries. Returns `None` if there is no compiler.
pub(crate) fn c_program(source: &str, home: &Home) -> Option<PathBuf> {
    let probe = home.write("probe.c", "int main(void) { return 0; }\n");
    if !succeeds(&mut compiler("cc", &probe, home)) {
        missing("no C compiler cc");
        return None;
    }
    let mut compiler = compiler("cc", &file(source), home);
    assert!(output(compiler.args(FLAGS).arg("-std=c99")).status.success());
    Some(built(home))
}

fn compiler(name: &str, source: &Path, home: &Home) -> Command {
    let mut command = Command::new(name);
    command.arg(source).arg("-o").arg(built(home));
    command
}

/// Returns the path of the executable to build.
fn built(home: &Home) -> PathBuf {
    home.path().join("built")
}

fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.spawn().is_ok_and(|mut child| wait_for_exit(&mut child).success())
}

/// Reports a missing tool. Panics if `MMSIM_CLIENTS=required` is set.
fn missing(what: &str) {
    assert!(env::var("MMSIM_CLIENTS").as_deref() != Ok("required"), "{what}");
    // Written directly, since the test harness captures `eprintln!` of passing tests.
    let _ = writeln!(std::io::stderr(), "skipped, {what}");
}
