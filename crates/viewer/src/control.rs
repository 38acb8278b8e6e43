//! The control of the mouse that the page shows, which starts and stops its runs.

mod hold;

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::mouse_status::{Ending, MouseStatus, OwnMouse, StartReason, StopReason};
use crate::throttle::{MAX_SINGLE_STEPS, Pace, Throttle};

/// The pace of a mouse unless the command line sets another one, in steps per second.
const DEFAULT_RATE: f64 = 20.0;

/// The control of the mouse that a [`Viewer`](crate::Viewer) shows. At most one mouse runs at a
/// time: the user's own mouse or a bundled one. The page requests actions, and the thread of the
/// mouse carries them out.
///
/// ```
/// use mmsim_viewer::{Ending, EndingKind, MouseControl, OwnMouse, Pace, StartReason};
/// let own = OwnMouse { name: "my-mouse".into(), has_reset_button: false };
/// let control = MouseControl::new(Pace::UNLIMITED, Some(own));
/// assert_eq!(control.next_run(false), Some(StartReason::First));
/// assert!(!control.throttle().wait(), "the mouse may take its next step");
/// control.end(Ending { kind: EndingKind::Goal, text: "goal reached".into() });
/// assert_eq!(control.next_run(false), None, "no further run was requested");
/// ```
#[derive(Debug)]
pub struct MouseControl {
    throttle: Throttle,
    own: Option<OwnMouse>,
    time_limit: Option<Duration>,
    state: Mutex<ControlState>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct ControlState {
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

    fn may_start(&self) -> bool {
        self.holds == 0 && !self.is_running()
    }
}

impl Default for MouseControl {
    fn default() -> Self {
        Self::new(Pace::from_rate(DEFAULT_RATE).unwrap_or(Pace::UNLIMITED), None)
    }
}

impl MouseControl {
    /// Returns the control for mice with this initial pace. `own` is the user's own mouse, if the
    /// program runs one; its first run is already requested.
    pub fn new(pace: Pace, own: Option<OwnMouse>) -> Self {
        let requested = own.as_ref().map(|_| StartReason::First);
        let state = Mutex::new(ControlState { requested, ..ControlState::default() });
        Self {
            throttle: Throttle::new(pace),
            own,
            time_limit: None,
            state,
            changed: Condvar::new(),
        }
    }

    /// Limits the time of each run of the user's own mouse. Pauses do not count.
    pub fn with_time_limit(self, time_limit: Option<Duration>) -> Self {
        Self { time_limit, ..self }
    }

    /// Returns the gate that the mouse passes after each step.
    pub const fn throttle(&self) -> &Throttle {
        &self.throttle
    }

    /// Returns the user's own mouse.
    pub const fn own(&self) -> Option<&OwnMouse> {
        self.own.as_ref()
    }

    /// Waits until a run of the user's own mouse is requested, then begins the run. Returns `None`
    /// if the program must exit instead. If `stays` is false, also returns `None` if no run is
    /// requested.
    pub fn next_run(&self, stays: bool) -> Option<StartReason> {
        let name = &self.own.as_ref()?.name;
        let is_idle = |state: &mut ControlState| {
            !state.is_closed
                && if state.may_start() { state.requested.is_none() && stays } else { true }
        };
        let waited = self.changed.wait_while(self.lock(), is_idle);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        if state.is_closed {
            return None;
        }
        let reason = state.requested.take()?;
        let text = match &reason {
            StartReason::FileChanged(file) => format!("Restarted because {file} has changed."),
            StartReason::First | StartReason::RunAgain => String::new(),
        };
        self.begin(&mut state, name, true, text);
        if let Some(steps) = state.requested_steps.take() {
            self.throttle.pause();
            (0..steps).for_each(|_| self.throttle.step());
        }
        Some(reason)
    }

    /// Begins a run of a bundled mouse. Returns an error message if another mouse is running.
    pub(crate) fn begin_bundled(&self, name: &str) -> Result<(), String> {
        let mut state = self.lock();
        if let Some(status) = state.status.as_ref().filter(|status| status.is_running()) {
            return Err(format!("{} is still running (stop it first)", status.name));
        }
        if !state.may_start() || state.requested.is_some() {
            return Err("another mouse is starting or another maze is loading (try again)".into());
        }
        self.begin(&mut state, name, false, String::new());
        Ok(())
    }

    fn begin(&self, state: &mut ControlState, name: &str, is_own: bool, reason: String) {
        state.status = Some(MouseStatus { name: name.into(), is_own, reason, ending: None });
        state.stop = None;
        state.runs += 1;
        self.throttle.restart(self.time_limit.filter(|_| is_own));
        self.changed.notify_all();
    }

    /// Ends the run with this outcome. Returns the reason why the mouse was stopped, if it was.
    pub fn end(&self, ending: Ending) -> Option<StopReason> {
        let mut state = self.lock();
        if let Some(status) = &mut state.status {
            status.ending = Some(ending);
        }
        state.is_reset_pressed = false;
        self.throttle.restart(None);
        self.changed.notify_all();
        state.stop.take()
    }

    /// Returns the reason why the mouse must stop. Waits for it, but at most for the given time.
    pub fn wait_for_stop(&self, timeout: Duration) -> Option<StopReason> {
        let time_left = self.throttle.time_left();
        let mut state = self.lock();
        if !timeout.is_zero() && state.stop.is_none() {
            let timeout = time_left.map_or(timeout, |left| left.min(timeout));
            let is_running = |state: &mut ControlState| state.stop.is_none();
            let waited = self.changed.wait_timeout_while(state, timeout, is_running);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let is_over = self.throttle.time_left().is_some_and(|left| left.is_zero());
        state.stop.or_else(|| is_over.then_some(StopReason::TimeLimit))
    }

    /// Returns true if the user's own mouse is running.
    pub fn is_own_running(&self) -> bool {
        self.lock().status.as_ref().is_some_and(|status| status.is_own && status.is_running())
    }

    /// Returns true if the reset button was pressed since the previous call.
    pub fn was_reset_pressed(&self) -> bool {
        std::mem::take(&mut self.lock().is_reset_pressed)
    }

    /// Presses the reset button of the mouse. Has no effect between two runs.
    pub fn press_reset(&self) {
        let mut state = self.lock();
        state.is_reset_pressed = state.status.as_ref().is_none_or(MouseStatus::is_running);
    }

    /// Stops the running mouse and makes [`next_run`](Self::next_run) return `None`.
    pub fn close(&self) {
        let mut state = self.lock();
        state.is_closed = true;
        self.request_stop(&mut state, StopReason::Exit);
    }

    /// Requests a run of the user's own mouse. A running mouse is stopped first.
    pub fn request_run(&self, reason: StartReason) {
        let mut state = self.lock();
        (state.requested, state.requested_steps) = (Some(reason), None);
        self.request_stop(&mut state, StopReason::Restart);
    }

    /// Pauses the mouse after its current step. If a run is requested, the run starts paused.
    pub(crate) fn pause(&self) {
        self.pause_after(0);
    }

    /// Lets the mouse take one step, then pauses it. If a run is requested, this applies to the
    /// first step of the run.
    pub(crate) fn step(&self) {
        self.pause_after(1);
    }

    fn pause_after(&self, steps: u32) {
        let mut state = self.lock();
        if state.requested.is_some() {
            // The running mouse is about to stop.
            let granted = state.requested_steps.unwrap_or(0).saturating_add(steps);
            state.requested_steps = Some(granted.min(MAX_SINGLE_STEPS));
        } else if steps == 0 {
            self.throttle.pause();
        } else {
            self.throttle.step();
        }
    }

    /// Ends a pause.
    pub(crate) fn resume(&self) {
        self.lock().requested_steps = None;
        self.throttle.resume();
    }

    /// Returns true if the mouse or the requested run is paused.
    pub(crate) fn is_paused(&self) -> bool {
        let state = self.lock();
        if state.requested.is_some() {
            state.requested_steps.is_some()
        } else {
            self.throttle.is_paused()
        }
    }

    /// Stops the running mouse and cancels a requested run. Returns the number of the stopped run
    /// for [`wait_for_end`](Self::wait_for_end).
    pub(crate) fn stop(&self) -> u64 {
        let mut state = self.lock();
        (state.requested, state.requested_steps) = (None, None);
        self.request_stop(&mut state, StopReason::Stop);
        state.runs
    }

    /// Waits until the run with this number has ended, but at most for the given time.
    pub(crate) fn wait_for_end(&self, run: u64, timeout: Duration) {
        let state = self.lock();
        let is_running = |state: &mut ControlState| state.runs == run && state.is_running();
        let _ = self.changed.wait_timeout_while(state, timeout, is_running);
    }

    fn request_stop(&self, state: &mut ControlState, reason: StopReason) {
        if state.is_running() {
            state.stop.get_or_insert(reason);
            self.throttle.stop();
        }
        self.changed.notify_all();
    }

    /// Returns the status of the most recently started mouse.
    pub(crate) fn status(&self) -> Option<MouseStatus> {
        self.lock().status.clone()
    }

    fn lock(&self) -> MutexGuard<'_, ControlState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;
    use crate::mouse_status::EndingKind;
    use crate::wait::{TIMEOUT, wait_for, within};

    pub(super) fn own() -> OwnMouse {
        OwnMouse { name: "mouse".into(), has_reset_button: true }
    }

    pub(super) fn ending(text: &str) -> Ending {
        Ending { kind: EndingKind::GaveUp, text: text.into() }
    }

    /// Runs the user's own mouse, which waits at the gate until it is stopped. Returns the reasons
    /// for the starts and the stops.
    fn drive(control: &Arc<MouseControl>) -> thread::JoinHandle<Vec<(StartReason, StopReason)>> {
        let control = Arc::clone(control);
        thread::spawn(move || {
            let mut runs = Vec::new();
            while let Some(reason) = control.next_run(true) {
                while !control.throttle().wait() {}
                runs.push((reason, control.end(ending("ended")).unwrap()));
            }
            runs
        })
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
        assert_eq!(control.status().unwrap().ending, Some(ending("ended")), "it has stopped");
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
        control.end(ending("ended"));
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
            control.end(ending("stopped"));
            control.next_run(false);
            assert_eq!(control.is_paused(), is_paused);
            is_paused
        };
        control.next_run(false);
        assert!(run_again(&|| control.pause()));
        assert!(control.throttle().is_paused());
        assert!(!run_again(&|| {}), "the pause of the previous run");
        assert!(run_again(&|| (0..2).for_each(|_| control.step())));
        assert!(!control.throttle().wait() && !control.throttle().wait(), "two granted steps");
        assert_eq!(control.throttle().single_steps(), 0);
        let pause_and_resume = || {
            control.pause();
            control.resume();
        };
        assert!(!run_again(&pause_and_resume));
        let pause_and_stop = || {
            control.pause();
            control.stop();
            control.request_run(StartReason::RunAgain);
        };
        assert!(!run_again(&pause_and_stop));
        control.pause();
        assert!(control.is_paused() && control.throttle().is_paused());
        control.resume();
        assert!(!control.is_paused());
    }

    #[test]
    fn the_own_mouse_and_bundled_mice_take_turns() {
        let control = MouseControl::new(Pace::UNLIMITED, Some(own()));
        assert_eq!(control.next_run(false), Some(StartReason::First));
        let error = control.begin_bundled("flood-fill").unwrap_err();
        assert_eq!(error, "mouse is still running (stop it first)");
        assert_eq!(control.end(ending("ended")), None);
        assert_eq!(control.next_run(false), None, "no run is requested");
        control.begin_bundled("flood-fill").unwrap();
        assert!(!control.is_own_running() && control.begin_bundled("swing").is_err());
        // A request stops the bundled mouse.
        control.request_run(StartReason::RunAgain);
        assert!(control.throttle().wait());
        assert_eq!(control.end(ending("stopped")), Some(StopReason::Restart));
        assert_eq!(control.next_run(false), Some(StartReason::RunAgain));
        assert!(!control.throttle().wait(), "the stop concerned the previous run");
    }

    #[test]
    fn the_time_limit_applies_to_the_own_mouse() {
        let limit = Some(Duration::ZERO);
        let control = MouseControl::new(Pace::UNLIMITED, Some(own())).with_time_limit(limit);
        control.next_run(false);
        assert!(control.throttle().wait());
        assert_eq!(control.wait_for_stop(TIMEOUT), Some(StopReason::TimeLimit));
        control.end(ending("stopped"));
        assert_eq!(control.wait_for_stop(Duration::ZERO), None);
        control.begin_bundled("flood-fill").unwrap();
        assert!(!control.throttle().wait());
    }

    #[test]
    fn the_reset_button_is_pressed_once() {
        let control = MouseControl::new(Pace::UNLIMITED, Some(own()));
        control.press_reset();
        control.next_run(false);
        assert!(control.was_reset_pressed() && !control.was_reset_pressed());
        control.press_reset();
        control.end(ending("ended"));
        control.press_reset();
        control.request_run(StartReason::RunAgain);
        control.next_run(true);
        assert!(!control.was_reset_pressed(), "the next run does not see it");
    }
}
