//! The bundled mice that a page can start. They send the same requests as clients, in memory.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use mmsim_client::{BUNDLED_MOUSE_NAME, Exchange, InMemory, Named, search_run};
use mmsim_protocol::ERROR_PREFIX;
use mmsim_server::Monitor;
use mmsim_solvers::{BundledStrategy, Mouse};

use crate::api_error::ApiError;
use crate::control::MouseControl;
use crate::mouse_status::{Ending, EndingKind};

/// Starts a bundled mouse, or returns an error if another mouse is running. The mouse
/// stops when a client begins to search the maze.
pub(crate) fn start(
    control: &Arc<MouseControl>,
    monitor: &Monitor,
    strategy: BundledStrategy,
) -> Result<(), ApiError> {
    control.begin_bundled(strategy.name()).map_err(ApiError::conflict)?;
    let monitor = monitor.clone();
    // This guard is dropped even if the thread cannot start.
    let ending = failed("the mouse could not start");
    let mut run = EndOnDrop { control: Arc::clone(control), ending };
    let thread = thread::Builder::new()
        .name("mouse".into())
        .spawn(move || run.record(|control| search(control, &monitor, strategy)));
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
    monitor: &Monitor,
    strategy: BundledStrategy,
) -> Result<Ending, String> {
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
    let run = search_run(&mut transport, &mut mouse, u32::MAX, |_, _| {
        if control.throttle().wait() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stop = control.wait_for_stop(Duration::ZERO);
    let (run, kind, ended) = match (run, stop) {
        (Ok(run), Some(reason)) => {
            let reached = if run.stats.goal_reached() { "reached" } else { "not reached" };
            (run, EndingKind::Stopped, format!("{}; goal {reached}", reason.text()))
        }
        (Ok(run), None) if run.stats.goal_reached() => {
            (run, EndingKind::Goal, "goal reached".into())
        }
        (Ok(run), None) => (run, EndingKind::GaveUp, "gave up".into()),
        (Err(broken), _) if monitor.has_client() => {
            let ended = "stopped: another client is searching the maze".into();
            (broken.run, EndingKind::Stopped, ended)
        }
        (Err(broken), _) => (broken.run, EndingKind::Failed, broken.error.to_string()),
    };
    let visited = mouse.map().visited().len();
    let cells = if visited == 1 { "cell" } else { "cells" };
    Ok(Ending { kind, text: format!("{ended}; {}, {visited} {cells} visited", run.stats) })
}

#[cfg(test)]
mod tests {
    use mmsim_client::{Timeout, Transport, Zmq};
    use mmsim_server::{Background, Server, Simulation};

    use super::*;
    use crate::throttle::Pace;
    use crate::wait::{TIMEOUT, wait_for, within};

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

    fn wait(control: &MouseControl) -> Ending {
        wait_for("the mouse to end", || control.status()?.ending)
    }

    #[test]
    fn a_mouse_can_run_to_the_goal_twice() {
        let (server, monitor, control) = serve(SMALL, Pace::UNLIMITED);
        assert_eq!(control.status(), None);
        for _ in 0..2 {
            start(&control, &monitor, BundledStrategy::FloodFill).unwrap();
            let text = "goal reached; 1 step, 2 cells visited".to_string();
            assert_eq!(wait(&control), Ending { kind: EndingKind::Goal, text });
        }
        assert_eq!(stop(server).history().len(), 2);
    }

    #[test]
    fn only_one_mouse_runs_at_a_time() {
        // A wall follower circles this maze forever.
        let maze = "o---o---o\n|       |\no   o   o\n| S | G |\no---o---o\n|   | G |\no---o---o\n";
        let (server, monitor, control) = serve(maze, Pace::from_rate(0.01).unwrap());
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
        control.step();
        wait_for("the goal", || (monitor.status().states == 2).then_some(()));
        drop(control.hold(TIMEOUT).unwrap());
        let text = "stopped: another maze was loaded; goal reached; 1 step, 2 cells visited";
        assert_eq!(wait(&control), Ending { kind: EndingKind::Stopped, text: text.into() });
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
        control.throttle().set_pace(Pace::UNLIMITED);
        let text = "stopped: another client is searching the maze; 1 step, 1 cell visited";
        assert_eq!(wait(&control), Ending { kind: EndingKind::Stopped, text: text.into() });
        assert_eq!(monitor.status().states, 1, "the state of the client");
        drop(client);
        wait_for("the client to disconnect", || (!monitor.has_client()).then_some(()));
        assert!(monitor.has_client_states());
        stop(server);
    }
}
