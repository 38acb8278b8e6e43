//! The running server whose simulation the page shows.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use mmsim_maze::Maze;
use mmsim_server::{Monitor, Status};
use mmsim_solvers::BundledStrategy;

use crate::api_error::ApiError;
use crate::control::{MouseControl, StartReason};
use crate::mouse;
use crate::source::Source;

/// The maximum time to wait for a mouse to stop.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// A client of which the page knows nothing counts as running for this time after each state.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(3);

/// The reason why no bundled mouse can start while such a client is running.
const CLIENT_IS_RUNNING: &str =
    "another client is reporting states (bundled strategies can run once it has ended)";

/// A running server, and the control of the mice that the page starts.
pub(crate) struct LiveServer {
    pub(crate) monitor: Monitor,
    /// The address that the page shows for clients.
    pub(crate) address: String,
    pub(crate) source: Arc<Source>,
    pub(crate) control: Arc<MouseControl>,
    /// The address of the server itself.
    server_address: String,
    /// The path of the current maze, as listed in the catalogue.
    maze: Mutex<String>,
    activity: Mutex<Activity>,
}

impl LiveServer {
    pub(crate) fn new(monitor: Monitor, address: &str, maze: &Path) -> Self {
        Self {
            source: Arc::new(Source::live(monitor.clone())),
            activity: Mutex::new(Activity::new(monitor.status(), Instant::now())),
            monitor,
            address: address.into(),
            control: Arc::default(),
            server_address: address.into(),
            maze: Mutex::new(maze.display().to_string()),
        }
    }

    /// Loads a maze into the simulator, and then runs the user's own mouse there if `run` is true.
    /// Returns the number of the new run.
    pub(crate) fn load_maze(
        &self,
        path: &str,
        name: &str,
        maze: Maze,
        run: bool,
    ) -> Result<u32, ApiError> {
        // A running mouse would continue with its map of the old maze.
        let _hold = self.control.hold(STOP_TIMEOUT).map_err(ApiError::conflict)?;
        let status = self.monitor.serve(name, maze)?;
        path.clone_into(&mut lock(&self.maze));
        if run {
            self.run_own_mouse()?;
        }
        Ok(status.run)
    }

    /// Runs the user's own mouse. Stops a running mouse first.
    pub(crate) fn run_own_mouse(&self) -> Result<(), ApiError> {
        if self.control.own().is_none() {
            return Err(ApiError::conflict(
                "this simulator has no mouse of its own (start one with `mmsim run`)",
            ));
        }
        self.control.request_run(StartReason::RunAgain);
        Ok(())
    }

    /// Starts a bundled mouse, unless another client is searching the maze.
    pub(crate) fn start_mouse(&self, strategy: BundledStrategy) -> Result<(), ApiError> {
        if self.has_client() {
            return Err(ApiError::conflict(CLIENT_IS_RUNNING));
        }
        mouse::start(&self.control, &self.server_address, strategy)
    }

    /// Stops the running mouse.
    pub(crate) fn stop_mouse(&self) {
        self.control.stop(STOP_TIMEOUT);
    }

    /// Returns true if a client that the page does not control is searching the maze. The status of
    /// an earlier mouse is then cleared, because it does not describe the client's states.
    pub(crate) fn has_client(&self) -> bool {
        let is_ours = |since| self.control.has_run_since(since);
        let has_client =
            lock(&self.activity).has_client(self.monitor.status(), Instant::now(), is_ours);
        if has_client {
            self.control.clear_status();
        }
        has_client
    }

    /// Returns the path of the current maze.
    pub(crate) fn maze(&self) -> String {
        lock(&self.maze).clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The activity of clients that the page does not control. It is known only from the states that
/// arrive while the page runs no mouse.
struct Activity {
    status: Status,
    checked_at: Instant,
    /// The last time when the states of such a client were noticed.
    client_at: Option<Instant>,
}

impl Activity {
    const fn new(status: Status, now: Instant) -> Self {
        Self { status, checked_at: now, client_at: None }
    }

    /// Compares the status with the previous one. `is_ours` returns true if a mouse of the page has
    /// run since the given time.
    fn has_client(
        &mut self,
        status: Status,
        now: Instant,
        is_ours: impl Fn(Instant) -> bool,
    ) -> bool {
        let has_new_states = status.states > 0 && status != self.status;
        if is_ours(self.checked_at) {
            self.client_at = None;
        } else if has_new_states {
            self.client_at = Some(now);
        }
        (self.status, self.checked_at) = (status, now);
        self.client_at.is_some_and(|client| now.duration_since(client) < CLIENT_TIMEOUT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_without_a_mouse_of_the_page_come_from_a_client() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut activity = Activity::new(Status { run: 1, states: 0 }, start);
        let mut check = |ms, run, states, ours: bool| {
            activity.has_client(Status { run, states }, at(ms), |_| ours)
        };
        assert!(!check(10, 1, 0, false), "no states");
        assert!(check(20, 1, 5, false));
        assert!(check(3019, 1, 5, false) && !check(3020, 1, 5, false), "timeout");
        assert!(!check(4000, 2, 0, false), "a reset is not a search");
        assert!(check(5000, 3, 1, false), "another run");
        assert!(!check(5010, 4, 7, true), "a mouse of the page");
        assert!(!check(5020, 4, 7, false) && check(5030, 4, 8, false));
    }
}
