//! The bundled mouse that a page starts: a client like any other, through the same ZeroMQ door.

use std::ops::ControlFlow;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_client::{Zmq, ask_info, search_run};
use mmsim_solvers::{BundledStrategy, Mouse};
use serde::Serialize;

use crate::api_error::ApiError;

/// How long a reply of our own server may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// The longest pause between two steps, in milliseconds.
const LONGEST_PACE_MS: u64 = 10_000;

/// Runs one bundled mouse at a time against a simulator.
pub(crate) struct Runner {
    /// Where the simulator listens.
    endpoint: String,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    running: Mutex<Running>,
    changed: Condvar,
}

#[derive(Default)]
struct Running {
    told: Option<RunnerStatus>,
    stop: bool,
}

/// What is told of the mouse that was started last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct RunnerStatus {
    strategy: &'static str,
    running: bool,
    /// How it ended.
    says: String,
}

impl Runner {
    pub(crate) fn new(endpoint: &str) -> Self {
        Self { endpoint: endpoint.into(), shared: Arc::default() }
    }

    /// The mouse that was started last.
    pub(crate) fn told(&self) -> Option<RunnerStatus> {
        self.shared.lock().told.clone()
    }

    /// Starts a mouse, unless one is running.
    pub(crate) fn start(&self, strategy: BundledStrategy, pace_ms: u64) -> Result<(), ApiError> {
        if pace_ms > LONGEST_PACE_MS {
            let text = format!("expected a pace of 0 to {LONGEST_PACE_MS} ms, found {pace_ms}");
            return Err(ApiError::bad(text));
        }
        let mut running = self.shared.lock();
        if let Some(told) = running.told.as_ref().filter(|told| told.running) {
            let strategy = told.strategy;
            return Err(ApiError::conflict(format!("{strategy} is still running; stop it first")));
        }
        running.told =
            Some(RunnerStatus { strategy: strategy.name(), running: true, says: String::new() });
        running.stop = false;
        drop(running);
        let (endpoint, shared) = (self.endpoint.clone(), Arc::clone(&self.shared));
        let pace = Duration::from_millis(pace_ms);
        // Tells how it ended when dropped, which happens without a thread, too.
        let mut end = End { shared, says: "it could not run".into() };
        let thread = thread::Builder::new().name("mouse".into()).spawn(move || {
            end.tell_of(|shared| shared.search(&endpoint, strategy, pace));
        });
        thread.map(|_| ()).map_err(ApiError::failed)
    }

    /// Forgets the mouse that was started last: its maze is another one now.
    pub(crate) fn forget(&self) {
        self.shared.lock().told = None;
    }

    /// Stops the mouse that is running, and waits until it has stopped.
    pub(crate) fn stop(&self) {
        let mut running = self.shared.lock();
        running.stop = true;
        self.shared.changed.notify_all();
        let is_running =
            |running: &mut Running| running.told.as_ref().is_some_and(|told| told.running);
        let _ = self.shared.changed.wait_timeout_while(running, PATIENCE, is_running);
    }
}

/// The end of a mouse, however it comes.
struct End {
    shared: Arc<Shared>,
    says: String,
}

impl End {
    fn tell_of(&mut self, search: impl FnOnce(&Shared) -> Result<String, String>) {
        self.says = search(&self.shared).unwrap_or_else(|error| error);
    }
}

impl Drop for End {
    fn drop(&mut self) {
        if let Some(told) = &mut self.shared.lock().told {
            (told.running, told.says) = (false, std::mem::take(&mut self.says));
        }
        self.shared.changed.notify_all();
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Searches the maze that is served; gives how that ended.
    fn search(
        &self,
        endpoint: &str,
        strategy: BundledStrategy,
        pace: Duration,
    ) -> Result<String, String> {
        let mut transport =
            Zmq::connect(endpoint, Some(PATIENCE), |_| {}).map_err(|error| error.to_string())?;
        let info = ask_info(&mut transport).map_err(|error| error.to_string())?;
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

    /// Waits so long, or until the mouse shall stop; gives whether it shall.
    fn pause(&self, pace: Duration) -> bool {
        let running = self.lock();
        let waited = self.changed.wait_timeout_while(running, pace, |running| !running.stop);
        waited.map_or(true, |(running, _)| running.stop)
    }
}

#[cfg(test)]
mod tests {
    use mmsim_server::{Server, Simulation};
    use mmsim_tests::{stop, wait_for};

    use super::*;

    fn served(maze: &str) -> (mmsim_server::Background, Runner) {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let server = server.spawn(Simulation::new("small", maze.parse().unwrap()));
        let runner = Runner::new(server.address());
        (server, runner)
    }

    fn wait(runner: &Runner) -> String {
        wait_for("the mouse to end", || Some(runner.told().filter(|told| !told.running)?.says))
    }

    #[test]
    fn a_mouse_runs_to_the_goal_and_again() {
        let (server, runner) = served("o---o---o\n| S   G |\no---o---o\n");
        assert_eq!(runner.told(), None);
        for _ in 0..2 {
            runner.start(BundledStrategy::FloodFill, 0).unwrap();
            assert_eq!(wait(&runner), "goal reached after 1 steps, 2 cells visited");
        }
        assert_eq!(stop(server).history().len(), 2);
    }

    #[test]
    fn one_mouse_runs_at_a_time_until_it_is_stopped() {
        // A wall follower goes round for ever.
        let (server, runner) = served(
            "o---o---o\n|       |\no   o   o\n| S | G |\no---o   o\n|   | G |\no---o---o\n"
                .replace("o---o   o", "o---o---o")
                .as_str(),
        );
        runner.start(BundledStrategy::WeightIncrement, 60_000).unwrap_err();
        runner.start(BundledStrategy::LeftWall, 10_000).unwrap();
        let refusal = runner.start(BundledStrategy::FloodFill, 0).unwrap_err();
        assert_eq!(refusal.text, "left-wall is still running; stop it first");
        runner.stop();
        assert_eq!(wait(&runner), "stopped after 0 steps, 1 cells visited");
        runner.stop();
        runner.start(BundledStrategy::FloodFill, 0).unwrap();
        runner.stop();
        wait(&runner);
        stop(server);
        runner.start(BundledStrategy::FloodFill, 0).unwrap();
        runner.shared.lock().stop = true;
    }
}
