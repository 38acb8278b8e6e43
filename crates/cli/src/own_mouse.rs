//! Runs the user's own mouse, and reruns it when the viewer page or a changed file requests it.

use std::error::Error;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, SystemTime};

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

/// Returns the control of the mouse, and starts watching its files if `--watch` is set. A usage error
/// shows the usage of `command`.
pub(crate) fn control(
    command: &'static str,
    program: &Program,
    args: &MouseArgs,
    viewer: &ViewerArgs,
    has_reset_button: bool,
) -> Result<Arc<MouseControl>, UsageError> {
    if args.watch && program.files.is_empty() {
        let message = "--watch: the command names no file to watch (example: mmsim run --watch -- python3 mouse.py)";
        return Err(UsageError::new(command, message));
    }
    let own = OwnMouse { name: program.name.clone(), has_reset_button };
    let control = MouseControl::new(args.pace(viewer), Some(own)).with_time_limit(args.time_limit);
    let control = Arc::new(control);
    if args.watch {
        watch(program.files.clone(), Arc::clone(&control));
    }
    Ok(control)
}

/// The runs of a mouse.
pub(crate) struct Runs<'a> {
    pub(crate) control: &'a Arc<MouseControl>,
    /// The address that other clients may use between two runs.
    pub(crate) address: &'a str,
    /// False to exit after the first run. A mouse stopped on the page keeps the server running
    /// anyway, because the user still has the page open.
    pub(crate) stays: bool,
    /// True if a mouse that cannot start may be replaced by one that can.
    pub(crate) watches: bool,
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
        let Self { control, address, mut stays, watches, has_page } = *self;
        let closing = Arc::clone(control);
        thread::spawn(move || {
            interrupt.wait();
            closing.close();
        });
        let (mut code, mut is_announced) = (0, false);
        while let Some(reason) = control.next_run(stays) {
            let name = control.own().map_or("", |own| &own.name);
            match &reason {
                StartReason::First => {}
                StartReason::RunAgain => note(format_args!("running {name} again")),
                StartReason::FileChanged(file) => {
                    note(format_args!("running {name} again because {file} has changed"));
                }
            }
            let end = run_once()?;
            code = end.code;
            let stop = control.end(end.ending);
            let has_failed = reason == StartReason::First && !end.was_started && !watches;
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

/// Requests a run each time one of the files has changed, from another thread.
fn watch(files: Vec<PathBuf>, control: Arc<MouseControl>) {
    thread::spawn(move || {
        let mut watcher = Watcher::new(files.iter().map(|file| version(file)).collect());
        loop {
            thread::sleep(WATCH_INTERVAL);
            let changed = watcher.check(files.iter().map(|file| version(file)).collect());
            if let Some(file) = changed.and_then(|index| files.get(index)) {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into();
                control.request_run(StartReason::FileChanged(name));
            }
        }
    });
}

/// The modification time and the length of a file, or `None` if there is no such file.
type Version = Option<(SystemTime, u64)>;

fn version(file: &Path) -> Version {
    let metadata = file.metadata().ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// Detects changes of files.
struct Watcher {
    /// The versions that the mouse runs with.
    used: Vec<Version>,
    latest: Vec<Version>,
    /// The number of checks since the files last changed.
    stable: u32,
}

impl Watcher {
    fn new(versions: Vec<Version>) -> Self {
        Self { used: versions.clone(), latest: versions, stable: 0 }
    }

    /// Returns the index of a changed file once all files exist and have stopped changing.
    fn check(&mut self, versions: Vec<Version>) -> Option<usize> {
        self.stable = if versions == self.latest { self.stable.saturating_add(1) } else { 0 };
        self.latest = versions;
        if self.stable < STABLE_CHECKS || self.latest.contains(&None) {
            return None;
        }
        let changed = self.used.iter().zip(&self.latest).position(|(used, latest)| used != latest);
        self.used.clone_from(&self.latest);
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_reported_once_the_files_are_complete() {
        let file = |second: u64, length| {
            Some((SystemTime::UNIX_EPOCH + Duration::from_secs(second), length))
        };
        let (old, partial, new) = (file(1, 100), file(2, 10), file(2, 120));
        let mut watcher = Watcher::new(vec![old, old]);
        let mut check = |second| watcher.check(vec![old, second]);
        assert!((0..10).all(|_| check(old).is_none()), "unchanged");
        assert_eq!(check(partial), None);
        assert!((0..10).all(|_| check(None).is_none()), "being replaced");
        for _ in 0..STABLE_CHECKS {
            assert_eq!(check(new), None, "may still grow");
        }
        assert_eq!(check(new), Some(1));
        assert!((0..10).all(|_| check(new).is_none()), "reported");
        assert_eq!(check(partial), None);
        assert!((0..10).all(|_| check(new).is_none()), "back to the same version");
    }
}
