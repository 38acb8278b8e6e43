//! One search of a program in one maze: the program runs in a new process with an endpoint of its own,
//! so that searches cannot disturb each other.

mod messages;

use std::process::Stdio;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use std::{io, mem};

use mmsim_maze::{Maze, Misreadings, WallSensor};
use mmsim_run::{EndFacts, Judge};
use mmsim_server::{Simulation, listen};

pub use self::messages::{MAX_INVALID_BYTES, SearchEnd};
use self::messages::{Requests, SearchProgress, SharedProgress};
use crate::endpoint::Endpoint;
use crate::kind::MouseKind;
use crate::lock;
use crate::process::{CHECK_INTERVAL, LastLine, MouseProcess, StartError, spawn};
use crate::program::Program;

/// A mouse that has reached the goal and has not moved for this time has finished. Many mice for mms
/// never exit.
const IDLE_AT_GOAL: Duration = Duration::from_secs(2);

/// A mouse that has reached the goal and has not moved for this time lets another search use its
/// processor.
const WAITING_AT_GOAL: Duration = Duration::from_millis(200);

/// The time without a command after which the output of a mouse that has exited counts as executed.
/// If a child process of the mouse keeps the output open, the output does not end.
const OUTPUT_TIMEOUT: Duration = Duration::from_secs(2);

/// The limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct SearchLimits {
    /// The maximum time.
    pub time: Duration,
    /// The maximum number of poses.
    pub states: u32,
    /// True if the search ends when the mouse reaches the goal.
    pub stops_at_goal: bool,
}

/// What a search has shown.
#[derive(Debug)]
pub struct SearchReport {
    /// The judge, who has seen all that the mouse has done.
    pub judge: Judge,
    /// Why the search has ended.
    pub end: SearchEnd,
    /// How the mouse communicates, or `None` if it has sent nothing.
    pub kind: Option<MouseKind>,
    /// The latest invalid line or refused request.
    pub fault: Option<String>,
    /// What the mouse has sent.
    pub sent: EndFacts,
}

/// Runs a mouse in the maze until it exits or reaches a limit. The mouse may write commands of mms or
/// send requests over `ZeroMQ`, and misreads walls. The search also ends when `must_stop` returns
/// true. `release` is called, possibly several times, when the mouse needs no processor: while it
/// waits in the goal, and after it has exited.
pub fn search(
    program: &Program,
    maze: &Maze,
    limits: SearchLimits,
    misreadings: Misreadings,
    release: &mut dyn FnMut(),
    must_stop: &dyn Fn() -> bool,
) -> SearchReport {
    let (wake, woken) = mpsc::channel();
    let sensor = WallSensor::new(misreadings, maze);
    let progress = SearchProgress::new(Judge::new(maze), limits, sensor, wake);
    let progress = Arc::new(Mutex::new(progress));
    let end = RunningMouse::start(program, maze, misreadings, &progress).map(|mut running| {
        let mut end = running.wait(limits, &progress, &woken, release, must_stop);
        let RunningMouse { process, last_line, endpoint, .. } = running;
        // Killing the process and its child processes ends their output.
        drop(process);
        if let SearchEnd::Exited(status, line) = &mut end {
            if lock(&progress).kind == Some(MouseKind::Client) {
                release();
                endpoint.finish();
            }
            if !status.success() {
                *line = last_line.get();
            }
        }
        end
    });
    let mut progress = lock(&progress);
    let judge = progress.judge.take().unwrap_or_else(|| Judge::new(maze));
    let (kind, fault, sent) = (progress.kind, progress.fault.take(), progress.facts());
    let end = end.unwrap_or_else(|error| match error {
        StartError::Mouse(reason) => SearchEnd::Failed(reason),
        StartError::Shortage(shortage) => SearchEnd::Shortage(shortage),
    });
    SearchReport { judge, end, kind, fault, sent }
}

/// Serves the maze to the mouse on a free port.
fn serve(maze: &Maze, misreadings: Misreadings, progress: &SharedProgress) -> io::Result<Endpoint> {
    let simulation = Simulation::new("maze", maze.clone()).with_misreadings(misreadings);
    let requests = Requests { simulation, progress: Arc::clone(progress), is_reset: false };
    Endpoint::start(listen("127.0.0.1", 0).map_err(io::Error::other)?, requests)
}

/// A running mouse and what it needs.
struct RunningMouse {
    process: MouseProcess,
    last_line: LastLine,
    started: Instant,
    endpoint: Endpoint,
}

impl RunningMouse {
    fn start(
        program: &Program,
        maze: &Maze,
        misreadings: Misreadings,
        progress: &SharedProgress,
    ) -> Result<Self, StartError> {
        let endpoint = serve(maze, misreadings, progress)
            .map_err(|error| format!("cannot listen for the mouse: {error}"))?;
        let started = Instant::now();
        let (mut process, stdin, stdout) =
            MouseProcess::start_piped(program, Some(endpoint.address()), Stdio::piped())?;
        let last_line = LastLine::from_process(&mut process, false)?;
        let (maze, progress) = (maze.clone(), Arc::clone(progress));
        spawn("stdout", move || messages::execute_commands(stdout, stdin, &maze, &progress))?;
        Ok(Self { process, last_line, started, endpoint })
    }

    /// Waits until the search is over.
    fn wait(
        &mut self,
        limits: SearchLimits,
        progress: &SharedProgress,
        woken: &Receiver<()>,
        release: &mut dyn FnMut(),
        must_stop: &dyn Fn() -> bool,
    ) -> SearchEnd {
        let (mut messages, mut heard, mut interval) = (0, Instant::now(), CHECK_INTERVAL);
        loop {
            let is_woken = woken.recv_timeout(interval).is_ok();
            let (now, has_output_ended) = {
                let progress = lock(progress);
                if let Some(end) = &progress.end {
                    return end.clone();
                }
                (progress.messages, progress.has_output_ended)
            };
            // A mouse whose output has ended is about to exit, unless it has only closed its output.
            let next = if is_woken { Duration::from_micros(50) } else { 2 * interval };
            interval = CHECK_INTERVAL.min(next);
            if must_stop() {
                return SearchEnd::Interrupted;
            }
            if mem::replace(&mut messages, now) != now {
                heard = Instant::now();
            }
            let is_late = self.started.elapsed() >= limits.time;
            match self.process.status() {
                // Some commands of a mouse that has exited may not be executed yet. A child process of
                // the mouse may write commands without end.
                Ok(Some(status))
                    if has_output_ended || heard.elapsed() >= OUTPUT_TIMEOUT || is_late =>
                {
                    return SearchEnd::Exited(status, String::new());
                }
                Ok(Some(_)) => continue,
                Ok(None) => {}
                Err(error) => return SearchEnd::Failed(error),
            }
            if is_late {
                return SearchEnd::TimeLimit;
            }
            let progress = lock(progress);
            let is_reached =
                progress.judge.as_ref().is_some_and(|it| it.phases().is_goal_reached());
            let waits = |time| is_reached && progress.moved.elapsed() >= time;
            if waits(IDLE_AT_GOAL) {
                return SearchEnd::Idle;
            }
            if waits(WAITING_AT_GOAL) {
                release();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_client::{Timeout, Transport, Zmq};
    use mmsim_run::SearchFigures;

    use super::*;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn start(states: u32) -> (Maze, SharedProgress, Receiver<()>) {
        let ((wake, woken), maze) = (mpsc::channel(), MAZE.parse().unwrap());
        let limits = SearchLimits { time: Duration::MAX, states, stops_at_goal: false };
        let sensor = WallSensor::new(Misreadings::default(), &maze);
        let progress = SearchProgress::new(Judge::new(&maze), limits, sensor, wake);
        (maze, Arc::new(Mutex::new(progress)), woken)
    }

    /// Executes the output of a mouse, and returns the replies and the progress.
    fn execute(output: &[u8], max_states: u32) -> (String, SharedProgress) {
        let (maze, progress, _) = start(max_states);
        let mut replies = Vec::new();
        messages::execute_commands(output, &mut replies, &maze, &progress);
        assert!(lock(&progress).has_output_ended);
        (String::from_utf8(replies).unwrap(), progress)
    }

    /// Sends requests to an endpoint with a limit of 3 states, and returns the replies.
    fn answers(requests: &[&[u8]]) -> (Vec<Vec<u8>>, SharedProgress, Receiver<()>) {
        let (maze, progress, woken) = start(3);
        let endpoint = serve(&maze, Misreadings::default(), &progress).unwrap();
        let timeout = Timeout::After(Duration::from_secs(300));
        let mut client = Zmq::connect(endpoint.address(), timeout, |_| {}).unwrap();
        let ask = |request: &&[u8]| {
            let mut reply = Vec::new();
            client.exchange(request, &mut reply).unwrap();
            reply
        };
        (requests.iter().map(ask).collect(), progress, woken)
    }

    fn figures(progress: &SharedProgress) -> SearchFigures {
        lock(progress).judge.as_mut().unwrap().figures()
    }

    #[test]
    fn commands_are_answered_and_invalid_lines_are_ignored() {
        let output =
            b"hello\nmazeWidth\nsetText 0 0 a\nwallFront\nturnRight\n\nmoveForward\nmoveForward\n";
        let (replies, progress) = execute(output, 1000);
        assert_eq!(replies, "2\ntrue\nack\nack\ncrash\n");
        let found = figures(&progress);
        assert_eq!((found.states, found.crashes, found.goal_reached), (3, Some(1), true));
        let progress = lock(&progress);
        assert!(progress.kind == Some(MouseKind::Mms) && progress.end.is_none());
    }

    #[test]
    fn a_search_ends_at_the_limit_of_states() {
        let (replies, progress) = execute(&b"turnRight\n".repeat(10), 4);
        assert_eq!(replies, "ack\nack\nack\n", "the first state is the start");
        assert_eq!(lock(&progress).states, 4);
        assert!(matches!(lock(&progress).end, Some(SearchEnd::StepLimit)));
    }

    #[test]
    fn a_flood_of_invalid_output_ends_the_search() {
        let line = b"this line is not a command of mms, but it is rather long\n";
        let flood = line.repeat(MAX_INVALID_BYTES / line.len() + 1);
        for output in [&flood[..], &b"x".repeat(2 * MAX_INVALID_BYTES)] {
            let (_, progress) = execute(output, 1000);
            assert!(matches!(lock(&progress).end, Some(SearchEnd::Flood)));
        }
        // A command now and then shows that the mouse is at work.
        let half = &flood[..flood.len() / 2];
        let (replies, progress) = execute(&[half, b"\nturnLeft\n", half].concat(), 1000);
        assert!(replies == "ack\n" && lock(&progress).end.is_none());
        let (_, progress) = execute(b"setColor 9 9 g\n\nturnLeft\n", 1000);
        let fault = lock(&progress).fault.clone().unwrap();
        insta::assert_snapshot!(fault, @r#"last invalid line: expected a cell in a maze of 2x1 cells, found "setColor 9 9 g""#);
    }

    #[test]
    fn a_client_may_print_anything() {
        let (maze, progress, _) = start(10);
        assert!(lock(&progress).accept(MouseKind::Client).is_some());
        let output = [&b"x".repeat(3 * MAX_INVALID_BYTES)[..], b"\nturnLeft\n"].concat();
        messages::execute_commands(&output[..], io::sink(), &maze, &progress);
        assert_eq!(lock(&progress).states, 0);
        let progress = lock(&progress);
        assert!(progress.end.is_none() && progress.fault.is_none());
    }

    const FIRST: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";
    const LAST: &[u8] = b"S\x01\x00EC\x01\x00C\x0d\x17";

    #[test]
    fn readings_and_states_are_noted() {
        let (replies, progress, _) =
            answers(&[b"reset", b"W\x00\x00N", FIRST, LAST, b"what?", b"reset", FIRST]);
        assert_eq!(replies[..4], [&b"ok"[..], &[1, 1, 0], b"ok", b"ok"]);
        assert!(replies[4].starts_with(b"error: expected "));
        let found = figures(&progress);
        assert_eq!((found.states, found.outcome.touches), (3, 1), "a reset is a restart");
        assert!(lock(&progress).fault.as_ref().unwrap().starts_with("last refused request: "));
    }

    #[test]
    fn states_beyond_the_limit_are_refused() {
        let (replies, progress, woken) = answers(&[FIRST, FIRST, FIRST, FIRST, b"ping"]);
        assert_eq!(replies[3..], [b"error: the search is over"; 2]);
        assert_eq!(lock(&progress).states, 3);
        assert!(matches!(lock(&progress).end, Some(SearchEnd::StepLimit)));
        assert_eq!(woken.try_recv(), Ok(()));
    }

    #[test]
    fn commands_of_mms_are_ignored_after_a_request() {
        let (_, progress, _) = answers(&[b"ping"]);
        assert!(lock(&progress).accept(MouseKind::Mms).is_none());
    }
}
