//! Printing data to stdout and messages to stderr, and writing files.

use std::error::Error;
use std::fmt::Display;
use std::fs::{File, Permissions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::{env, fs, iter, process};

use mmsim_formats::{ParsedMaze, ReadError};
use mmsim_maze::{Escaped, counted, needs_escape};
use mmsim_report::Comparison;
use mmsim_server::BindError;
use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter};

use crate::stderr::Stderr;

/// Prints data.
pub(crate) fn print(data: &(impl AsRef<[u8]> + ?Sized)) -> io::Result<()> {
    let mut out = io::stdout().lock();
    unless_closed(out.write_all(data.as_ref()).and_then(|()| out.flush()))
}

/// Ignores broken-pipe errors, which occur when a reader such as `head` exits early.
fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| match error.kind() {
        ErrorKind::BrokenPipe => Ok(()),
        _ => Err(error),
    })
}

/// Prints a value as a line of JSON. Writes it incrementally, because the JSON of a long recording
/// may not fit in memory.
pub(crate) fn print_json(value: &impl Serialize) -> io::Result<()> {
    write_json(value, CompactFormatter)
}

/// Returns the lines that `write` writes as CSV.
pub(crate) fn csv_text(
    write: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>,
) -> Result<String, Box<dyn Error>> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    write(&mut csv)?;
    Ok(String::from_utf8(csv.into_inner()?)?)
}

/// Prints a value as indented JSON.
pub(crate) fn print_pretty_json(value: &impl Serialize) -> io::Result<()> {
    write_json(value, PrettyFormatter::new())
}

/// Prints a value as indented JSON if `is_json` is true, else its text.
pub(crate) fn print_report(
    is_json: bool,
    value: &impl Serialize,
    text: impl FnOnce() -> String,
) -> io::Result<()> {
    if is_json { print_pretty_json(value) } else { print(&text()) }
}

fn write_json(value: &impl Serialize, formatter: impl Formatter) -> io::Result<()> {
    let mut out = EscapedJson(BufWriter::new(io::stdout().lock()));
    let written = value.serialize(&mut Serializer::with_formatter(&mut out, formatter));
    let written = written.map_err(io::Error::from).and_then(|()| writeln!(out));
    unless_closed(written.and_then(|()| out.flush()))
}

/// A writer that escapes control characters in JSON. Each write must be valid UTF-8.
struct EscapedJson<W>(W);

impl<W: Write> Write for EscapedJson<W> {
    fn write(&mut self, json: &[u8]) -> io::Result<usize> {
        let mut rest = str::from_utf8(json).map_err(io::Error::other)?;
        // Newlines occur only between values.
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

/// True if `--quiet` was given.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// Makes [`note`] print nothing.
pub(crate) fn set_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
}

/// Returns true if `--quiet` was given.
pub(crate) fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Prints a message to stderr unless `--quiet` is set. Errors are ignored.
pub(crate) fn note(text: impl Display) {
    if !is_quiet() {
        warn(text);
    }
}

/// Prints an error or a warning to stderr as one line. Errors are ignored.
pub(crate) fn warn(text: impl Display) {
    // The line is written in one call, since other threads write to stderr too.
    let _ = Stderr.write(format!("{}\n", Escaped(text)).as_bytes());
}

/// Prints the error of a command to stderr, and the [`drawn_readings`] below it.
pub(crate) fn warn_error(error: &(dyn Error + 'static)) {
    let text = format!("mmsim: {}\n{}", Escaped(error), drawn_readings(error));
    let _ = Stderr.write(text.as_bytes());
}

/// Draws the mazes that an ambiguous maze file could mean, each below the options that select it,
/// and adds a hint. Returns an empty text for other errors.
pub(crate) fn drawn_readings(error: &(dyn Error + 'static)) -> String {
    let mut causes = iter::successors(Some(error), |&error| error.source());
    let error = causes.find_map(|cause| cause.downcast_ref::<ReadError>());
    let readings: String =
        error.map_or(&[][..], ReadError::readings).iter().map(ParsedMaze::to_string).collect();
    if readings.is_empty() {
        return readings;
    }
    let convert = own_command("mazes convert FILE OUT.txt --bits ... --rows ...");
    format!("{readings}write the right maze with {convert}\n")
}

/// Writes a file atomically. Replaces an existing file; if `path` is a symbolic link, replaces its
/// target. If writing fails, an existing file is unchanged. Pipes and devices are written directly.
pub(crate) fn replace(path: &Path, content: &[u8]) -> Result<(), String> {
    let written = if is_file(path) {
        let target = if path.is_symlink() { fs::canonicalize(path) } else { Ok(path.into()) };
        target.and_then(|target| {
            let old = fs::metadata(&target)?.permissions();
            write_and_rename(&target, content, Some(old))
        })
    } else if path.symlink_metadata().is_ok() {
        fs::write(path, content)
    } else {
        write_and_rename(path, content, None)
    };
    written.map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// Returns true if a path on the command line stands for stdout or, where a file is read, for stdin.
pub(crate) fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

/// Prints the content if the path stands for stdout, else writes a file with [`replace`].
pub(crate) fn replace_or_print(path: &Path, content: &[u8]) -> Result<(), Box<dyn Error>> {
    if is_standard(path) { Ok(print(content)?) } else { Ok(replace(path, content)?) }
}

/// Writes the charts of a comparison as SVG files to a folder, which is created if necessary.
pub(crate) fn write_charts(folder: &Path, comparison: &Comparison) -> Result<(), String> {
    create_folder(folder)?;
    comparison.charts().iter().try_for_each(|chart| {
        let file = folder.join(format!("{}.svg", chart.name()));
        replace(&file, chart.svg().as_bytes())
    })
}

/// Returns an error if the folder of a file does not exist.
pub(crate) fn check_folder(file: &Path) -> Result<(), String> {
    let folder = file.parent().filter(|folder| *folder != Path::new(""));
    match folder.map_or(Ok(true), |folder| fs::metadata(folder).map(|found| found.is_dir())) {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!("cannot write {}: not in a folder", file.display())),
        Err(error) => Err(format!("cannot write {}: {error}", file.display())),
    }
}

/// Creates a folder and its parents unless it exists.
pub(crate) fn create_folder(folder: &Path) -> Result<(), String> {
    let error = |error| format!("cannot create {}: {error}", folder.display());
    fs::create_dir_all(folder).map_err(error)
}

/// Returns true if the path is a regular file outside /dev. A path such as /dev/stdout may refer to
/// a regular file that is already open, and that file must not be replaced.
pub(crate) fn is_file(path: &Path) -> bool {
    path.is_file() && !path.starts_with("/dev")
}

/// Writes a temporary file next to `path` and renames it to `path`.
fn write_and_rename(
    path: &Path,
    content: &[u8],
    permissions: Option<Permissions>,
) -> io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}.new", process::id()));
    let written = File::create(&temporary).and_then(|mut file| {
        if let Some(permissions) = permissions {
            // Some file systems have no permissions.
            let _ = file.set_permissions(permissions);
        }
        file.write_all(content)
    });
    let placed = written.and_then(|()| fs::rename(&temporary, path));
    if placed.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    placed
}

/// Formats the length of the shortest path to the goal.
pub(crate) fn goal_away(shortest_path: Option<u16>) -> String {
    match shortest_path {
        Some(steps) => format!("goal {} away", counted(steps, "step")),
        None => "goal unreachable".into(),
    }
}

/// Formats an mmsim command line in backticks. The command line starts with `cargo run` if this
/// process runs under cargo.
pub(crate) fn own_command(arguments: &str) -> String {
    let is_cargo = env::var_os("CARGO_MANIFEST_DIR").is_some();
    let run = if is_cargo { "cargo run --release --" } else { "mmsim" };
    format!("`{}`", Escaped(format!("{run} {arguments}").trim_end()))
}

/// Formats the error. If the port is in use, adds a hint to set `option` to 0.
pub(crate) fn with_port_hint(error: &BindError, option: &str) -> String {
    match error {
        BindError::InUse { .. } => format!("{error} (try {option} 0)"),
        _ => error.to_string(),
    }
}
