//! The address to which a mouse connects: it forwards each request to the simulator, and holds the
//! reply to a state until the mouse may take its next step.

use std::collections::BTreeSet;
use std::io;
use std::mem;
use std::net::TcpListener;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mmsim_maze::MazeSize;
use mmsim_protocol::{Annotation, AnnotationWriter, ERROR_PREFIX, MAX_NAME_BYTES, Request};
use mmsim_run::{MovementRules, Phases};
use mmsim_server::{Monitor, MonitorError};
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, Service};

use crate::control::MouseControl;
use crate::endpoint::{Endpoint, refuse};
use crate::lock;

/// The maximum time to wait until the process of a mouse that must stop has been killed.
const MAX_KILL_TIME: Duration = Duration::from_secs(10);

/// What the mouse has sent and done since the start of the run. A reset puts the mouse back at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// The number of requests.
    pub requests: u64,
    /// The number of requests that the simulator refused.
    pub refused: u64,
    /// What the mouse did.
    pub phases: Phases,
}

/// An endpoint for the mouse, which is served by a separate thread.
pub struct Gateway {
    endpoint: Endpoint,
    state: Arc<GatewayState>,
}

/// The simulator behind a gateway, the control of its mouse, and the progress of the mouse.
struct GatewayState {
    monitor: Monitor,
    control: Arc<MouseControl>,
    tracker: Mutex<Tracker>,
}

/// The progress of the mouse, and the maze in which it is measured.
#[derive(Default)]
struct Tracker {
    progress: Progress,
    maze: Option<(MazeSize, MovementRules)>,
    /// True after a reset, until the next state.
    is_reset: bool,
}

impl Gateway {
    /// Serves clients of `listener`.
    ///
    /// # Errors
    /// Returns an error if the operating system has no socket or thread left.
    pub fn start(
        listener: TcpListener,
        monitor: Monitor,
        control: Arc<MouseControl>,
    ) -> io::Result<Self> {
        let state = Arc::new(GatewayState { monitor, control, tracker: Mutex::default() });
        let forwarder = Forwarder { state: Arc::clone(&state), others: BTreeSet::new() };
        Ok(Self { endpoint: Endpoint::start(listener, forwarder)?, state })
    }

    /// Returns the address for the mouse, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        self.endpoint.address()
    }

    /// Resets the simulator for a run of the mouse.
    ///
    /// # Errors
    /// Returns an error if the simulator has stopped.
    pub fn begin_run(&self) -> Result<(), MonitorError> {
        let GatewayState { monitor, tracker, .. } = &*self.state;
        monitor.answer(None, b"reset", 1)?;
        self.state.name_mouse()?;
        let maze = monitor.served()?.maze;
        let maze = Some((maze.size(), MovementRules::from_maze(&maze)));
        *lock(tracker) = Tracker { maze, ..Tracker::default() };
        Ok(())
    }

    /// Returns what the mouse has sent so far.
    pub fn progress(&self) -> Progress {
        lock(&self.state.tracker).progress
    }
}

impl GatewayState {
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
        let Some((size, rules)) = &self.maze else { return };
        self.progress.requests += 1;
        if reply.starts_with(ERROR_PREFIX.as_bytes()) {
            self.progress.refused += 1;
        } else {
            match Request::decode(request, *size) {
                Ok(Request::Reset) => self.is_reset = true,
                Ok(Request::State(state)) => {
                    let is_restart = mem::take(&mut self.is_reset);
                    self.progress.phases.add(rules, state.pose(), is_restart);
                }
                Ok(Request::Annotations(list)) => {
                    self.is_reset |= list.iter().any(|one| one == Annotation::Restart);
                }
                _ => {}
            }
        }
    }
}

/// Forwards the requests of the mouse. Other clients may use the address between two runs.
struct Forwarder {
    state: Arc<GatewayState>,
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
        reply: &mut Vec<u8>,
    ) -> Result<bool, Box<dyn std::error::Error>> {
        let GatewayState { monitor, control, tracker } = &*self.state;
        let run = control.runs();
        if !control.is_own_running() {
            self.others.insert(client);
        }
        let is_own = !self.others.contains(&client);
        if is_own && control.wait_for_stop(Duration::ZERO).is_some() {
            // A mouse that must stop neither reports an error nor takes another step.
            control.wait_for_end(run, MAX_KILL_TIME);
            return Err("the mouse was stopped".into());
        }
        let client = (!is_own).then_some(client);
        // Locked until the request is counted, so that the progress at the end includes every recorded
        // state.
        let tracker = is_own.then(|| lock(tracker));
        let (answer, is_activity) = monitor.answer(client, request, frames)?;
        *reply = answer;
        if let Some(mut tracker) = tracker {
            tracker.observe(request, reply);
        }
        if is_own && reply == b"ok" {
            if request == b"reset" {
                self.state.name_mouse()?;
            } else if request.first() == Some(&b'S') && control.wait_for_step() {
                control.wait_for_end(run, MAX_KILL_TIME);
            }
        }
        Ok(is_activity)
    }
}

impl Service for Forwarder {
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer {
        match self.forward(client, request, frames, reply) {
            Ok(is_activity) => Answer::Reply { is_activity },
            Err(reason) => refuse(reply, reason),
        }
    }

    fn disconnected(&mut self, client: ClientId) {
        self.others.remove(&client);
        // A server that has stopped has no clients.
        let _ = self.state.monitor.disconnect(client);
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        refuse(reply, reason);
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use mmsim_server::{Server, Simulation, listen};
    use mmsim_zmtp::ReqClient;

    use super::*;
    use crate::control::{Outcome, OwnMouse, StartReason};
    use crate::throttle::Pace;

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
            self.control.end(Outcome::default());
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
        let Progress { requests, refused, phases } = run.gateway.progress();
        assert_eq!((requests, refused, phases.states), (2, 1, 1));
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
