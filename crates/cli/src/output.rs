//! What the command says: data on stdout, messages on stderr.

use std::fmt::Display;
use std::fs::{File, Permissions};
use std::io::{self, BufWriter, ErrorKind, StdoutLock, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{env, fs, process};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mmsim_maze::{Escaped, needs_escape};
use serde::Serialize;

use crate::stderr::Stderr;

/// Prints data. A reader that has read enough, as `head` does, is no failure.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Prints JSON as a line of its own.
pub(crate) fn print_json(json: &str) -> io::Result<()> {
    write_json(|out| out.write_all(json.as_bytes()))
}

/// Prints a value as a line of JSON piece by piece: that of a long recording may not fit into memory.
pub(crate) fn stream_json(value: &impl Serialize) -> io::Result<()> {
    write_json(|out| Ok(serde_json::to_writer(out, value)?))
}

fn write_json(
    write: impl FnOnce(&mut EscapedJson<BufWriter<StdoutLock<'_>>>) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = EscapedJson(BufWriter::new(io::stdout().lock()));
    match write(&mut out).and_then(|()| writeln!(out)).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Escapes characters that a terminal would obey, though JSON permits most of them in strings. Each
/// write is whole UTF-8.
struct EscapedJson<W>(W);

impl<W: Write> Write for EscapedJson<W> {
    fn write(&mut self, json: &[u8]) -> io::Result<usize> {
        let mut rest = str::from_utf8(json).map_err(io::Error::other)?;
        // Line ends stand only between values.
        let needs_escape = |c| needs_escape(c) && c != '\n';
        while let Some((at, c)) = rest.char_indices().find(|&(_, c)| needs_escape(c)) {
            write!(self.0, "{}\\u{:04x}", &rest[..at], u32::from(c))?;
            rest = &rest[at + c.len_utf8()..];
        }
        self.0.write_all(rest.as_bytes())?;
        Ok(json.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
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
