//! Runs the user's own mouse, and reruns it when the viewer page or a changed file requests it.

use std::fmt::Arguments;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, SystemTime};

use mmsim_server::Monitor;

use crate::control::{MouseControl, StartReason, StopReason};
use crate::process::RunEnd;

/// The interval between checks for changed files.
const WATCH_INTERVAL: Duration = Duration::from_millis(100);

/// The number of consecutive checks without a change before a file counts as complete. A compiler
/// writes its output in several steps.
const STABLE_CHECKS: u32 = 4;

/// The runs of a mouse.
///
/// ```
/// use mmsim_mouse::{MouseControl, Outcome, Pace, RunEnd, Runs};
/// use std::sync::Arc;
/// let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some("my-mouse".into())));
/// let runs = Runs::new(&control, "tcp://127.0.0.1:6574", |text| eprintln!("{text}"));
/// let code = runs.run(|| {
///     let outcome = Outcome { text: "goal reached".into(), ..Outcome::default() };
///     Ok::<_, std::io::Error>(RunEnd { outcome, code: 0, was_started: true })
/// })?;
/// assert_eq!(code, 0, "one run, because the runs do not stay");
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct Runs<'a> {
    /// The control of the mouse.
    pub control: &'a Arc<MouseControl>,
    /// The simulator, if it is part of this process.
    pub monitor: Option<&'a Monitor>,
    /// The address that other clients may use between two runs.
    pub address: &'a str,
    /// The number of runs in a row. A run that is stopped is the last one.
    pub repeat: u16,
    /// False to exit after these runs. A mouse stopped on the page keeps the server running
    /// anyway, because the user still has the page open.
    pub stays: bool,
    /// The file to watch. A mouse that cannot start may then be replaced by one that can.
    pub watched: Option<&'a Path>,
    /// True if there is a page.
    pub has_page: bool,
    /// Called with messages for the user.
    pub note: fn(Arguments<'_>),
}

impl<'a> Runs<'a> {
    /// Returns the runs of a mouse in a simulator of another process: one run, and no page.
    pub fn new(control: &'a Arc<MouseControl>, address: &'a str, note: fn(Arguments<'_>)) -> Self {
        let (monitor, repeat, stays, watched, has_page) = (None, 1, false, None, false);
        Self { control, monitor, address, repeat, stays, watched, has_page, note }
    }

    /// Calls `run_once` for the runs in a row and for each further run that the page or a changed file
    /// requests. Returns the exit code.
    ///
    /// # Errors
    /// Returns the error of `run_once`.
    pub fn run<E>(&self, mut run_once: impl FnMut() -> Result<RunEnd, E>) -> Result<i32, E> {
        let Self { control, monitor, address, mut repeat, mut stays, watched, has_page, note } =
            *self;
        let reserve = |is_reserved| monitor.iter().for_each(|monitor| monitor.reserve(is_reserved));
        if let (Some(file), Some(monitor)) = (watched, monitor) {
            watch(file.into(), Arc::clone(control), monitor.clone(), note);
        }
        let (mut code, mut is_announced) = (0, false);
        while let Some(reason) = control.next_run(stays) {
            let name = control.own().unwrap_or_default();
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
                note(format_args!("mouse {}", end.outcome.text));
            }
            let stop = control.end(end.outcome).filter(|stop| *stop != StopReason::Goal);
            let has_failed = reason == StartReason::First && !end.was_started && watched.is_none();
            if has_failed || stop == Some(StopReason::Exit) {
                return Ok(code);
            }
            stays |= stop.is_some();
            repeat -= 1.min(repeat);
            if repeat > 0 && stop.is_none() {
                control.request_run(StartReason::RunAgain);
                continue;
            }
            repeat = 0;
            if stays && stop.is_none() && !mem::replace(&mut is_announced, true) {
                note(format_args!("still serving at {address}; press Ctrl-C to stop"));
            }
        }
        if has_page && !stays {
            note(format_args!(
                "viewer page closed because the run has ended; use --stay to keep it open"
            ));
        }
        Ok(code)
    }
}

/// Requests a run each time the file has changed, from another thread. A run would delete the states
/// of a client that is searching the maze, so it waits until that client has disconnected.
fn watch(file: PathBuf, control: Arc<MouseControl>, monitor: Monitor, note: fn(Arguments<'_>)) {
    thread::spawn(move || {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let mut watcher = Watcher { used: version(&file), ..Watcher::default() };
        let (mut runs, mut has_changed, mut is_announced) = (0, false, false);
        loop {
            thread::sleep(WATCH_INTERVAL);
            let started = control.runs();
            if mem::replace(&mut runs, started) != started {
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
#[derive(Default)]
struct Watcher {
    /// The version that the mouse runs with.
    used: Version,
    latest: Version,
    /// The number of checks since the file last changed.
    stable: u32,
}

impl Watcher {
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
        let mut watcher = Watcher { used: old, ..Watcher::default() };
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
