//! The running server whose simulation the page shows.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use mmsim_maze::Maze;
use mmsim_server::Monitor;
use mmsim_solvers::BundledStrategy;

use crate::api_error::ApiError;
use crate::mouse::Runner;
use crate::source::Source;

/// A running server, and the runner that starts bundled mice for it.
pub(crate) struct LiveServer {
    pub(crate) monitor: Monitor,
    /// The address that clients connect to.
    pub(crate) address: String,
    pub(crate) source: Arc<Source>,
    pub(crate) runner: Runner,
    /// The path of the current maze, as listed in the catalogue.
    maze: Mutex<String>,
    /// A lock that is held while the maze or the mouse changes.
    change: Mutex<()>,
}

impl LiveServer {
    pub(crate) fn new(monitor: Monitor, address: &str, maze: &Path) -> Self {
        Self {
            source: Arc::new(Source::live(monitor.clone())),
            monitor,
            address: address.into(),
            runner: Runner::new(address),
            maze: Mutex::new(maze.display().to_string()),
            change: Mutex::default(),
        }
    }

    /// Loads a maze into the simulator. Returns the number of the new run.
    pub(crate) fn load_maze(&self, path: &str, name: &str, maze: Maze) -> Result<u32, ApiError> {
        let _change = self.change.lock().unwrap_or_else(PoisonError::into_inner);
        // A running mouse would continue with its map of the old maze.
        self.runner.stop();
        let status = self.monitor.serve(name, maze)?;
        self.runner.clear_status();
        path.clone_into(&mut self.maze.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(status.run)
    }

    /// Starts a bundled mouse.
    pub(crate) fn start_mouse(
        &self,
        strategy: BundledStrategy,
        pace_ms: u64,
    ) -> Result<(), ApiError> {
        let _change = self.change.lock().unwrap_or_else(PoisonError::into_inner);
        self.runner.start(strategy, pace_ms)
    }

    /// Returns the path of the current maze.
    pub(crate) fn maze(&self) -> String {
        self.maze.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
