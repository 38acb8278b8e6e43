//! The bundled mice that a page can start. They use the same ZeroMQ protocol as every other client.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use mmsim_client::{Exchange, Zmq, search_run};
use mmsim_solvers::{BundledStrategy, Mouse};

use crate::api_error::ApiError;
use crate::control::{Ending, EndingKind, MouseControl};

/// The maximum time to wait for a reply from the server.
const REPLY_TIMEOUT: Duration = Duration::from_secs(10);

/// Starts a bundled mouse, or returns an error if another mouse is running. `endpoint` is the
/// address of the simulator.
pub(crate) fn start(
    control: &Arc<MouseControl>,
    endpoint: &str,
    strategy: BundledStrategy,
) -> Result<(), ApiError> {
    control.begin_bundled(strategy.name()).map_err(ApiError::conflict)?;
    let endpoint = endpoint.to_string();
    // This guard is dropped even if the thread cannot start.
    let ending = failed("the mouse could not start");
    let mut run = EndOnDrop { control: Arc::clone(control), ending };
    let thread = thread::Builder::new()
        .name("mouse".into())
        .spawn(move || run.record(|control| search(control, &endpoint, strategy)));
    thread.map(|_| ()).map_err(ApiError::internal)
}

/// A guard that ends the run when dropped, even if the thread of the mouse panics.
struct EndOnDrop {
    control: Arc<MouseControl>,
    ending: Ending,
}

impl EndOnDrop {
    fn record(&mut self, search: impl FnOnce(&MouseControl) -> Result<Ending, String>) {
        self.ending = search(&self.control).unwrap_or_else(|error| failed(&error));
    }
}

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        self.control.end(self.ending.clone());
    }
}

fn failed(text: &str) -> Ending {
    Ending { kind: EndingKind::Failed, text: text.into() }
}

/// Searches the current maze.
fn search(
    control: &MouseControl,
    endpoint: &str,
    strategy: BundledStrategy,
) -> Result<Ending, String> {
    let mut transport =
        Zmq::connect(endpoint, Some(REPLY_TIMEOUT), |_| {}).map_err(|error| error.to_string())?;
    let info = Exchange::new(&mut transport).info().map_err(|error| error.to_string())?;
    let start = info.start_pose().ok_or("expected a start")?;
    let map = info.known_maze().ok_or("expected a maze")?;
    let mut mouse = Mouse::new(strategy.strategy(), map, start);
    let run = search_run(&mut transport, &mut mouse, u32::MAX, |_, _| {
        if control.throttle().wait() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stop = control.wait_for_stop(Duration::ZERO);
    let (run, kind, ended) = match run {
        Ok(run) if run.stats.goal_reached() => (run, EndingKind::Goal, "goal reached".into()),
        Ok(run) => match stop {
            Some(reason) => (run, EndingKind::Stopped, reason.text().into()),
            None => (run, EndingKind::GaveUp, "gave up".to_string()),
        },
        Err(broken) => (broken.run, EndingKind::Failed, broken.error.to_string()),
    };
    let visited = mouse.map().visited().len();
    let cells = if visited == 1 { "cell" } else { "cells" };
    Ok(Ending { kind, text: format!("{ended} after {}, {visited} {cells} visited", run.stats) })
}

#[cfg(test)]
mod tests {
    use mmsim_server::{Server, Simulation};
    use mmsim_tests::{stop, wait_for};

    use super::*;
    use crate::throttle::Pace;

    const SMALL: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn serve(maze: &str, pace: Pace) -> (mmsim_server::Background, Arc<MouseControl>) {
        let server = Server::bind("127.0.0.1", 0).unwrap();
        let server = server.spawn(Simulation::new("small", maze.parse().unwrap()));
        (server, Arc::new(MouseControl::new(pace, None)))
    }

    fn wait(control: &MouseControl) -> Ending {
        wait_for("the mouse to end", || control.status()?.ending)
    }

    #[test]
    fn a_mouse_can_run_to_the_goal_twice() {
        let (server, control) = serve(SMALL, Pace::UNLIMITED);
        assert_eq!(control.status(), None);
        for _ in 0..2 {
            start(&control, server.address(), BundledStrategy::FloodFill).unwrap();
            let text = "goal reached after 1 step, 2 cells visited".to_string();
            assert_eq!(wait(&control), Ending { kind: EndingKind::Goal, text });
        }
        assert_eq!(stop(server).history().len(), 2);
    }

    #[test]
    fn only_one_mouse_runs_at_a_time() {
        // A wall follower circles this maze forever.
        let maze = "o---o---o\n|       |\no   o   o\n| S | G |\no---o---o\n|   | G |\no---o---o\n";
        let (server, control) = serve(maze, Pace::from_rate(0.01).unwrap());
        start(&control, server.address(), BundledStrategy::LeftWall).unwrap();
        let error = start(&control, server.address(), BundledStrategy::FloodFill).unwrap_err();
        assert_eq!(error.text, "left-wall is still running (stop it first)");
        control.stop(REPLY_TIMEOUT);
        assert_eq!(wait(&control).text, "stopped after 0 steps, 1 cell visited");
        control.stop(REPLY_TIMEOUT);
        start(&control, server.address(), BundledStrategy::FloodFill).unwrap();
        control.stop(REPLY_TIMEOUT);
        wait(&control);
        stop(server);
    }
}
