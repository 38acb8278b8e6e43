//! Keeping mice from starting while another maze is loaded.

use std::sync::PoisonError;
use std::time::Duration;

use super::{ControlState, MouseControl};
use crate::mouse_status::StopReason;

/// Keeps mice from starting until dropped.
pub(crate) struct Hold<'a>(&'a MouseControl);

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        state.holds -= 1;
        state.is_held = false;
        self.0.changed.notify_all();
    }
}

impl MouseControl {
    /// Stops the running mouse and lets no mouse start until the result is dropped. Returns an
    /// error message if the mouse does not stop in time.
    pub(crate) fn hold(&self, timeout: Duration) -> Result<Hold<'_>, String> {
        let mut state = self.lock();
        let is_running = state.is_running();
        state.holds += 1;
        self.request_stop(&mut state, StopReason::NewMaze);
        let is_busy = |state: &mut ControlState| state.is_held || state.is_running();
        let waited = self.changed.wait_timeout_while(state, timeout, is_busy);
        let (mut state, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            // The maze does not change.
            state.holds -= 1;
            self.changed.notify_all();
            state.stop = state.stop.map(|_| StopReason::Stop);
            let name = state.status.as_ref().map_or("the mouse", |status| &status.name);
            return Err(format!("{name} did not stop within {} s", timeout.as_secs()));
        }
        if !is_running {
            // The outcome belongs to the previous maze.
            state.status = None;
        }
        state.is_held = true;
        Ok(Hold(self))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;
    use crate::control::tests::{ending, own};
    use crate::mouse_status::StartReason;
    use crate::throttle::Pace;
    use crate::wait::{TIMEOUT, wait_for, within};

    #[test]
    fn no_requested_run_starts_before_the_maze_changes() {
        let control = Arc::new(MouseControl::new(Pace::UNLIMITED, Some(own())));
        control.next_run(false);
        control.request_run(StartReason::RunAgain);
        // Two pages load mazes while the first run stops. Each page also requests a run.
        let load = |control: Arc<MouseControl>| {
            let hold = control.hold(TIMEOUT)?;
            assert!(!control.is_own_running() && control.lock().is_held);
            control.request_run(StartReason::RunAgain);
            drop(hold);
            Ok::<_, String>(())
        };
        let pages = [(); 2].map(|()| {
            let control = Arc::clone(&control);
            thread::spawn(move || load(control))
        });
        wait_for("both pages", || (control.lock().holds == 2).then_some(()));
        let mut state = control.lock();
        state.status.as_mut().unwrap().ending = Some(ending("ended"));
        assert!(!state.may_start(), "the pages come first");
        drop(state);
        assert_eq!(control.end(ending("ended")), Some(StopReason::Restart));
        let driver = Arc::clone(&control);
        let next = within("the next run", move || driver.next_run(true));
        assert_eq!(next, Some(StartReason::RunAgain));
        for page in pages {
            assert_eq!(within("the maze", || page.join()).unwrap(), Ok(()));
        }
        // A maze that cannot be loaded prevents no run.
        assert!(control.hold(Duration::ZERO).is_err());
        control.request_run(StartReason::RunAgain);
        control.end(ending("ended"));
        assert_eq!(control.next_run(false), Some(StartReason::RunAgain));
    }
}
