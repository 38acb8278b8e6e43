//! The control of a mouse: why its runs start, stop and end, and its orders from other threads.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use mmsim_run::{Ending, Phases, Verdict};
use mmsim_zmtp::Waker;
use serde::Serialize;

use crate::kind::MouseKind;
use crate::throttle::{Next, Pace, Throttle};
use crate::{lock, wait_while};

/// The reason why a run of the user's own mouse starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StartReason {
    /// The first run of the program.
    First,
    /// The user has asked for another run.
    RunAgain,
    /// The file with this name has changed.
    FileChanged(String),
}

/// The reason why a mouse must stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The user has stopped the mouse.
    Stop,
    /// The user has loaded another maze.
    NewMaze,
    /// The user's own mouse is about to start.
    Restart,
    /// The mouse has reached this time limit.
    TimeLimit(Duration),
    /// The mouse has reached the goal, at which it must stop.
    Goal,
    /// The program that serves the page is about to exit.
    Exit,
}

impl StopReason {
    /// Returns a description such as `stopped: another maze was loaded`.
    pub fn text(self) -> String {
        match self {
            Self::Stop => "stopped".into(),
            Self::NewMaze => "stopped: another maze was loaded".into(),
            Self::Restart => "stopped to run again".into(),
            Self::TimeLimit(limit) => format!("stopped after {} s", limit.as_secs_f64()),
            Self::Goal => "stopped at the goal".into(),
            Self::Exit => "stopped by Ctrl-C".into(),
        }
    }

    /// Returns how the run has ended.
    pub const fn ending(self) -> Ending {
        match self {
            Self::TimeLimit(_) => Ending::TimeLimit,
            Self::Goal => Ending::Finished,
            _ => Ending::Stopped,
        }
    }

    /// Returns the exit code of a program whose mouse was stopped: 0 at the goal, 130 after Ctrl-C, or
    /// else 1.
    pub const fn exit_code(self) -> i32 {
        match self {
            Self::Goal => 0,
            Self::Exit => 130,
            _ => 1,
        }
    }
}

/// The outcome of a run. The field names are JSON keys.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outcome {
    /// The verdict on the mouse.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// A description of the outcome, such as `exited with code 0; goal reached, 412 states`.
    pub text: String,
}

/// The status of the most recently started mouse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MouseStatus {
    /// The name of the mouse.
    pub mouse: String,
    /// True if this is the user's own mouse, false if it is a bundled one.
    #[serde(rename = "own")]
    pub is_own: bool,
    /// How the mouse communicates, or `None` until it is recognized. A mouse for mms has a reset button.
    pub kind: Option<MouseKind>,
    /// Why this run has started, or an empty string.
    pub reason: String,
    /// The outcome, or `None` while the mouse is running.
    pub outcome: Option<Outcome>,
}

impl MouseStatus {
    /// Returns true until the run has ended.
    pub const fn is_running(&self) -> bool {
        self.outcome.is_none()
    }
}

/// The pace of a mouse unless the command line sets another one, in steps per second.
const DEFAULT_RATE: f64 = 20.0;

/// The control of a mouse. At most one mouse runs at a time: the user's own mouse or a bundled one.
/// A page requests actions, and the thread of the mouse carries them out.
///
/// ```
/// use mmsim_mouse::{MouseControl, Outcome, Pace, StartReason};
/// let control = MouseControl::new(Pace::UNLIMITED, Some("my-mouse".into()));
/// assert_eq!(control.next_run(false), Some(StartReason::First));
/// assert!(!control.wait_for_step(), "the mouse may take its next step");
/// control.end(Outcome { text: "goal reached".into(), ..Outcome::default() });
/// assert_eq!(control.next_run(false), None, "no further run was requested");
/// ```
#[derive(Debug)]
pub struct MouseControl {
    own: Option<String>,
    kind: Option<MouseKind>,
    time_limit: Option<Duration>,
    stops_at_goal: bool,
    state: Mutex<ControlState>,
    changed: Condvar,
    /// The servers that hold a reply until the mouse may take its next step.
    wakers: Mutex<Vec<Waker>>,
}

#[derive(Debug)]
struct ControlState {
    throttle: Throttle,
    status: Option<MouseStatus>,
    stop: Option<StopReason>,
    /// The number of runs so far.
    runs: u64,
    /// The reason for a requested run of the user's own mouse.
    requested: Option<StartReason>,
    /// The number of single steps granted to the requested run, if the run starts paused.
    requested_steps: Option<u32>,
    is_reset_pressed: bool,
    /// The number of threads that change the maze or wait until they can. While there are any, no
    /// mouse may start.
    holds: u32,
    /// True while a thread changes the maze.
    is_held: bool,
    /// True if the program is about to exit.
    is_closed: bool,
}

impl ControlState {
    fn is_running(&self) -> bool {
        self.status.as_ref().is_some_and(MouseStatus::is_running)
    }

    fn has_ended(&self, run: u64) -> bool {
        self.runs != run || !self.is_running()
    }

    fn may_start(&self) -> bool {
        self.holds == 0 && !self.is_running()
    }

    fn begin(&mut self, status: MouseStatus, time_limit: Option<Duration>) {
        self.status = Some(status);
        self.stop = None;
        self.runs += 1;
        self.throttle.restart(time_limit);
    }

    fn request_stop(&mut self, reason: StopReason) {
        if self.is_running() {
            self.stop.get_or_insert(reason);
            self.throttle.is_stopped = true;
        }
    }
}

impl Default for MouseControl {
    fn default() -> Self {
        Self::new(Pace::from_rate(DEFAULT_RATE).unwrap_or(Pace::UNLIMITED), None)
    }
}

impl MouseControl {
    /// Returns the control for mice with this initial pace. `own` is the name of the user's own mouse,
    /// if the program runs one; its first run is already requested.
    pub fn new(pace: Pace, own: Option<String>) -> Self {
        let state = ControlState {
            throttle: Throttle::new(pace),
            status: None,
            stop: None,
            runs: 0,
            requested: own.as_ref().map(|_| StartReason::First),
            requested_steps: None,
            is_reset_pressed: false,
            holds: 0,
            is_held: false,
            is_closed: false,
        };
        let (state, changed, wakers) = (Mutex::new(state), Condvar::new(), Mutex::default());
        Self { own, kind: None, time_limit: None, stops_at_goal: false, state, changed, wakers }
    }

    /// Sets how the user's own mouse communicates. By default, its first message decides in each run.
    pub fn with_kind(self, kind: Option<MouseKind>) -> Self {
        Self { kind, ..self }
    }

    /// Limits the time of each run of the user's own mouse. Pauses do not count.
    pub fn with_time_limit(self, time_limit: Option<Duration>) -> Self {
        Self { time_limit, ..self }
    }

    /// Sets whether a run of the user's own mouse ends when the mouse reaches the goal.
    pub fn with_stop_at_goal(self, stops_at_goal: bool) -> Self {
        Self { stops_at_goal, ..self }
    }

    /// Notes what the user's own mouse has done, and stops it if it must stop at the goal.
    pub(crate) fn note_progress(&self, phases: &Phases) {
        if self.stops_at_goal && phases.is_goal_reached() {
            self.change(|state| state.request_stop(StopReason::Goal));
        }
    }

    /// Returns the name of the user's own mouse, usually the name of its file.
    pub fn own(&self) -> Option<&str> {
        self.own.as_deref()
    }

    /// Returns how the mouse of the current or latest run communicates, if it was recognized.
    pub fn kind(&self) -> Option<MouseKind> {
        lock(&self.state).status.as_ref()?.kind
    }

    /// Returns how the mouse of the run with this number communicates. If it is not known, a message of
    /// the kind `shown` decides.
    pub(crate) fn recognize(&self, run: u64, shown: Option<MouseKind>) -> Option<MouseKind> {
        let mut state = lock(&self.state);
        if state.runs != run {
            return None;
        }
        let kind = &mut state.status.as_mut()?.kind;
        shown.map(|shown| shown.accept(kind));
        *kind
    }

    /// Changes the state and wakes the threads that wait for a change.
    fn change<T>(&self, change: impl FnOnce(&mut ControlState) -> T) -> T {
        let changed = change(&mut lock(&self.state));
        self.notify();
        changed
    }

    fn notify(&self) {
        self.changed.notify_all();
        lock(&self.wakers).iter().for_each(Waker::wake);
    }

    /// Wakes these servers after each further change.
    pub(crate) fn wake_on_change(&self, wakers: impl Into<Vec<Waker>>) {
        *lock(&self.wakers) = wakers.into();
    }

    /// Decides what the mouse of the run with this number does now. A mouse whose run has ended need
    /// not wait.
    pub(crate) fn next_step(&self, run: u64, now: Instant) -> Next {
        let mut state = lock(&self.state);
        if state.has_ended(run) { Next::Step } else { state.throttle.next(now) }
    }

    /// Returns true if the run with this number has ended.
    pub(crate) fn has_ended(&self, run: u64) -> bool {
        lock(&self.state).has_ended(run)
    }

    /// Blocks the mouse until it may take its next step. Returns true if the mouse must stop instead,
    /// or if its run has ended.
    pub fn wait_for_step(&self) -> bool {
        let mut state = lock(&self.state);
        let run = state.runs;
        loop {
            if state.has_ended(run) {
                return true;
            }
            let timeout = match state.throttle.next(Instant::now()) {
                Next::Stop => return true,
                Next::Step => return false,
                Next::Pause => Duration::MAX,
                Next::Wait(timeout) => timeout,
            };
            let waited = self.changed.wait_timeout(state, timeout);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Returns the pace.
    pub fn pace(&self) -> Pace {
        lock(&self.state).throttle.pace
    }

    /// Changes the pace. The new pace also applies to a step that the mouse is waiting for.
    pub fn set_pace(&self, pace: Pace) {
        self.change(|state| state.throttle.pace = pace);
    }

    /// Waits until a run of the user's own mouse is requested, then begins the run. Returns `None`
    /// if the program must exit instead. If `stays` is false, also returns `None` if no run is
    /// requested.
    pub fn next_run(&self, stays: bool) -> Option<StartReason> {
        let name = self.own.clone()?;
        let is_idle = |state: &mut ControlState| {
            !state.is_closed
                && if state.may_start() { state.requested.is_none() && stays } else { true }
        };
        let mut state = wait_while(&self.changed, lock(&self.state), Duration::MAX, is_idle);
        if state.is_closed {
            return None;
        }
        let reason = state.requested.take()?;
        let text = match &reason {
            StartReason::FileChanged(file) => format!("Restarted because {file} has changed."),
            StartReason::First | StartReason::RunAgain => String::new(),
        };
        let (kind, outcome) = (self.kind, None);
        let status = MouseStatus { mouse: name, is_own: true, kind, reason: text, outcome };
        state.begin(status, self.time_limit);
        if let Some(steps) = state.requested_steps.take() {
            state.throttle.pause(steps);
        }
        drop(state);
        self.notify();
        Some(reason)
    }

    /// Begins a run of a bundled mouse.
    ///
    /// # Errors
    /// Returns a message if another mouse is running or about to start.
    pub fn begin_bundled(&self, name: &str) -> Result<(), String> {
        let mut state = lock(&self.state);
        if let Some(status) = state.status.as_ref().filter(|status| status.is_running()) {
            return Err(format!("{} is still running (stop it first)", status.mouse));
        }
        if !state.may_start() || state.requested.is_some() {
            return Err("another mouse is starting or another maze is loading (try again)".into());
        }
        let (name, kind, reason, outcome) = (name.into(), None, String::new(), None);
        state.begin(MouseStatus { mouse: name, is_own: false, kind, reason, outcome }, None);
        drop(state);
        self.notify();
        Ok(())
    }

    /// Ends the run with this outcome. Returns the reason why the mouse was stopped, if it was.
    pub fn end(&self, outcome: Outcome) -> Option<StopReason> {
        self.change(|state| {
            if let Some(status) = &mut state.status {
                status.outcome = Some(outcome);
            }
            state.is_reset_pressed = false;
            state.throttle.restart(None);
            state.stop.take()
        })
    }

    /// Returns the reason why the mouse must stop. Waits for it, but at most for the given time.
    pub fn wait_for_stop(&self, timeout: Duration) -> Option<StopReason> {
        let mut state = lock(&self.state);
        if !timeout.is_zero() {
            let time_left = state.throttle.time_left(Instant::now());
            let timeout = time_left.map_or(timeout, |left| left.min(timeout));
            state = wait_while(&self.changed, state, timeout, |state| state.stop.is_none());
        }
        let time_left = state.throttle.time_left(Instant::now());
        let is_over = time_left.is_some_and(|left| left.is_zero());
        let limit = self.time_limit.unwrap_or_default();
        state.stop.or_else(|| is_over.then_some(StopReason::TimeLimit(limit)))
    }

    /// Returns true if the user's own mouse is running.
    pub fn is_own_running(&self) -> bool {
        let state = lock(&self.state);
        state.status.as_ref().is_some_and(|status| status.is_own && status.is_running())
    }

    /// Returns true if the reset button was pressed since the previous call.
    pub fn was_reset_pressed(&self) -> bool {
        std::mem::take(&mut lock(&self.state).is_reset_pressed)
    }

    /// Presses the reset button of the mouse. Has no effect between two runs.
    pub fn press_reset(&self) {
        let mut state = lock(&self.state);
        state.is_reset_pressed = state.status.as_ref().is_none_or(MouseStatus::is_running);
    }

    /// Stops the running mouse and makes [`next_run`](Self::next_run) return `None`.
    pub fn close(&self) {
        self.change(|state| {
            state.is_closed = true;
            state.request_stop(StopReason::Exit);
        });
    }

    /// Requests a run of the user's own mouse. A running mouse is stopped first.
    pub fn request_run(&self, reason: StartReason) {
        self.change(|state| {
            (state.requested, state.requested_steps) = (Some(reason), None);
            state.request_stop(StopReason::Restart);
        });
    }

    /// Pauses the mouse after its current step and this number of further steps, at most 1000. If a run
    /// is requested, it starts paused.
    pub fn pause_after(&self, steps: u32) {
        self.change(|state| {
            if state.requested.is_some() {
                // The running mouse is about to stop.
                let granted = state.requested_steps.unwrap_or(0).saturating_add(steps);
                state.requested_steps = Some(granted);
            } else {
                state.throttle.pause(steps);
            }
        });
    }

    /// Ends a pause.
    pub fn resume(&self) {
        self.change(|state| {
            state.requested_steps = None;
            state.throttle.resume();
        });
    }

    /// Returns true if the mouse or the requested run is paused.
    pub fn is_paused(&self) -> bool {
        let state = lock(&self.state);
        match state.requested {
            Some(_) => state.requested_steps.is_some(),
            None => state.throttle.is_paused(),
        }
    }

    /// Stops the running mouse and cancels a requested run. Returns the number of the stopped run
    /// for [`wait_for_end`](Self::wait_for_end).
    pub fn stop(&self) -> u64 {
        self.change(|state| {
            (state.requested, state.requested_steps) = (None, None);
            state.request_stop(StopReason::Stop);
            state.runs
        })
    }

    /// Returns the number of runs so far, which is the number of the current or latest run.
    pub fn runs(&self) -> u64 {
        lock(&self.state).runs
    }

    /// Waits until the run with this number has ended, but at most for the given time.
    pub fn wait_for_end(&self, run: u64, timeout: Duration) {
        let is_running = |state: &mut ControlState| !state.has_ended(run);
        drop(wait_while(&self.changed, lock(&self.state), timeout, is_running));
    }

    /// Returns the status of the most recently started mouse.
    pub fn status(&self) -> Option<MouseStatus> {
        lock(&self.state).status.clone()
    }

    /// Stops the running mouse and lets no mouse start until the result is dropped, because another
    /// maze is loaded.
    ///
    /// # Errors
    /// Returns a message if the mouse does not stop in time.
    pub fn hold(&self, timeout: Duration) -> Result<Hold<'_>, String> {
        let was_running = self.change(|state| {
            state.holds += 1;
            state.request_stop(StopReason::NewMaze);
            state.is_running()
        });
        let is_busy = |state: &mut ControlState| state.is_held || state.is_running();
        let mut state = wait_while(&self.changed, lock(&self.state), timeout, is_busy);
        if is_busy(&mut state) {
            // The maze does not change.
            state.holds -= 1;
            self.changed.notify_all();
            state.stop = state.stop.map(|_| StopReason::Stop);
            let name = state.status.as_ref().map_or("the mouse", |status| &status.mouse);
            return Err(format!("{name} did not stop within {} s", timeout.as_secs()));
        }
        if !was_running {
            // The outcome belongs to the previous maze.
            state.status = None;
        }
        state.is_held = true;
        Ok(Hold(self))
    }
}

/// Keeps mice from starting until dropped. See [`MouseControl::hold`].
#[derive(Debug)]
#[must_use]
pub struct Hold<'a>(&'a MouseControl);

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        self.0.change(|state| {
            state.holds -= 1;
            state.is_held = false;
        });
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use std::sync::mpsc;

    use super::*;

    /// The time limit of a wait, long enough for a busy machine.
    const TIMEOUT: Duration = Duration::from_secs(300);

    /// Polls until `poll` returns a value.
    #[track_caller]
    fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = poll() {
                return found;
            }
            assert!(start.elapsed() < TIMEOUT, "waited {TIMEOUT:?} for {what}");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Runs a function on a separate thread, because the function might block forever.
    #[track_caller]
    fn within<T: Send + 'static>(what: &str, run: impl FnOnce() -> T + Send + 'static) -> T {
        let (send, result) = mpsc::channel();
        // After a timeout there is no receiver.
        thread::spawn(move || drop(send.send(run())));
        result.recv_timeout(TIMEOUT).unwrap_or_else(|error| panic!("waiting for {what}: {error}"))
    }

    fn own() -> String {
        "mouse".into()
    }

    fn outcome(text: &str) -> Outcome {
        Outcome { text: text.into(), ..Outcome::default() }
    }

    /// Runs the user's own mouse, which waits at the gate until it is stopped. Returns the reasons
    /// for the starts and the stops.
    fn drive(control: &Arc<MouseControl>) -> thread::JoinHandle<Vec<(StartReason, StopReason)>> {
        let control = Arc::clone(control);
        thread::spawn(move || {
            let mut runs = Vec::new();
            while let Some(reason) = control.next_run(true) {
                while !control.wait_for_step() {}
                runs.push((reason, control.end(outcome("ended")).unwrap()));
            }
            runs
        })
    }

    #[test]
    fn changes_take_effect_while_the_mouse_waits() {
        let hourly = Pace::from_interval(Duration::from_secs(3600));
        let control = Arc::new(MouseControl::new(hourly, Some(own())));
        control.next_run(false);
        let (mouse, (send, steps)) = (Arc::clone(&control), mpsc::sync_channel(0));
        thread::spawn(move || while !mouse.wait_for_step() && send.send(()).is_ok() {});
        control.set_pace(Pace::UNLIMITED);
        (0..100).for_each(|_| steps.recv_timeout(TIMEOUT).expect("a step"));
        control.set_pace(hourly);
        wait_for("the mouse to stop", || {
            // The mouse may have been about to wait for a step of the next run.
            control.end(outcome("ended"));
            (steps.try_recv() == Err(mpsc::TryRecvError::Disconnected)).then_some(())
        });
    }

    #[test]
    fn runs_start_and_stop_as_requested() {
        let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some(own())));
        let driver = drive(&control);
        let wait_until = |what: &str, is_running: bool| {
            wait_for(what, || (control.is_own_running() == is_running).then_some(()));
        };
        wait_until("the first run", true);
        control.wait_for_end(control.stop(), TIMEOUT);
        assert_eq!(control.status().unwrap().outcome, Some(outcome("ended")), "it has stopped");
        control.request_run(StartReason::RunAgain);
        wait_until("the second run", true);
        control.request_run(StartReason::FileChanged("mouse.py".into()));
        wait_for("the third run", || {
            Some(control.status()?.reason).filter(|reason| reason.contains("mouse.py"))
        });
        let hold = control.hold(TIMEOUT).unwrap();
        assert!(!control.is_own_running());
        control.request_run(StartReason::RunAgain);
        assert!(control.begin_bundled("flood-fill").unwrap_err().starts_with("another mouse"));
        assert!(!control.is_own_running(), "the maze changes first");
        drop(hold);
        wait_until("the fourth run", true);
        control.close();
        let file_changed = StartReason::FileChanged("mouse.py".into());
        let expected = vec![
            (StartReason::First, StopReason::Stop),
            (StartReason::RunAgain, StopReason::Restart),
            (file_changed, StopReason::NewMaze),
            (StartReason::RunAgain, StopReason::Exit),
        ];
        assert_eq!(within("the driver to end", || driver.join()).unwrap(), expected);
    }

    #[test]
    fn a_stop_waits_only_for_the_run_that_it_stops() {
        let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some(own())));
        control.next_run(false);
        let run = control.stop();
        control.request_run(StartReason::RunAgain);
        control.end(outcome("ended"));
        control.next_run(false);
        assert!(control.is_own_running());
        within("the end of the first run", move || control.wait_for_end(run, 2 * TIMEOUT));
    }

    #[test]
    fn a_pause_applies_to_a_requested_run() {
        let control = MouseControl::new(Pace::UNLIMITED, Some(own()));
        let run_again = |change: &dyn Fn()| {
            control.request_run(StartReason::RunAgain);
            change();
            let is_paused = control.is_paused();
            control.end(outcome("stopped"));
            control.next_run(false);
            assert_eq!(control.is_paused(), is_paused);
            is_paused
        };
        control.next_run(false);
        assert!(run_again(&|| control.pause_after(0)));
        assert!(lock(&control.state).throttle.is_paused());
        assert!(!run_again(&|| {}), "the pause of the previous run");
        assert!(run_again(&|| (0..2).for_each(|_| control.pause_after(1))));
        assert!(!control.wait_for_step() && !control.wait_for_step(), "two granted steps");
        assert_eq!(lock(&control.state).throttle.next(Instant::now()), Next::Pause);
        let pause_and_resume = || {
            control.pause_after(0);
            control.resume();
        };
        assert!(!run_again(&pause_and_resume));
        let pause_and_stop = || {
            control.pause_after(0);
            control.stop();
            control.request_run(StartReason::RunAgain);
        };
        assert!(!run_again(&pause_and_stop));
        control.pause_after(0);
        assert!(control.is_paused() && lock(&control.state).throttle.is_paused());
        control.resume();
        assert!(!control.is_paused());
    }

    #[test]
    fn the_own_mouse_and_bundled_mice_take_turns() {
        let control = MouseControl::new(Pace::UNLIMITED, Some(own()));
        assert_eq!(control.next_run(false), Some(StartReason::First));
        let error = control.begin_bundled("flood-fill").unwrap_err();
        assert_eq!(error, "mouse is still running (stop it first)");
        assert_eq!(control.end(outcome("ended")), None);
        assert_eq!(control.next_run(false), None, "no run is requested");
        control.begin_bundled("flood-fill").unwrap();
        assert!(!control.is_own_running() && control.begin_bundled("swing").is_err());
        // A request stops the bundled mouse.
        control.request_run(StartReason::RunAgain);
        assert!(control.wait_for_step());
        assert_eq!(control.end(outcome("stopped")), Some(StopReason::Restart));
        assert_eq!(control.next_run(false), Some(StartReason::RunAgain));
        assert!(!control.wait_for_step(), "the stop concerned the previous run");
    }

    #[test]
    fn the_time_limit_applies_to_the_own_mouse() {
        let limit = Some(Duration::ZERO);
        let control = MouseControl::new(Pace::UNLIMITED, Some(own())).with_time_limit(limit);
        control.next_run(false);
        assert!(control.wait_for_step());
        assert_eq!(control.wait_for_stop(TIMEOUT), limit.map(StopReason::TimeLimit));
        control.end(outcome("stopped"));
        assert_eq!(control.wait_for_stop(Duration::ZERO), None);
        control.begin_bundled("flood-fill").unwrap();
        assert!(!control.wait_for_step());
    }

    #[test]
    fn the_reset_button_is_pressed_once() {
        let control = MouseControl::new(Pace::UNLIMITED, Some(own()));
        control.press_reset();
        control.next_run(false);
        assert!(control.was_reset_pressed() && !control.was_reset_pressed());
        control.press_reset();
        control.end(outcome("ended"));
        control.press_reset();
        control.request_run(StartReason::RunAgain);
        control.next_run(true);
        assert!(!control.was_reset_pressed(), "the next run does not see it");
    }

    #[test]
    fn no_requested_run_starts_before_the_maze_changes() {
        let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some(own())));
        control.next_run(false);
        control.request_run(StartReason::RunAgain);
        // Two pages load mazes while the first run stops. Each page also requests a run.
        let load = |control: Arc<MouseControl>| {
            let hold = control.hold(TIMEOUT)?;
            assert!(!control.is_own_running() && lock(&control.state).is_held);
            control.request_run(StartReason::RunAgain);
            drop(hold);
            Ok::<_, String>(())
        };
        let pages = [(); 2].map(|()| {
            let control = Arc::clone(&control);
            thread::spawn(move || load(control))
        });
        wait_for("both pages", || (lock(&control.state).holds == 2).then_some(()));
        let mut state = lock(&control.state);
        state.status.as_mut().unwrap().outcome = Some(outcome("ended"));
        assert!(!state.may_start(), "the pages come first");
        drop(state);
        assert_eq!(control.end(outcome("ended")), Some(StopReason::Restart));
        let driver = Arc::clone(&control);
        let next = within("the next run", move || driver.next_run(true));
        assert_eq!(next, Some(StartReason::RunAgain));
        for page in pages {
            assert_eq!(within("the maze", || page.join()).unwrap(), Ok(()));
        }
        // A maze that cannot be loaded prevents no run.
        assert!(control.hold(Duration::ZERO).is_err());
        control.request_run(StartReason::RunAgain);
        control.end(outcome("ended"));
        assert_eq!(control.next_run(false), Some(StartReason::RunAgain));
    }
}
