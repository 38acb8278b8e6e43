//! The running server whose simulation the page shows.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use mmsim_maze::Maze;
use mmsim_mouse::{MouseControl, MouseStatus, StartReason};
use mmsim_server::{Monitor, MonitorError};
use mmsim_solvers::BundledStrategy;

use crate::http::api_error::ApiError;
use crate::mouse;
use crate::source::Source;

/// A running server, and the control of the mice that the page starts.
pub(crate) struct LiveServer {
    pub(crate) monitor: Monitor,
    /// The address that the page shows for clients.
    pub(crate) address: String,
    pub(crate) source: Arc<Source>,
    pub(crate) control: Arc<MouseControl>,
    /// The path of the current maze, as listed in the catalogue.
    maze: Mutex<String>,
}

impl LiveServer {
    pub(crate) fn new(monitor: Monitor, address: &str, maze: &Path) -> Self {
        Self {
            source: Arc::new(Source::live(monitor.clone())),
            monitor,
            address: address.into(),
            control: Arc::default(),
            maze: Mutex::new(maze.display().to_string()),
        }
    }

    /// Loads a maze into the simulator, and then runs the user's own mouse there if `run` is true.
    /// Returns the number of the new run. A running mouse must stop within `stop_time`.
    pub(crate) fn load_maze(
        &self,
        path: &str,
        name: &str,
        maze: Maze,
        run: bool,
        stop_time: Duration,
    ) -> Result<u32, ApiError> {
        // A running mouse would continue with its map of the old maze.
        let _hold = self.control.hold(stop_time).map_err(ApiError::conflict)?;
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
                "this simulator was started without a mouse (use `mmsim run -- COMMAND`)",
            ));
        }
        self.control.request_run(StartReason::RunAgain);
        Ok(())
    }

    /// Starts a bundled mouse, unless another client is searching the maze.
    pub(crate) fn start_mouse(&self, strategy: BundledStrategy) -> Result<(), ApiError> {
        if self.monitor.has_client() {
            return Err(MonitorError::HasClient.into());
        }
        mouse::start(&self.control, &self.monitor, strategy)
    }

    /// Returns the status of the most recently started mouse, or `None` if a client has replaced
    /// its states.
    pub(crate) fn mouse_status(&self) -> Option<MouseStatus> {
        let status = self.control.status()?;
        (status.is_running() || !self.monitor.has_client_states()).then_some(status)
    }

    /// Returns the path of the current maze.
    pub(crate) fn maze(&self) -> String {
        lock(&self.maze).clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
