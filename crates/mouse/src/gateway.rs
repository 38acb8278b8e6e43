//! The addresses to which a mouse connects. They forward each request to the simulator, and hold the
//! reply to a state until the mouse may take its next step.

use std::io;
use std::mem;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use mmsim_maze::MazeSize;
use mmsim_protocol::{Annotation, AnnotationWriter, MAX_NAME_BYTES, Reply, Request};
use mmsim_run::{MovementRules, Phases};
use mmsim_server::{Monitor, MonitorError};
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, Service};

use crate::claim::{Claims, Role};
use crate::control::MouseControl;
use crate::endpoint::{Endpoint, refuse};
use crate::kind::MouseKind;
use crate::lock;
use crate::throttle::Next;

/// The reply to requests of a mouse for mms.
const IS_MMS: &str = "the mouse was started as a mouse for mms, or has written a command of mms to \
    its stdout (with --as client, it may write anything)";

/// The maximum number of clients of one address that wait for their replies.
const MAX_WAITING: usize = 8;

/// What the mouse has sent and done since the start of the run. A reset puts the mouse back at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// The number of requests.
    pub requests: u64,
    /// The number of requests that the simulator refused, except after crashes.
    pub refused: u64,
    /// The number of requests that the simulator refused because a wall blocked the mouse.
    pub crashes: u64,
    /// True if the latest request was refused, except after a crash.
    pub is_refused: bool,
    /// The number of movements that a wall has blocked since the latest state.
    pub blocked: u32,
    /// What the mouse did.
    pub phases: Phases,
}

/// The public address of a simulator, whose clients include a mouse that always connects to this
/// address. Each run of the mouse has an address of its own too.
///
/// The mouse is the first connection to the address of the run that sends `S` or, if there is none,
/// the first to the public address that was opened during the run. It stays the mouse until the run
/// ends, and may reconnect. During a run, other clients may only read.
pub struct Gateway {
    public: Endpoint,
    state: Arc<GatewayState>,
}

/// A run of a mouse behind a [`Gateway`].
pub struct GatewayRun<'g> {
    /// `None` when the run has ended.
    private: Option<Endpoint>,
    address: String,
    gateway: &'g Gateway,
}

/// The simulator behind a gateway, the control of its mouse, and the mouse.
struct GatewayState {
    monitor: Monitor,
    control: Arc<MouseControl>,
    tracker: Mutex<Tracker>,
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
        let public = Endpoint::start(listener, Forwarder::new(&state, false))?;
        Ok(Self { public, state })
    }

    /// Resets the simulator and begins a run of the mouse.
    ///
    /// # Errors
    /// Returns an error if the simulator has stopped, or if the operating system has no socket or
    /// thread left.
    pub fn begin_run(&self) -> Result<GatewayRun<'_>, Box<dyn std::error::Error>> {
        let state = &self.state;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let private = Endpoint::start(listener, Forwarder::new(state, true))?;
        state.control.wake_on_change([self.public.waker(), private.waker()]);
        let mut tracker = lock(&state.tracker);
        *tracker = Tracker { claims: Some(Claims::new()), ..Tracker::default() };
        state.restart(&mut tracker)?;
        drop(tracker);
        let address = private.address().into();
        Ok(GatewayRun { private: Some(private), address, gateway: self })
    }
}

impl GatewayRun<'_> {
    /// Returns the address for the mouse, such as `tcp://127.0.0.1:43210`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Answers the requests that the mouse has sent before it exited, except those behind a reply that
    /// is not due yet, and ends the run. Returns what the mouse has sent.
    pub fn finish(mut self) -> Progress {
        self.end()
    }

    fn end(&mut self) -> Progress {
        let Some(private) = self.private.take() else { return Progress::default() };
        private.finish();
        mem::take(&mut *lock(&self.gateway.state.tracker)).progress
    }
}

impl Drop for GatewayRun<'_> {
    fn drop(&mut self) {
        self.end();
    }
}

impl GatewayState {
    /// Resets the simulator, and forgets what clients have sent during this run.
    fn restart(&self, tracker: &mut Tracker) -> Result<(), MonitorError> {
        self.monitor.answer(None, b"reset", 1)?;
        self.name_mouse()?;
        let maze = self.monitor.served()?.maze;
        tracker.maze = Some((maze.size(), MovementRules::from_maze(&maze)));
        (tracker.progress, tracker.is_reset) = (Progress::default(), false);
        Ok(())
    }

    /// Returns true until the run with this number ends.
    fn is_in_run(&self, run: u64) -> bool {
        lock(&self.tracker).claims.is_some() && self.control.runs() == run
    }

    /// Adds the name of the mouse to its next state. The mouse may send another name.
    fn name_mouse(&self) -> Result<(), MonitorError> {
        let mut buffer = [0; MAX_NAME_BYTES + 16];
        let mut writer = AnnotationWriter::new(&mut buffer);
        let name = self.control.own().unwrap_or_default();
        if writer.push(Annotation::Mouse(name)).is_ok()
            && let Some(request) = writer.finish()
        {
            self.monitor.answer(None, request, 1)?;
        }
        Ok(())
    }
}

/// The clients of a run, the progress of the mouse, and the maze in which it is measured.
#[derive(Default)]
struct Tracker {
    progress: Progress,
    maze: Option<(MazeSize, MovementRules)>,
    /// True after a reset, until the next state.
    is_reset: bool,
    /// `None` between two runs.
    claims: Option<Claims>,
}

impl Tracker {
    /// Decodes a request of this run.
    fn decode<'r>(&self, request: &'r [u8]) -> Option<Request<'r>> {
        self.maze.as_ref().and_then(|(size, _)| Request::decode(request, *size).ok())
    }

    /// Updates the progress after a request of the mouse and its reply.
    fn observe(&mut self, request: Option<Request<'_>>, reply: &[u8]) {
        self.progress.requests += 1;
        self.progress.is_refused = false;
        if let Ok(error @ Reply::Error(_)) = Reply::decode(reply) {
            let Progress { refused, crashes, is_refused, blocked, .. } = &mut self.progress;
            *is_refused = !error.is_crash();
            *blocked += u32::from(error.is_crash());
            *if error.is_crash() { crashes } else { refused } += 1;
            return;
        }
        match (request, &self.maze) {
            (Some(Request::Reset), _) => self.is_reset = true,
            (Some(Request::State(state)), Some((_, rules))) => {
                let is_restart = mem::take(&mut self.is_reset);
                self.progress.blocked = 0;
                self.progress.phases.add(rules, state.pose(), is_restart);
                if let Some(claims) = &mut self.claims {
                    claims.add_state();
                }
            }
            (Some(Request::Annotations(list)), _) => {
                self.is_reset |= list.iter().any(|one| one == Annotation::Restart);
            }
            _ => {}
        }
    }
}

/// Forwards the requests of the clients of one address.
struct Forwarder {
    state: Arc<GatewayState>,
    /// True for the address of the run.
    is_private: bool,
    waiting: Vec<Waiting>,
    /// The replies that are due now.
    due: Vec<(ClientId, Vec<u8>)>,
    next_due: Option<Instant>,
}

/// A client whose reply is due later.
struct Waiting {
    client: ClientId,
    /// The number of the run.
    run: u64,
    reason: WaitReason,
}

enum WaitReason {
    /// The mouse has sent a state, and may not take its next step yet.
    Step,
    /// The mouse must stop. It neither reports an error nor takes another step until its run has ended.
    Stop,
    /// Another client has written this request of one frame. At this time, it is refused unless the
    /// client has become the mouse.
    Role { request: Vec<u8>, until: Instant },
}

impl Forwarder {
    fn new(state: &Arc<GatewayState>, is_private: bool) -> Self {
        let (waiting, due) = (Vec::new(), Vec::new());
        Self { state: Arc::clone(state), is_private, waiting, due, next_due: None }
    }

    fn wait(&mut self, client: ClientId, reason: WaitReason) -> Answer {
        self.waiting.push(Waiting { client, run: self.state.control.runs(), reason });
        Answer::Later
    }

    /// Answers a request. `held_until` is the time at which the request must not wait for the role of
    /// its client any longer, if it has waited before.
    fn forward(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        held_until: Option<Instant>,
        reply: &mut Vec<u8>,
    ) -> Result<Answer, MonitorError> {
        let state = Arc::clone(&self.state);
        let GatewayState { monitor, control, tracker } = &*state;
        let (run, now) = (control.runs(), Instant::now());
        // Locked until the request is counted, so that the progress at the end includes every recorded
        // state.
        let mut tracker = lock(tracker);
        let decoded = tracker.decode(request).filter(|_| frames == 1);
        let is_write = decoded.is_some_and(Request::is_write);
        let role = tracker
            .claims
            .as_mut()
            .map_or(Role::Other, |claims| claims.role(client, self.is_private, is_write, now));
        let is_mouse = matches!(role, Role::Mouse | Role::Successor);
        let is_shown = is_mouse && (self.is_private || is_write);
        let kind = control.recognize(run, is_shown.then_some(MouseKind::Client));
        let role = if kind == Some(MouseKind::Mms) {
            if self.is_private {
                return Ok(refuse(reply, IS_MMS));
            }
            Role::Other
        } else {
            role
        };
        match role {
            Role::Mouse | Role::Successor if control.wait_for_stop(Duration::ZERO).is_some() => {
                return Ok(self.wait(client, WaitReason::Stop));
            }
            Role::Mouse => {}
            Role::Successor => state.restart(&mut tracker)?,
            Role::Waiting(time)
                if held_until.is_none_or(|time| now < time) && self.waiting.len() < MAX_WAITING =>
            {
                let until = held_until.unwrap_or(time);
                self.call_at(Some(until));
                return Ok(self.wait(client, WaitReason::Role { request: request.into(), until }));
            }
            Role::Waiting(_) | Role::Other => {
                drop(tracker);
                let (answer, is_activity) = monitor.answer(Some(client), request, frames)?;
                *reply = answer;
                return Ok(Answer::Reply { is_activity });
            }
        }
        let (answer, is_activity) = monitor.answer(None, request, frames)?;
        *reply = answer;
        tracker.observe(decoded, reply);
        control.note_progress(&tracker.progress.phases);
        match decoded.filter(|_| reply == b"ok") {
            Some(Request::Reset) => state.name_mouse()?,
            Some(Request::State(_)) if !self.may_step(run, now) => {
                return Ok(self.wait(client, WaitReason::Step));
            }
            _ => {}
        }
        Ok(Answer::Reply { is_activity })
    }

    /// Returns true if the mouse may take its next step now.
    fn may_step(&mut self, run: u64, now: Instant) -> bool {
        let next = self.state.control.next_step(run, now);
        if let Next::Wait(left) = next {
            self.call_at(now.checked_add(left));
        }
        next == Next::Step
    }

    /// Moves the replies that are due now from `waiting` to `due`.
    fn find_due_replies(&mut self, now: Instant) {
        self.next_due = None;
        for waiting in mem::take(&mut self.waiting) {
            let (Waiting { client, run, reason }, mut reply) = (&waiting, Vec::new());
            let is_due = match reason {
                WaitReason::Step => {
                    reply.extend(b"ok");
                    self.may_step(*run, now)
                }
                WaitReason::Stop => {
                    refuse(&mut reply, "the mouse was stopped");
                    self.state.control.has_ended(*run)
                }
                // A request of a run is not answered after the run.
                WaitReason::Role { .. } if !self.state.is_in_run(*run) => {
                    refuse(&mut reply, "the run has ended");
                    true
                }
                WaitReason::Role { request, until } => {
                    let answer = self.forward(*client, request, 1, Some(*until), &mut reply);
                    if answer == Ok(Answer::Later) {
                        // For the same or for another reason.
                        continue;
                    }
                    answer.unwrap_or_else(|error| refuse(&mut reply, error));
                    true
                }
            };
            if is_due {
                self.due.push((*client, reply));
            } else {
                self.waiting.push(waiting);
            }
        }
    }

    /// Makes the server ask for due replies again at this time.
    fn call_at(&mut self, time: Option<Instant>) {
        self.next_due = self.next_due.into_iter().chain(time).min();
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
        let forwarded = self.forward(client, request, frames, None, reply);
        forwarded.unwrap_or_else(|error| refuse(reply, error))
    }

    fn due_reply(&mut self, now: Instant, reply: &mut Vec<u8>) -> Option<ClientId> {
        if self.due.is_empty() {
            self.find_due_replies(now);
        }
        let (client, due) = self.due.pop()?;
        *reply = due;
        Some(client)
    }

    fn next_due(&self) -> Option<Instant> {
        self.next_due
    }

    fn disconnected(&mut self, client: ClientId) {
        self.waiting.retain(|waiting| waiting.client != client);
        let now = Instant::now();
        if let Some(claims) = &mut lock(&self.state.tracker).claims {
            claims.disconnect(client, now);
        }
        // A new connection of the mouse may be waiting.
        self.call_at(Some(now));
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
    use crate::control::{Outcome, StartReason};
    use crate::throttle::{MAX_DELAY, Pace};

    const TIMEOUT: Duration = Duration::from_secs(300);
    const STATE: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";

    /// A gateway for a mouse that is not a process.
    struct Harness {
        gateway: Gateway,
        monitor: Monitor,
        control: Arc<MouseControl>,
    }

    impl Harness {
        fn new(pace: Pace) -> Self {
            let server = Server::bind("127.0.0.1", 0).unwrap();
            let monitor = server.monitor();
            let maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
            server.spawn(Simulation::new("small", maze));
            let control = Arc::new(MouseControl::new(pace, Some("mouse".into())));
            let listener = listen("127.0.0.1", 0).unwrap();
            let gateway = Gateway::start(listener, monitor.clone(), Arc::clone(&control)).unwrap();
            Self { gateway, monitor, control }
        }

        fn begin(&self) -> GatewayRun<'_> {
            self.control.request_run(StartReason::RunAgain);
            self.control.next_run(false).unwrap();
            self.monitor.reserve(true);
            self.gateway.begin_run().unwrap()
        }

        fn end(&self, run: GatewayRun<'_>) -> Progress {
            let progress = run.finish();
            self.monitor.reserve(false);
            self.control.end(Outcome::default());
            progress
        }

        fn connect_to_public(&self) -> ReqClient {
            connect(self.gateway.public.address())
        }

        fn states(&self) -> usize {
            self.monitor.status().states
        }
    }

    fn connect(address: &str) -> ReqClient {
        ReqClient::new(address.parse().unwrap()).unwrap()
    }

    fn ask(client: &mut ReqClient, request: &[u8]) -> Vec<u8> {
        let mut reply = Vec::new();
        client.send(&[request]);
        assert_eq!(client.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        reply
    }

    /// Checks that a client can read, but not write.
    #[track_caller]
    fn check_reader(client: &mut ReqClient) {
        for request in [&b"reset"[..], STATE, b"AL\x05\0other"] {
            let reply = ask(client, request);
            let expected =
                b"error: the simulator is running a mouse, and only the connection of this ";
            assert!(reply.starts_with(expected), "{}", reply.escape_ascii());
        }
        assert_eq!(ask(client, b"ping"), b"pong");
        assert_eq!(ask(client, b"W\x01\x00N"), [0, 1, 1]);
        assert_eq!(ask(client, b"info")[0], b'{');
    }

    #[test]
    fn other_clients_can_only_read_during_a_run() {
        let harness = Harness::new(Pace::UNLIMITED);
        let mut early = harness.connect_to_public();
        for request in [&b"reset"[..], STATE, b"AL\x05\0other"] {
            assert_eq!(ask(&mut early, request), b"ok");
        }
        let run = harness.begin();
        check_reader(&mut early);
        let (mut mouse, mut late) = (connect(run.address()), harness.connect_to_public());
        assert_eq!(ask(&mut mouse, b"W\x00\x00N"), [1, 1, 0]);
        check_reader(&mut late);
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        assert!(ask(&mut mouse, &STATE[1..]).starts_with(b"error: "));
        check_reader(&mut early);
        check_reader(&mut late);
        let log = harness.monitor.log(harness.monitor.status().run, 0, 10, |_| true);
        assert_eq!(log, Ok(vec![]), "the annotations of another client");
        assert_eq!(harness.states(), 1);
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        let Progress { requests, refused, phases, .. } = harness.end(run);
        assert_eq!((requests, refused, phases.states), (4, 1, 2));
        assert_eq!(ask(&mut late, STATE), b"ok");
        let run = harness.begin();
        assert_ne!(run.address(), harness.gateway.public.address());
        check_reader(&mut late);
    }

    #[test]
    fn readings_of_other_clients_are_not_recorded() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        let (mut mouse, mut other) = (connect(run.address()), harness.connect_to_public());
        assert_eq!(ask(&mut other, b"W\x00\x00E"), [1, 0, 1]);
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        let block = harness.monitor.block(harness.monitor.status().run, 0).unwrap().unwrap();
        let states = block.unpack().unwrap();
        let update = states.update(0).unwrap();
        assert!(update.starts_with(b"U"), "{}", update.escape_ascii());
    }

    #[test]
    fn a_mouse_with_a_fixed_address_is_the_first_that_sends_a_state() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        let [mut mouse, mut other] = [(); 2].map(|()| harness.connect_to_public());
        assert_eq!(ask(&mut other, b"AL\x05\0other"), b"ok");
        assert_eq!(ask(&mut mouse, b"W\x00\x00N"), [1, 1, 0]);
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        check_reader(&mut other);
        let log = |harness: &Harness| {
            harness.monitor.log(harness.monitor.status().run, 0, 10, |_| true).unwrap()
        };
        assert_eq!(log(&harness), [], "what the other client had written was deleted");
        drop(mouse);
        let mut mouse = harness.connect_to_public();
        assert_eq!(ask(&mut mouse, STATE), b"ok", "the mouse has reconnected");
        check_reader(&mut other);
        assert_eq!(harness.states(), 2);
        assert_eq!(harness.end(run).phases.states, 2);
    }

    #[test]
    fn a_client_of_the_address_of_the_run_replaces_one_of_the_public_address() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        let (mut mouse, mut other) = (connect(run.address()), harness.connect_to_public());
        for _ in 0..3 {
            assert_eq!(ask(&mut other, STATE), b"ok");
        }
        assert_eq!(ask(&mut mouse, b"ping"), b"pong");
        assert_eq!(ask(&mut mouse, STATE), b"ok");
        check_reader(&mut other);
        assert_eq!(harness.states(), 1);
        let Progress { requests, phases, .. } = harness.end(run);
        assert_eq!((requests, phases.states), (2, 1));
    }

    #[test]
    fn a_request_of_another_client_that_waits_at_the_end_of_a_run_has_no_effect() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        let mut forwarder = Forwarder::new(&harness.gateway.state, false);
        let (other, until) = (ClientId::unique(), Instant::now());
        forwarder.wait(other, WaitReason::Role { request: b"reset".into(), until });
        assert_eq!(ask(&mut connect(run.address()), STATE), b"ok");
        harness.end(run);
        let mut reply = Vec::new();
        assert_eq!(forwarder.due_reply(Instant::now(), &mut reply), Some(other));
        assert_eq!((reply, harness.states()), (b"error: the run has ended".to_vec(), 1));
        assert_eq!(forwarder.due_reply(Instant::now(), &mut Vec::new()), None);
    }

    #[test]
    fn a_mouse_reconnects_before_the_end_of_its_previous_connection_is_known() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        let [mut old, mut new, mut other] = [(); 3].map(|()| connect(run.address()));
        assert_eq!(ask(&mut old, STATE), b"ok");
        assert_eq!(ask(&mut new, b"W\x00\x00N"), [1, 1, 0], "any connection may read");
        new.send(&[STATE]);
        let mut reply = Vec::new();
        assert_eq!(new.receive(&mut reply, Duration::from_millis(50)).unwrap(), None);
        assert_eq!(ask(&mut old, STATE), b"ok", "is not delayed");
        drop(old);
        assert_eq!(new.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        assert_eq!(reply, b"ok");
        let refused = ask(&mut other, STATE);
        assert!(refused.starts_with(b"error: "), "{}", refused.escape_ascii());
        assert_eq!(harness.end(run).phases.states, 3);
    }

    #[test]
    fn annotations_of_a_run_without_states_are_dropped() {
        let harness = Harness::new(Pace::UNLIMITED);
        let run = harness.begin();
        assert_eq!(ask(&mut connect(run.address()), b"AL\x04\0died"), b"ok");
        harness.end(run);
        let run = harness.begin();
        assert_eq!(ask(&mut connect(run.address()), STATE), b"ok");
        let now = harness.monitor.status().run;
        assert_eq!(harness.monitor.log(now, 0, 10, |_| true), Ok(vec![]));
    }

    #[test]
    fn a_mouse_that_waits_for_its_next_step_delays_nobody() {
        let harness = Harness::new(Pace::from_interval(Duration::from_secs(3600)));
        let run = harness.begin();
        let [mut mouse, mut second] = [(); 2].map(|()| connect(run.address()));
        let (mut other, mut reply) = (harness.connect_to_public(), Vec::new());
        mouse.send(&[STATE]);
        for _ in 0..2 {
            while harness.states() == 0 {
                assert_eq!(mouse.receive(&mut reply, Duration::from_millis(1)).unwrap(), None);
            }
            assert_eq!(ask(&mut second, b"W\x00\x00N"), [1, 1, 0]);
            check_reader(&mut other);
            harness.control.pause_after(0);
        }
        harness.control.pause_after(1);
        assert_eq!(mouse.receive(&mut reply, TIMEOUT).unwrap(), Some(1), "a single step");
        mouse.send(&[STATE]);
        assert_eq!(mouse.receive(&mut reply, Duration::from_millis(20)).unwrap(), None);
        harness.control.set_pace(Pace::UNLIMITED);
        harness.control.resume();
        assert_eq!(mouse.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        assert_eq!(reply, b"ok");
    }

    #[test]
    fn a_pace_is_kept() {
        let (steps, interval) = (400, Duration::from_micros(800));
        let harness = Harness::new(Pace::from_interval(interval));
        let run = harness.begin();
        let (mut mouse, start) = (connect(run.address()), Instant::now());
        (0..steps).for_each(|_| assert_eq!(ask(&mut mouse, STATE), b"ok"));
        assert!(start.elapsed() + MAX_DELAY >= steps * interval, "{:?}", start.elapsed());
    }

    #[test]
    fn a_stopped_mouse_receives_no_reply_while_it_runs() {
        let harness = Harness::new(Pace::from_interval(Duration::from_secs(3600)));
        let run = harness.begin();
        let (mut mouse, mut reply, start) =
            (harness.connect_to_public(), Vec::new(), Instant::now());
        mouse.send(&[STATE]);
        while harness.states() == 0 {
            assert!(start.elapsed() < TIMEOUT, "waited {TIMEOUT:?} for the state");
            assert_eq!(mouse.receive(&mut reply, Duration::from_millis(1)).unwrap(), None);
        }
        harness.control.close();
        assert_eq!(mouse.receive(&mut reply, Duration::from_millis(200)).unwrap(), None);
        assert_eq!(ask(&mut harness.connect_to_public(), b"ping"), b"pong");
        assert_eq!(harness.end(run).phases.states, 1);
        assert_eq!(mouse.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        assert_eq!(reply, b"ok");
    }
}
