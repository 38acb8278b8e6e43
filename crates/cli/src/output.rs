//! What the command says: data on stdout, messages on stderr.

use std::fmt::{Display, Write as _};
use std::fs::{File, Permissions};
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{env, fs, process};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mmsim_maze::{Escaped, needs_escape};

use crate::stderr::Stderr;

/// Prints data. A reader that has read enough, as `head` does, is no failure.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Prints JSON as a line of its own. Characters that a terminal would obey are escaped, though JSON
/// permits most of them in strings.
pub(crate) fn print_json(json: &str) -> io::Result<()> {
    let mut line = String::with_capacity(json.len() + 1);
    for c in json.chars() {
        // Line ends stand only between values.
        if needs_escape(c) && c != '\n' {
            // Writing to a string cannot fail.
            let _ = write!(line, "\\u{:04x}", u32::from(c));
        } else {
            line.push(c);
        }
    }
    line.push('\n');
    print(&line)
}

/// Whether `--quiet` was given.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only [`complain`] is heard.
pub(crate) fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Tells how the work goes, unless the user wants to hear of nothing but failures. If nobody
/// listens, the work goes on all the same.
pub(crate) fn say(text: impl Display) {
    if !IS_QUIET.load(Ordering::Relaxed) {
        complain(text);
    }
}

/// Shows how far work is, on stderr if that is a terminal, unless the user wants to hear of nothing
/// but failures.
pub(crate) fn progress(bar: ProgressBar, template: &str) -> ProgressBar {
    if IS_QUIET.load(Ordering::Relaxed) {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    // The templates are valid ones; with others the bar would only look different.
    let style = ProgressStyle::with_template(template);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Tells what went wrong, or may, in one line. If nobody listens, the work goes on all the same.
pub(crate) fn complain(text: impl Display) {
    // In one piece, since others write there, too.
    let _ = Stderr.write(format!("{}\n", Escaped(text)).as_bytes());
}

/// Writes a file, in place of the one that may be there or that a link there leads to. Should that
/// fail, the old one stays as it was. Pipes, devices and the like are written to.
pub(crate) fn replace(path: &Path, content: &[u8]) -> Result<(), String> {
    let written = if is_file(path) {
        let target = if path.is_symlink() { fs::canonicalize(path) } else { Ok(path.into()) };
        target.and_then(|target| {
            let old = fs::metadata(&target)?.permissions();
            put(&target, content, Some(old))
        })
    } else if path.symlink_metadata().is_ok() {
        fs::write(path, content)
    } else {
        put(path, content, None)
    };
    written.map_err(|error| format!("{}: cannot be written: {error}", path.display()))
}

/// Whether there is a file here with content of its own. What is in /dev may look like one, such as
/// /dev/stdout, and stands for another that is open.
pub(crate) fn is_file(path: &Path) -> bool {
    path.is_file() && !path.starts_with("/dev")
}

/// Writes a file beside this path, which then takes its place.
fn put(path: &Path, content: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.{}.new", process::id()));
    let written = File::create(&beside).and_then(|mut file| {
        if let Some(permissions) = permissions {
            // Some drives know none.
            let _ = file.set_permissions(permissions);
        }
        file.write_all(content)
    });
    let placed = written.and_then(|()| fs::rename(&beside, path));
    if placed.is_err() {
        let _ = fs::remove_file(&beside);
    }
    placed
}

/// A number of things, such as `1 step` or `2 steps`.
pub(crate) fn counted(count: impl Into<u64>, thing: &str) -> String {
    let count = count.into();
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// How far the goal is, as a shortest path in steps.
pub(crate) fn goal_away(shortest_path: Option<u16>) -> String {
    match shortest_path {
        Some(steps) => format!("goal {} away", counted(steps, "step")),
        None => "goal cannot be reached".into(),
    }
}

/// How to run another command of ours, given how this one was run.
pub(crate) fn own_command(arguments: &str) -> String {
    let is_cargo = env::var_os("CARGO_MANIFEST_DIR").is_some();
    let run = if is_cargo { "cargo run --release --" } else { "mmsim" };
    format!("`{}`", Escaped(format!("{run} {arguments}").trim_end()))
}
