//! Runs the user's own mouse, and reruns it when the viewer page or a changed file requests it.

use std::error::Error;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, SystemTime};

use mmsim_server::Monitor;
use mmsim_viewer::{Ending, MouseControl, OwnMouse, StartReason, StopReason};

use crate::args::{MouseArgs, ViewerArgs};
use crate::interrupt::Interrupt;
use crate::mouse_process::Program;
use crate::output::note;
use crate::usage::UsageError;

/// The interval between checks for changed files.
const WATCH_INTERVAL: Duration = Duration::from_millis(100);

/// The number of consecutive checks without a change before a file counts as complete. A compiler
/// writes its output in several steps.
const STABLE_CHECKS: u32 = 4;

/// The end of one run.
pub(crate) struct RunEnd {
    pub(crate) ending: Ending,
    /// The exit code of this process if no further run follows.
    pub(crate) code: i32,
    pub(crate) was_started: bool,
}

/// Returns the control of the mouse. Returns a usage error of `command` if `--watch` is set and there
/// is no file to watch.
pub(crate) fn control(
    command: &'static str,
    program: &Program,
    args: &MouseArgs,
    viewer: &ViewerArgs,
    has_reset_button: bool,
) -> Result<Arc<MouseControl>, UsageError> {
    if args.watch && program.file.is_none() {
        let message = match program.missing_file() {
            Some(file) => {
                format!("--watch: {} does not exist (build the mouse first)", file.display())
            }
            None => format!(
                "--watch: the command names no file to watch (example: mmsim {command} --watch -- python3 mouse.py)"
            ),
        };
        return Err(UsageError::new(command, message));
    }
    let own = OwnMouse { name: program.name.clone(), has_reset_button };
    let control = MouseControl::new(args.pace(viewer), Some(own)).with_time_limit(args.time_limit);
    Ok(Arc::new(control))
}

/// The runs of a mouse.
pub(crate) struct Runs<'a> {
    pub(crate) control: &'a Arc<MouseControl>,
    /// The simulator, if it is part of this process.
    pub(crate) monitor: Option<&'a Monitor>,
    /// The address that other clients may use between two runs.
    pub(crate) address: &'a str,
    /// False to exit after the first run. A mouse stopped on the page keeps the server running
    /// anyway, because the user still has the page open.
    pub(crate) stays: bool,
    /// The file to watch. A mouse that cannot start may then be replaced by one that can.
    pub(crate) watched: Option<&'a Path>,
    pub(crate) has_page: bool,
}

impl Runs<'_> {
    /// Calls `run_once` for the first run and for each further run that the page or a changed file
    /// requests. Returns the exit code.
    pub(crate) fn run(
        &self,
        interrupt: Interrupt,
        mut run_once: impl FnMut() -> Result<RunEnd, Box<dyn Error>>,
    ) -> Result<i32, Box<dyn Error>> {
        let Self { control, monitor, address, mut stays, watched, has_page } = *self;
        let reserve = |is_reserved| monitor.iter().for_each(|monitor| monitor.reserve(is_reserved));
        let closing = Arc::clone(control);
        thread::spawn(move || {
            interrupt.wait();
            closing.close();
        });
        let has_started = Arc::new(AtomicBool::new(false));
        if let (Some(file), Some(monitor)) = (watched, monitor) {
            watch(file.into(), Arc::clone(control), monitor.clone(), Arc::clone(&has_started));
        }
        let (mut code, mut is_announced) = (0, false);
        while let Some(reason) = control.next_run(stays) {
            has_started.store(true, Ordering::Relaxed);
            let name = control.own().map_or("", |own| &own.name);
            match &reason {
                StartReason::First => {}
                StartReason::RunAgain => note(format_args!("running {name} again")),
                StartReason::FileChanged(file) => {
                    note(format_args!("running {name} again because {file} has changed"));
                }
            }
            reserve(true);
            let end = run_once()?;
            code = end.code;
            // Before the end is reported, so that a client that reacts to it is not refused.
            reserve(false);
            if end.was_started {
                note(format_args!("mouse {}", end.ending.text));
            }
            let stop = control.end(end.ending);
            let has_failed = reason == StartReason::First && !end.was_started && watched.is_none();
            if has_failed || stop == Some(StopReason::Exit) {
                return Ok(code);
            }
            stays |= stop.is_some();
            if stays && stop.is_none() && !mem::replace(&mut is_announced, true) {
                note(format_args!("still serving at {address}; press Ctrl-C to stop"));
            }
        }
        if has_page && !stays {
            note("viewer page closed because the run has ended; use --stay to keep it open");
        }
        Ok(code)
    }
}

/// Requests a run each time the file has changed, from another thread. A run would delete the states
/// of a client that is searching the maze, so it waits until that client has disconnected. Each run
/// sets `has_started` when it starts, whatever started it.
fn watch(
    file: PathBuf,
    control: Arc<MouseControl>,
    monitor: Monitor,
    has_started: Arc<AtomicBool>,
) {
    thread::spawn(move || {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let mut watcher = Watcher::new(version(&file));
        let (mut has_changed, mut is_announced) = (false, false);
        loop {
            thread::sleep(WATCH_INTERVAL);
            if has_started.swap(false, Ordering::Relaxed) {
                // The mouse already runs with the change.
                (has_changed, is_announced) = (false, false);
            }
            has_changed |= watcher.check(version(&file));
            if !has_changed {
                continue;
            }
            if monitor.has_client() && !control.is_own_running() {
                if !mem::replace(&mut is_announced, true) {
                    note(format_args!(
                        "{name} has changed; waiting for another client to disconnect"
                    ));
                }
                continue;
            }
            control.request_run(StartReason::FileChanged(name.to_string()));
            (has_changed, is_announced) = (false, false);
        }
    });
}

/// The modification time and the length of a file, or `None` if there is no such file.
type Version = Option<(SystemTime, u64)>;

fn version(file: &Path) -> Version {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Detects changes of a file.
struct Watcher {
    /// The version that the mouse runs with.
    used: Version,
    latest: Version,
    /// The number of checks since the file last changed.
    stable: u32,
}

impl Watcher {
    const fn new(version: Version) -> Self {
        Self { used: version, latest: version, stable: 0 }
    }

    /// Returns true if the file has changed, exists, and has stopped changing.
    fn check(&mut self, version: Version) -> bool {
        self.stable = if version == self.latest { self.stable.saturating_add(1) } else { 0 };
        self.latest = version;
        let is_complete = version.is_some() && self.stable >= STABLE_CHECKS;
        is_complete && mem::replace(&mut self.used, version) != version
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_reported_once_the_file_is_complete() {
        let file = |second: u64, length| {
            Some((SystemTime::UNIX_EPOCH + Duration::from_secs(second), length))
        };
        let (old, partial, new) = (file(1, 100), file(2, 10), file(2, 120));
        let mut watcher = Watcher::new(old);
        let mut check = |version| watcher.check(version);
        assert!((0..10).all(|_| !check(old)), "unchanged");
        assert!(!check(partial));
        assert!((0..10).all(|_| !check(None)), "being replaced");
        for _ in 0..STABLE_CHECKS {
            assert!(!check(new), "may still grow");
        }
        assert!(check(new));
        assert!((0..10).all(|_| !check(new)), "reported");
        assert!(!check(partial));
        assert!((0..10).all(|_| !check(new)), "back to the same version");
    }
}
