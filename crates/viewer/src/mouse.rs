//! The bundled mouse that a page can start. The mouse uses the same ZeroMQ protocol as every other
//! client.

use std::ops::ControlFlow;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_client::{Exchange, Zmq, search_run};
use mmsim_solvers::{BundledStrategy, Mouse};
use serde::Serialize;

use crate::api_error::ApiError;

/// The maximum time to wait for a reply from the server or for a mouse to stop.
const REPLY_TIMEOUT: Duration = Duration::from_secs(10);

/// The maximum pause between two steps, in milliseconds.
const MAX_PACE_MS: u64 = 10_000;

/// Runs bundled mice against a simulator, at most one mouse at a time.
pub(crate) struct Runner {
    /// The address of the simulator.
    endpoint: String,
    control: Arc<RunControl>,
}

/// The state shared by the runner and the mouse thread.
#[derive(Default)]
struct RunControl {
    state: Mutex<RunState>,
    changed: Condvar,
}

#[derive(Default)]
struct RunState {
    status: Option<RunnerStatus>,
    stop: bool,
}

/// The status of the most recently started mouse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct RunnerStatus {
    strategy: &'static str,
    #[serde(rename = "running")]
    is_running: bool,
    /// The outcome of the search, or an empty string while the mouse is running.
    #[serde(rename = "says")]
    outcome: String,
}

impl Runner {
    pub(crate) fn new(endpoint: &str) -> Self {
        Self { endpoint: endpoint.into(), control: Arc::default() }
    }

    /// Returns the status of the most recently started mouse.
    pub(crate) fn status(&self) -> Option<RunnerStatus> {
        self.control.lock().status.clone()
    }

    /// Starts a mouse, or returns an error if a mouse is already running.
    pub(crate) fn start(&self, strategy: BundledStrategy, pace_ms: u64) -> Result<(), ApiError> {
        if pace_ms > MAX_PACE_MS {
            let text = format!("the pace {pace_ms} ms is out of range (0 to {MAX_PACE_MS} ms)");
            return Err(ApiError::bad_request(text));
        }
        let mut state = self.control.lock();
        if let Some(status) = state.status.as_ref().filter(|status| status.is_running) {
            let strategy = status.strategy;
            return Err(ApiError::conflict(format!("{strategy} is still running (stop it first)")));
        }
        state.status = Some(RunnerStatus {
            strategy: strategy.name(),
            is_running: true,
            outcome: String::new(),
        });
        state.stop = false;
        drop(state);
        let (endpoint, control) = (self.endpoint.clone(), Arc::clone(&self.control));
        let pace = Duration::from_millis(pace_ms);
        // This guard is dropped even if the thread cannot start.
        let mut outcome = OutcomeOnDrop { control, outcome: "the mouse could not start".into() };
        let thread = thread::Builder::new().name("mouse".into()).spawn(move || {
            outcome.record(|control| control.search(&endpoint, strategy, pace));
        });
        thread.map(|_| ()).map_err(ApiError::internal)
    }

    /// Clears the status after the maze has changed.
    pub(crate) fn clear_status(&self) {
        self.control.lock().status = None;
    }

    /// Stops the running mouse and waits until it has stopped.
    pub(crate) fn stop(&self) {
        let mut state = self.control.lock();
        state.stop = true;
        self.control.changed.notify_all();
        let is_running =
            |state: &mut RunState| state.status.as_ref().is_some_and(|status| status.is_running);
        let _ = self.control.changed.wait_timeout_while(state, REPLY_TIMEOUT, is_running);
    }
}

/// A guard that writes the outcome to the status when dropped, even if the mouse thread panics.
struct OutcomeOnDrop {
    control: Arc<RunControl>,
    outcome: String,
}

impl OutcomeOnDrop {
    fn record(&mut self, search: impl FnOnce(&RunControl) -> Result<String, String>) {
        self.outcome = search(&self.control).unwrap_or_else(|error| error);
    }
}

impl Drop for OutcomeOnDrop {
    fn drop(&mut self) {
        if let Some(status) = &mut self.control.lock().status {
            (status.is_running, status.outcome) = (false, std::mem::take(&mut self.outcome));
        }
        self.control.changed.notify_all();
    }
}

impl RunControl {
    fn lock(&self) -> MutexGuard<'_, RunState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Searches the current maze. Returns a description of the outcome.
    fn search(
        &self,
        endpoint: &str,
        strategy: BundledStrategy,
        pace: Duration,
    ) -> Result<String, String> {
        let mut transport = Zmq::connect(endpoint, Some(REPLY_TIMEOUT), |_| {})
            .map_err(|error| error.to_string())?;
        let info = Exchange::new(&mut transport).info().map_err(|error| error.to_string())?;
        let start = info.start_pose().ok_or("expected a start")?;
        let map = info.known_maze().ok_or("expected a maze")?;
        let (mut mouse, mut stopped) = (Mouse::new(strategy.strategy(), map, start), false);
        let run = search_run(&mut transport, &mut mouse, u32::MAX, |_, _| {
            stopped = self.pause(pace);
            if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let (run, ended) = match run {
            Ok(run) if run.stats.goal_reached() => (run, "goal reached".to_string()),
            Ok(run) if stopped => (run, "stopped".into()),
            Ok(run) => (run, "gave up".into()),
            Err(broken) => (broken.run, broken.error.to_string()),
        };
        let steps = run.stats.steps();
        let visited = mouse.map().visited().len();
        Ok(format!("{ended} after {steps} steps, {visited} cells visited"))
    }

    /// Waits until `pace` has passed or the mouse is stopped. Returns true if the mouse must stop.
    fn pause(&self, pace: Duration) -> bool {
        let state = self.lock();
        let waited = self.changed.wait_timeout_while(state, pace, |state| !state.stop);
        waited.map_or(true, |(state, _)| state.stop)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_server::{Server, Simulation};
    use mmsim_tests::{stop, wait_for};

    use super::*;

    fn serve(maze: &str) -> (mmsim_server::Background, Runner) {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let server = server.spawn(Simulation::new("small", maze.parse().unwrap()));
        let runner = Runner::new(server.address());
        (server, runner)
    }

    fn wait(runner: &Runner) -> String {
        wait_for("the mouse to end", || {
            Some(runner.status().filter(|status| !status.is_running)?.outcome)
        })
    }

    #[test]
    fn a_mouse_can_run_to_the_goal_twice() {
        let (server, runner) = serve("o---o---o\n| S   G |\no---o---o\n");
        assert_eq!(runner.status(), None);
        for _ in 0..2 {
            runner.start(BundledStrategy::FloodFill, 0).unwrap();
            assert_eq!(wait(&runner), "goal reached after 1 steps, 2 cells visited");
        }
        assert_eq!(stop(server).history().len(), 2);
    }

    #[test]
    fn only_one_mouse_runs_at_a_time() {
        // A wall follower circles this maze forever.
        let (server, runner) = serve(
            "o---o---o\n|       |\no   o   o\n| S | G |\no---o   o\n|   | G |\no---o---o\n"
                .replace("o---o   o", "o---o---o")
                .as_str(),
        );
        runner.start(BundledStrategy::WeightIncrement, 60_000).unwrap_err();
        runner.start(BundledStrategy::LeftWall, 10_000).unwrap();
        let error = runner.start(BundledStrategy::FloodFill, 0).unwrap_err();
        assert_eq!(error.text, "left-wall is still running (stop it first)");
        runner.stop();
        assert_eq!(wait(&runner), "stopped after 0 steps, 1 cells visited");
        runner.stop();
        runner.start(BundledStrategy::FloodFill, 0).unwrap();
        runner.stop();
        wait(&runner);
        stop(server);
        runner.start(BundledStrategy::FloodFill, 0).unwrap();
        runner.control.lock().stop = true;
    }
}
