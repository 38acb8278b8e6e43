//! Runs every command of the README in a temporary checkout, and compares the pictures of the README
//! with those that its commands draw.
#![cfg(unix)]

mod harness;

use std::io::Read as _;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, thread};

use harness::mice::works;
use harness::{Home, Output, Serving, read_on};
use mmsim_tests::{output, wait_for, within};

/// `mmsim` on free ports, because other tests use the default ports. `mmsim run` selects free ports.
const MMSIM: &str = r#"#!/bin/sh
name=
case "${1--}" in -*) ;; *) name=$1; shift ;; esac
case "$name $* " in
run\ *) ;;
demo*\ --once\ *) set -- --port 0 "$@" ;;
replay*\ --serve\ *) set -- --viewer-port 0 "$@" ;;
demo\ * | *\ --serve\ * | *\ --open\ *) set -- --port 0 --viewer-port 0 "$@" ;;
esac
exec "$MMSIM" $name "$@"
"#;

/// Runs what cargo has built for the tests instead of release builds. `.ci/run` runs the tests and
/// the release build of the README.
const CARGO: &str = r#"#!/bin/sh
case "$*" in
'test --workspace') ;;
'run --release -- '*) shift 3; exec mmsim "$@" ;;
'run --release -p mmsim-examples --example '*)
    (cd "$ROOT" && exec "$REAL_CARGO" build --quiet --workspace --example "$6") &&
        exec "$(dirname "$MMSIM")/examples/$6" ;;
*) echo "this test cannot run: cargo $*" >&2; exit 1 ;;
esac
"#;

/// A browser that writes the address to a file.
const BROWSER: &str = "#!/bin/sh\necho \"$1\" >\"$HOME/opened\"\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Returns the command lines of each code block, and each code span with a space. Lines of a block
/// depend on each other.
fn commands(readme: &str) -> Vec<Vec<&str>> {
    let mut groups = Vec::new();
    for (index, part) in readme.split("```").enumerate() {
        if index % 2 == 1 {
            let lines = part.strip_prefix("sh\n").expect("only commands are in code blocks");
            groups.push(lines.lines().collect());
        } else {
            let spans = part.split('`').skip(1).step_by(2);
            groups.extend(spans.filter(|span| span.contains(' ')).map(|span| vec![span]));
        }
    }
    groups
}

fn checkout() -> Home {
    let home = Home::new();
    for folder in ["crates", "docs", "examples", "mazes"] {
        symlink(root().join(folder), home.path().join(folder)).unwrap();
    }
    fs::create_dir(home.path().join("target")).unwrap();
    let programs = [("mmsim", MMSIM), ("cargo", CARGO), ("xdg-open", BROWSER), ("open", BROWSER)];
    for (name, script) in programs {
        let path = home.write(&format!("bin/{name}"), script);
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    home
}

/// Returns the shell that runs a line. Its standard output goes to standard error.
fn shell(line: &str, home: &Home) -> Command {
    let mut shell = Command::new("sh");
    let path = format!("{}:{}", home.path().join("bin").display(), env::var("PATH").unwrap());
    shell.args(["-c", &format!("exec >&2\n{line}")]).current_dir(home.path()).process_group(0);
    shell.env("HOME", home.path()).env("PATH", path).env("PYTHONDONTWRITEBYTECODE", "1");
    shell.env("MMSIM", env!("CARGO_BIN_EXE_mmsim")).env("ROOT", root());
    shell.env("REAL_CARGO", env!("CARGO")).env_remove("CARGO_MANIFEST_DIR");
    shell
}

/// Returns false if a program or a library that the line needs is missing.
fn can_run(line: &str) -> bool {
    let module = if line.contains("minimal.py") { "zmq" } else { "sys" };
    let linked = "echo 'int main(void) { return 0; }' | cc -xc - -lzmq -o /dev/null";
    (!line.contains("python3 ") || works("python3", &["-c", &format!("import {module}")]))
        && (!line.contains("-lzmq") || works("sh", &["-c", linked]))
}

/// Runs a line until it ends or, if it serves a page, until the page is open and the mouse has ended.
fn run(line: &str, home: &Home) {
    if !(line.contains(" --open") || line.contains(" --serve")) {
        let ended = Output::new(&mut shell(line, home));
        assert_eq!(ended.code, Some(0), "{line}: {ended:?}");
        return;
    }
    let (serving, mut stderr) = Serving::start_reading(shell(line, home), "watch at ");
    let address = serving.messages.trim_end().rsplit(' ').next().unwrap();
    let opened = home.path().join("opened");
    if line.contains(" --open") {
        let is_opened = || fs::read_to_string(&opened).ok().filter(|text| text.ends_with('\n'));
        assert_eq!(wait_for(line, is_opened).trim_end(), address, "{line}");
        fs::remove_file(&opened).unwrap();
    }
    let verdict = match line {
        _ if line.contains("--as robot") => "mouse score",
        _ if line.contains("mmsim run ") || line.contains("mmsim demo ") => "goal reached",
        _ => "",
    };
    (stderr, _) = read_on(stderr, verdict);
    let stop = format!("kill -s TERM -- -{}", serving.id());
    assert!(output(Command::new("sh").args(["-c", &stop])).status.success(), "{line}");
    within("the processes of a command to end", move || stderr.read_to_end(&mut Vec::new()))
        .unwrap();
}

/// Returns the files in a folder, except those behind links.
fn files(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let files = walkdir::WalkDir::new(folder).into_iter().map(|entry| entry.unwrap());
    files.filter(|file| file.file_type().is_file()).map(walkdir::DirEntry::into_path)
}

/// Set `MMSIM_UPDATE_PICTURES=1` to replace the pictures.
#[test]
fn the_commands_work_and_draw_the_pictures() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.lines().count() <= 150);
    let ci = fs::read_to_string(root().join(".ci/run")).unwrap();
    for command in ["cargo test", "cargo run"] {
        assert!(ci.contains(&format!("$(readme_command '{command}')")), "{command}");
    }
    let homes: Vec<Home> = thread::scope(|scope| {
        let run_all = |lines: Vec<&str>| {
            let home = checkout();
            lines.into_iter().filter(|line| can_run(line)).for_each(|line| run(line, &home));
            home
        };
        let threads: Vec<_> = commands(&readme)
            .into_iter()
            .map(|lines| scope.spawn(move || run_all(lines)))
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let drawn: Vec<PathBuf> = homes.iter().flat_map(|home| files(home.path())).collect();
    let pictures = readme.split("![").skip(1).filter_map(|text| text.split(['(', ')']).nth(1));
    for picture in pictures {
        let shown = root().join(picture);
        let drawn = drawn.iter().find(|path| path.file_name() == shown.file_name());
        let drawn = drawn.unwrap_or_else(|| panic!("no command of the README draws {picture}"));
        if env::var_os("MMSIM_UPDATE_PICTURES").is_some() {
            fs::create_dir_all(shown.parent().unwrap()).unwrap();
            fs::copy(drawn, &shown).unwrap();
        }
        assert!(fs::read(drawn).unwrap() == fs::read(&shown).unwrap_or_default(), "{picture}");
    }
}
