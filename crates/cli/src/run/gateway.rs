//! The address to which a mouse connects: it forwards each request to the simulator, and holds the
//! reply to a state until the mouse may take its next step.

use std::collections::BTreeSet;
use std::io;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_maze::{CellSet, MazeSize};
use mmsim_protocol::{Annotation, AnnotationWriter, ERROR_PREFIX, MAX_NAME_BYTES, StateMessage};
use mmsim_server::{LIMITS, Monitor, MonitorError};
use mmsim_viewer::MouseControl;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, RepServer, Service};
use tracing::error;

/// The maximum time to wait until a mouse that must stop has been killed.
const MAX_KILL_TIME: Duration = Duration::from_secs(10);

/// What the mouse has sent. Requests count since the start of the run, states since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Progress {
    pub(crate) requests: u64,
    pub(crate) refused: u64,
    pub(crate) states: u64,
    pub(crate) is_goal_reached: bool,
}

/// An endpoint for the mouse, which is served by a separate thread until the process exits.
pub(crate) struct Gateway {
    address: String,
    simulator: Simulator,
    tracker: Arc<Mutex<Tracker>>,
}

/// The simulator, as a client of the gateway sees it.
#[derive(Clone)]
struct Simulator {
    monitor: Monitor,
    control: Arc<MouseControl>,
}

/// The progress of the mouse, and the maze in which it is measured.
#[derive(Default)]
struct Tracker {
    progress: Progress,
    maze: Option<(MazeSize, CellSet)>,
}

impl Gateway {
    /// Serves clients of `listener`.
    pub(crate) fn start(
        listener: TcpListener,
        monitor: Monitor,
        control: Arc<MouseControl>,
    ) -> io::Result<Self> {
        let mut server = RepServer::with_config(listener, LIMITS)?;
        let address = format!("tcp://{}", server.local_address()?);
        let (simulator, tracker) = (Simulator { monitor, control }, Arc::default());
        let mut forwarder = Forwarder {
            simulator: simulator.clone(),
            tracker: Arc::clone(&tracker),
            others: BTreeSet::new(),
        };
        thread::Builder::new().name("gateway".into()).spawn(move || {
            if let Err(cause) = server.run(&mut forwarder, || false) {
                error!("cannot receive requests from the mouse: {cause}");
            }
        })?;
        Ok(Self { address, simulator, tracker })
    }

    /// Returns the address for the mouse, such as `tcp://127.0.0.1:6574`.
    pub(crate) fn address(&self) -> &str {
        &self.address
    }

    /// Resets the simulator for a run of the mouse.
    pub(crate) fn begin_run(&self) -> Result<(), MonitorError> {
        let monitor = &self.simulator.monitor;
        monitor.answer(None, b"reset", 1)?;
        self.simulator.name_mouse()?;
        let maze = monitor.served()?.maze;
        let (progress, maze) = (Progress::default(), Some((maze.size(), *maze.goals())));
        *lock(&self.tracker) = Tracker { progress, maze };
        Ok(())
    }

    pub(crate) fn progress(&self) -> Progress {
        lock(&self.tracker).progress
    }
}

impl Simulator {
    /// Adds the name of the mouse to its next state. The mouse may send another name.
    fn name_mouse(&self) -> Result<(), MonitorError> {
        let mut buffer = [0; MAX_NAME_BYTES + 16];
        let mut writer = AnnotationWriter::new(&mut buffer);
        let name = self.control.own().map_or("", |own| &own.name);
        if writer.push(Annotation::Mouse(name)).is_ok()
            && let Some(request) = writer.finish()
        {
            self.monitor.answer(None, request, 1)?;
        }
        Ok(())
    }
}

impl Tracker {
    /// Updates the progress after a request and its reply.
    fn observe(&mut self, request: &[u8], reply: &[u8]) {
        let Some((size, goals)) = &self.maze else { return };
        self.progress.requests += 1;
        if reply.starts_with(ERROR_PREFIX.as_bytes()) {
            self.progress.refused += 1;
        } else if request == b"reset" {
            let Progress { requests, refused, .. } = self.progress;
            self.progress = Progress { requests, refused, ..Progress::default() };
        } else if let Ok(pose) = StateMessage::new(request, *size).and_then(|state| state.pose()) {
            self.progress.states += 1;
            self.progress.is_goal_reached |= goals.contains(pose.cell);
        }
    }
}

fn lock(tracker: &Mutex<Tracker>) -> MutexGuard<'_, Tracker> {
    tracker.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Forwards the requests of the mouse. Other clients may use the address between two runs.
struct Forwarder {
    simulator: Simulator,
    tracker: Arc<Mutex<Tracker>>,
    /// The connected clients that have used the address between two runs, and so are not the mouse.
    others: BTreeSet<ClientId>,
}

impl Forwarder {
    /// Forwards a request, and waits after a state until the mouse may take its next step.
    fn forward(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
    ) -> Result<(Vec<u8>, bool), String> {
        let Simulator { monitor, control } = &self.simulator;
        if !control.is_own_running() {
            self.others.insert(client);
        }
        let is_own = !self.others.contains(&client);
        if is_own && control.wait_for_stop(Duration::ZERO).is_some() {
            wait_for_kill(control);
            return Err("the mouse was stopped".into());
        }
        let client = (!is_own).then_some(client);
        // Locked until the request is counted, so that the progress at the end includes every recorded
        // state.
        let tracker = is_own.then(|| lock(&self.tracker));
        let (reply, is_activity) =
            monitor.answer(client, request, frames).map_err(|error| error.to_string())?;
        if let Some(mut tracker) = tracker {
            tracker.observe(request, &reply);
        }
        if is_own && reply == b"ok" {
            if request == b"reset" {
                self.simulator.name_mouse().map_err(|error| error.to_string())?;
            } else if request.first() == Some(&b'S') && control.throttle().wait() {
                wait_for_kill(control);
            }
        }
        Ok((reply, is_activity))
    }
}

/// Waits until the process of a mouse that must stop has been killed, so that the mouse does not
/// report an error or take another step.
fn wait_for_kill(control: &MouseControl) {
    let start = Instant::now();
    while control.wait_for_stop(Duration::ZERO).is_some() && start.elapsed() < MAX_KILL_TIME {
        thread::sleep(Duration::from_millis(1));
    }
}

impl Service for Forwarder {
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> bool {
        let (answer, is_activity) = self
            .forward(client, request, frames)
            .unwrap_or_else(|reason| (format!("{ERROR_PREFIX}{reason}").into_bytes(), false));
        *reply = answer;
        is_activity
    }

    fn disconnected(&mut self, client: ClientId) {
        self.others.remove(&client);
        // A server that has stopped has no clients.
        let _ = self.simulator.monitor.disconnect(client);
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = format!("{ERROR_PREFIX}{reason}").into_bytes();
    }
}

#[cfg(test)]
mod tests {
    use mmsim_server::{Server, Simulation, listen};
    use mmsim_viewer::{Ending, EndingKind, OwnMouse, Pace, StartReason};
    use mmsim_zmtp::ReqClient;

    use super::*;

    const TIMEOUT: Duration = Duration::from_secs(300);
    const STATE: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";

    /// A gateway for a mouse that is not a process.
    struct Run {
        gateway: Gateway,
        monitor: Monitor,
        control: Arc<MouseControl>,
    }

    impl Run {
        fn new(pace: Pace) -> Self {
            let server = Server::bind("127.0.0.1", 0).unwrap();
            let monitor = server.monitor();
            let maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
            server.spawn(Simulation::new("small", maze));
            let own = OwnMouse { name: "mouse".into(), has_reset_button: false };
            let control = Arc::new(MouseControl::new(pace, Some(own)));
            let listener = listen("127.0.0.1", 0).unwrap();
            let gateway = Gateway::start(listener, monitor.clone(), Arc::clone(&control)).unwrap();
            Self { gateway, monitor, control }
        }

        fn begin(&self) {
            self.control.request_run(StartReason::RunAgain);
            self.control.next_run(false).unwrap();
            self.monitor.reserve(true);
            self.gateway.begin_run().unwrap();
        }

        fn end(&self) {
            self.control.end(Ending { kind: EndingKind::GaveUp, text: String::new() });
            self.monitor.reserve(false);
        }

        fn connect(&self) -> ReqClient {
            ReqClient::new(self.gateway.address().parse().unwrap()).unwrap()
        }
    }

    fn ask(client: &mut ReqClient, request: &[u8]) -> Vec<u8> {
        let mut reply = Vec::new();
        client.send(&[request]);
        assert_eq!(client.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        reply
    }

    #[test]
    fn a_client_of_the_pause_between_two_runs_does_not_disturb_a_run() {
        let run = Run::new(Pace::UNLIMITED);
        run.begin();
        run.end();
        let mut other = run.connect();
        for request in [&b"reset"[..], STATE, b"AL\x05\0other"] {
            assert_eq!(ask(&mut other, request), b"ok");
        }
        run.begin();
        let mut mouse = run.connect();
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        assert!(ask(&mut mouse, &STATE[1..]).starts_with(b"error: "));
        for request in [&b"reset"[..], STATE, b"AL\x05\0other"] {
            assert!(
                ask(&mut other, request).starts_with(b"error: the simulator is running its own ")
            );
        }
        assert_eq!(ask(&mut other, b"ping"), b"pong");
        let expected = Progress { requests: 2, refused: 1, states: 1, is_goal_reached: false };
        assert_eq!(run.gateway.progress(), expected);
        assert_eq!(run.monitor.status().states, 1);
        run.end();
        assert_eq!(ask(&mut other, STATE), b"ok");
    }

    #[test]
    fn annotations_of_a_run_without_states_are_dropped() {
        let run = Run::new(Pace::UNLIMITED);
        run.begin();
        assert_eq!(ask(&mut run.connect(), b"AL\x04\0died"), b"ok");
        run.end();
        run.begin();
        assert_eq!(ask(&mut run.connect(), STATE), b"ok");
        let now = run.monitor.status().run;
        assert_eq!(run.monitor.log(now, 0, 10, |_| true), Ok(vec![]));
    }

    #[test]
    fn a_stopped_mouse_receives_no_reply_while_it_runs() {
        let run = Run::new(Pace::from_interval(Duration::from_secs(3600)));
        run.begin();
        let (mut mouse, mut reply, start) = (run.connect(), Vec::new(), Instant::now());
        mouse.send(&[STATE]);
        while run.monitor.status().states == 0 {
            assert!(start.elapsed() < TIMEOUT, "waited {TIMEOUT:?} for the state");
            assert_eq!(mouse.receive(&mut reply, Duration::from_millis(1)).unwrap(), None);
        }
        run.control.close();
        assert_eq!(mouse.receive(&mut reply, Duration::from_millis(200)).unwrap(), None);
        run.end();
        assert_eq!(mouse.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        assert_eq!(reply, b"ok");
    }
}
