//! The running server whose simulation the page shows, and the bundled mice that a page can start.
//! They send the same requests as clients, in memory.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_client::{BUNDLED_MOUSE_NAME, BrokenRun, Exchange, InMemory, Named, search_run};
use mmsim_maze::{Maze, counted};
use mmsim_mouse::{MouseControl, MouseStatus, Outcome, StartReason};
use mmsim_protocol::ERROR_PREFIX;
use mmsim_run::{Ending, Goal, MovementRules, Phases, Verdict};
use mmsim_server::{Monitor, MonitorError};
use mmsim_solvers::{BundledStrategy, Mouse};

use crate::http::jobs::{ApiError, ApiResult};
use crate::source::StateSource;

/// A running server, and the control of the mice that the page starts.
pub(crate) struct LiveServer {
    pub(crate) monitor: Monitor,
    /// The address that the page shows for clients.
    pub(crate) address: String,
    pub(crate) source: Arc<StateSource>,
    pub(crate) control: Arc<MouseControl>,
    /// The path of the current maze, as listed in the catalogue.
    maze: Mutex<String>,
}

impl LiveServer {
    pub(crate) fn new(monitor: Monitor, address: &str, maze: &Path) -> Self {
        Self {
            source: Arc::new(StateSource::live(monitor.clone())),
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
    ) -> ApiResult<u32> {
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
    pub(crate) fn run_own_mouse(&self) -> ApiResult<()> {
        if self.control.own().is_none() {
            return Err(ApiError::conflict(
                "this simulator was started without a mouse (use `mmsim run COMMAND`)",
            ));
        }
        self.control.request_run(StartReason::RunAgain);
        Ok(())
    }

    /// Starts a bundled mouse, unless another client is searching the maze.
    pub(crate) fn start_mouse(&self, strategy: BundledStrategy) -> ApiResult<()> {
        if self.monitor.has_client() {
            return Err(MonitorError::HasClient.into());
        }
        start(&self.control, &self.monitor, strategy)
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

/// Starts a bundled mouse, or returns an error if another mouse is running. The mouse
/// stops when a client begins to search the maze.
pub(crate) fn start(
    control: &Arc<MouseControl>,
    monitor: &Monitor,
    strategy: BundledStrategy,
) -> ApiResult<()> {
    control.begin_bundled(strategy.name()).map_err(ApiError::conflict)?;
    let monitor = monitor.clone();
    // This guard is dropped even if the thread cannot start.
    let outcome = failed("the mouse could not start".into());
    let mut run = EndOnDrop { control: Arc::clone(control), outcome };
    let thread = thread::Builder::new()
        .name("mouse".into())
        .spawn(move || run.record(|control| search(control, &monitor, strategy)));
    thread.map(|_| ()).map_err(ApiError::internal)
}

/// A guard that ends the run when dropped, even if the thread of the mouse panics.
struct EndOnDrop {
    control: Arc<MouseControl>,
    outcome: Outcome,
}

impl EndOnDrop {
    fn record(&mut self, search: impl FnOnce(&MouseControl) -> Result<Outcome, String>) {
        self.outcome = search(&self.control).unwrap_or_else(failed);
    }
}

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        self.control.end(self.outcome.clone());
    }
}

fn failed(text: String) -> Outcome {
    let error = Some(text.clone());
    Outcome { verdict: Verdict { ending: Ending::Failed, error, ..Verdict::default() }, text }
}

/// Searches the current maze.
fn search(
    control: &MouseControl,
    monitor: &Monitor,
    strategy: BundledStrategy,
) -> Result<Outcome, String> {
    let mut transport = InMemory::new(|request: &[u8], reply: &mut Vec<u8>| {
        *reply = monitor
            .answer_without_clients(request)
            .unwrap_or_else(|error| format!("{ERROR_PREFIX}{error}").into_bytes());
    });
    let info = Exchange::new(&mut transport).info().map_err(|error| error.to_string())?;
    let start = info.start_pose().ok_or("the simulator's reply to info contains no start")?;
    let map = info.known_maze().ok_or("the simulator's reply to info contains no valid maze")?;
    let mut transport = Named::new(transport, BUNDLED_MOUSE_NAME, strategy.name())
        .map_err(|error| error.to_string())?;
    let mut mouse = Mouse::new(strategy.strategy(), map, start);
    let max_states = strategy.max_states();
    let (rules, mut phases) = (MovementRules::from_map(mouse.map(), None), Phases::default());
    let run = search_run(&mut transport, &mut mouse, max_states, |mouse, _| {
        phases.add(&rules, mouse.pose(), false);
        if control.wait_for_step() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stop = control.wait_for_stop(Duration::ZERO);
    let (run, ending, how) = match (run, stop) {
        (Ok(run), Some(reason)) => (run, Ending::Stopped, Some(reason.text())),
        (Ok(run), None) if run.is_at_limit => {
            let how = format!("gave up at the limit of {max_states} states");
            (run, Ending::StepLimit, Some(how))
        }
        (Ok(run), None) => (run, Ending::Finished, None),
        (Err(broken), _) if monitor.has_client() => {
            let how = "stopped: another client is searching the maze";
            (broken.run, Ending::Stopped, Some(how.into()))
        }
        (Err(BrokenRun { run, error }), _) => {
            let ending = if error.is_given_up() { Ending::GaveUp } else { Ending::Failed };
            (run, ending, Some(error.to_string()))
        }
    };
    let verdict = Verdict::new(&phases, ending, how.clone(), None);
    let goal = Goal { is_reached: verdict.goal_reached, error: None };
    let how = how.map(|how| how + "; ").unwrap_or_default();
    let visited = counted(mouse.map().visited().len(), "cell");
    Ok(Outcome { verdict, text: format!("{how}{goal}; {}, {visited} visited", run.stats) })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Instant;

    use mmsim_client::{Timeout, Transport, Zmq};
    use mmsim_mouse::Pace;
    use mmsim_server::{Background, Server, Simulation};

    use super::*;

    /// The time limit, long enough for a busy machine.
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

    const SMALL: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn serve(maze: &str, pace: Pace) -> (Background, Monitor, Arc<MouseControl>) {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let monitor = server.monitor();
        let server = server.spawn(Simulation::new("small", maze.parse().unwrap()));
        (server, monitor, Arc::new(MouseControl::new(pace, None)))
    }

    fn stop(server: Background) -> Simulation {
        within("the server to stop", || server.stop()).unwrap()
    }

    fn wait(control: &MouseControl) -> Outcome {
        wait_for("the mouse to end", || control.status()?.outcome)
    }

    #[test]
    fn a_mouse_can_run_to_the_goal_twice() {
        let (server, monitor, control) = serve(SMALL, Pace::UNLIMITED);
        assert_eq!(control.status(), None);
        for _ in 0..2 {
            start(&control, &monitor, BundledStrategy::FloodFill).unwrap();
            let text = "goal reached; 1 step, 2 cells visited".to_string();
            let verdict = Verdict { goal_reached: true, ..Verdict::default() };
            assert_eq!(wait(&control), Outcome { verdict, text });
        }
        assert_eq!(stop(server).history().len(), 2);
    }

    /// A maze that a wall follower circles forever.
    const CIRCLE: &str = "o---o---o---o
|           |
o   o---o   o
|   | G |   |
o   o---o   o
| S         |
o---o---o---o
";

    #[test]
    fn a_mouse_stops_at_the_limit_of_its_strategy() {
        let (server, monitor, control) = serve(CIRCLE, Pace::UNLIMITED);
        start(&control, &monitor, BundledStrategy::LeftWall).unwrap();
        let Outcome { verdict, text } = wait(&control);
        let how = "gave up at the limit of 1000 states; goal not reached; 999 steps, ";
        assert!(text.starts_with(how), "{text}");
        assert_eq!(verdict.ending, Ending::StepLimit);
        assert_eq!(stop(server).history().len(), 1000);
    }

    #[test]
    fn only_one_mouse_runs_at_a_time() {
        let (server, monitor, control) = serve(CIRCLE, Pace::from_rate(0.01).unwrap());
        start(&control, &monitor, BundledStrategy::LeftWall).unwrap();
        let error = start(&control, &monitor, BundledStrategy::FloodFill).unwrap_err();
        assert_eq!(error.text, "left-wall is still running (stop it first)");
        control.wait_for_end(control.stop(), TIMEOUT);
        assert_eq!(wait(&control).text, "stopped; goal not reached; 0 steps, 1 cell visited");
        control.wait_for_end(control.stop(), TIMEOUT);
        start(&control, &monitor, BundledStrategy::FloodFill).unwrap();
        control.wait_for_end(control.stop(), TIMEOUT);
        wait(&control);
        stop(server);
    }

    #[test]
    fn a_mouse_that_is_stopped_after_the_goal_says_so() {
        let (server, monitor, control) = serve(SMALL, Pace::from_rate(0.01).unwrap());
        start(&control, &monitor, BundledStrategy::FloodFill).unwrap();
        wait_for("the first state", || (monitor.status().states == 1).then_some(()));
        control.pause_after(1);
        wait_for("the goal", || (monitor.status().states == 2).then_some(()));
        drop(control.hold(TIMEOUT).unwrap());
        let text = "stopped: another maze was loaded; goal reached; 1 step, 2 cells visited";
        let ended = wait(&control);
        assert_eq!((ended.verdict.ending, &*ended.text), (Ending::Stopped, text));
        stop(server);
    }

    #[test]
    fn a_client_that_begins_to_search_stops_the_mouse() {
        let (server, monitor, control) = serve(SMALL, Pace::from_rate(0.01).unwrap());
        start(&control, &monitor, BundledStrategy::FloodFill).unwrap();
        wait_for("the first state", || (monitor.status().states == 1).then_some(()));
        assert_eq!(monitor.served().unwrap().strategy.as_deref(), Some("flood-fill"));
        let timeout = Timeout::After(TIMEOUT);
        let mut client = Zmq::connect(server.address(), timeout, |_| {}).unwrap();
        let mut ask = |request: &[u8]| {
            let mut reply = Vec::new();
            client.exchange(request, &mut reply).unwrap();
            reply
        };
        let state = b"S\x00\x00NC\x01\x00C\x0d\x00";
        assert_eq!(ask(b"info").first(), Some(&b'{'));
        assert!(!monitor.has_client() && !monitor.has_client_states());
        for request in [&b"reset"[..], state] {
            assert_eq!(ask(request), b"ok");
        }
        assert!(monitor.has_client() && monitor.has_client_states());
        control.set_pace(Pace::UNLIMITED);
        let text = "stopped: another client is searching the maze; goal not reached; 1 step, 1 cell visited";
        let ended = wait(&control);
        assert_eq!((ended.verdict.ending, &*ended.text), (Ending::Stopped, text));
        assert_eq!(monitor.status().states, 1, "the state of the client");
        drop(client);
        wait_for("the client to disconnect", || (!monitor.has_client()).then_some(()));
        assert!(monitor.has_client_states());
        stop(server);
    }
}
