//! Runs a mouse in another process, once in one maze.

use std::io::BufReader;
use std::mem;
use std::process::{ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use mmsim_maze::{Maze, Pose};

use super::commands::{self, MAX_INVALID_BYTES};
use super::figures::{Ending, Figures};
use super::requests::Endpoint;
use super::track::Track;
use super::workers::Slot;
use crate::connection::ENDPOINT_VARIABLE;
use crate::mouse_process::{LAST_LINE_TIMEOUT, MouseProcess, Program, exit_text, read_last_line};
use crate::output::counted;
use crate::run::ENDPOINT_PLACEHOLDER;

/// The interval between checks of a search in which nothing has ended.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

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
pub(crate) struct SearchLimits {
    pub(crate) time: Duration,
    /// The maximum number of poses.
    pub(crate) states: u32,
}

/// How a mouse communicates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MouseKind {
    /// It writes the commands of mms to its stdout.
    Mms,
    /// It sends requests over ZeroMQ.
    Client,
}

/// What a thread of a search signals to the thread that waits for the end of the search.
#[derive(Debug)]
pub(crate) enum EndSignal {
    /// The output of the mouse has ended.
    OutputEnded,
    StepLimit,
    /// The mouse has written too many bytes without a command.
    Flood,
}

/// The state of a search, which the threads of the search share.
pub(crate) struct Progress {
    /// `None` until the mouse has sent a command or a request.
    kind: Option<MouseKind>,
    pub(crate) track: Track,
    /// The latest invalid line or refused request.
    pub(crate) fault: Option<String>,
    max_states: u32,
    /// The number of commands and requests.
    messages: u64,
    moved: Instant,
    /// True once the search is over. Further commands and requests are ignored.
    pub(crate) is_over: bool,
    over: Sender<EndSignal>,
}

/// The shared state of a search.
pub(crate) type SharedProgress = Arc<Mutex<Progress>>;

pub(crate) fn lock(progress: &SharedProgress) -> MutexGuard<'_, Progress> {
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Progress {
    /// Creates the progress of a search that begins. `over` is notified when the search is over.
    pub(crate) fn new(maze: &Maze, limits: SearchLimits, over: Sender<EndSignal>) -> Self {
        Self {
            kind: None,
            track: Track::new(maze),
            fault: None,
            max_states: limits.states,
            messages: 0,
            moved: Instant::now(),
            is_over: false,
            over,
        }
    }

    /// Notes a command or a request. Returns false if it must be ignored, because the search is over
    /// or because the mouse uses the other protocol.
    pub(crate) fn accept(&mut self, kind: MouseKind) -> bool {
        self.messages += 1;
        !self.is_over && *self.kind.get_or_insert(kind) == kind
    }

    pub(crate) const fn kind(&self) -> Option<MouseKind> {
        self.kind
    }

    /// Ends the search.
    pub(crate) fn end(&mut self, reason: EndSignal) {
        if !self.is_over {
            self.is_over = true;
            // The receiver exists as long as the search.
            let _ = self.over.send(reason);
        }
    }

    /// Adds a pose. Returns false if the search is over.
    pub(crate) fn add(&mut self, pose: Pose, is_restart: bool) -> bool {
        if self.track.states() >= self.max_states {
            self.end(EndSignal::StepLimit);
            return false;
        }
        self.moved = Instant::now();
        self.track.add(pose, is_restart);
        true
    }
}

/// Runs the mouse in the maze until it exits or reaches a limit.
pub(crate) fn search(
    program: &Program,
    maze: &Maze,
    limits: SearchLimits,
    slot: &mut Slot<'_>,
    is_interrupted: &AtomicBool,
) -> Figures {
    let (sender, over) = mpsc::channel();
    let progress = Arc::new(Mutex::new(Progress::new(maze, limits, sender)));
    let ended = Running::start(program, maze, &progress).map(|mut running| {
        let ended = running.wait(limits, &progress, &over, slot, is_interrupted);
        let Running { process, last_line, endpoint, .. } = running;
        // Killing the process and its child processes ends their output.
        drop(process);
        if matches!(ended, SearchEnd::Exited(_)) && lock(&progress).kind == Some(MouseKind::Client)
        {
            slot.release();
            endpoint.finish();
        }
        (ended, last_line)
    });
    let mut progress = lock(&progress);
    progress.is_over = true;
    let figures = progress.track.figures();
    let (ending, error) = match ended {
        Ok((ended, last_line)) => conclude(&ended, limits, &progress, &last_line),
        Err(error) => (Ending::Failed, Some(error)),
    };
    Figures {
        ending,
        error,
        crashes: (progress.kind != Some(MouseKind::Client)).then_some(progress.track.crashes),
        // A program that does nothing does not know that the goal is unreachable.
        is_rightly_given_up: figures.shortest_path.is_none()
            && ending == Ending::GaveUp
            && progress.kind.is_some(),
        is_complete: figures.is_complete || ending == Ending::Finished,
        ..figures
    }
}

/// Why a search has ended.
enum SearchEnd {
    Exited(ExitStatus),
    /// The mouse stays in the goal or does not move after it has reached the goal.
    Idle,
    TimeLimit,
    Signal(EndSignal),
    Interrupted,
    Failed(String),
}

/// A running mouse and what it needs.
struct Running {
    process: MouseProcess,
    /// Receives the last line of stderr when stderr ends.
    last_line: Receiver<String>,
    started: Instant,
    endpoint: Endpoint,
}

impl Running {
    fn start(program: &Program, maze: &Maze, progress: &SharedProgress) -> Result<Self, String> {
        let endpoint = Endpoint::start(maze, progress)
            .map_err(|error| format!("cannot listen for the mouse: {error}"))?;
        let program = program.with_argument(ENDPOINT_PLACEHOLDER, endpoint.address());
        let mut command = program.command();
        command.env(ENDPOINT_VARIABLE, endpoint.address());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let started = Instant::now();
        let mut process = MouseProcess::start(&mut command)?;
        let pipes = &mut process.0;
        let (Some(stdin), Some(stdout), Some(stderr)) =
            (pipes.stdin.take(), pipes.stdout.take(), pipes.stderr.take())
        else {
            return Err("cannot open the pipes of the mouse".into());
        };
        let (size, progress) = (maze.size(), Arc::clone(progress));
        let goals = (maze.start().cell, *maze.goals());
        spawn("stdout", move || {
            commands::execute_all(stdout, stdin, size, goals, &progress);
            let _ = lock(&progress).over.send(EndSignal::OutputEnded);
        })?;
        let (sender, last_line) = mpsc::channel();
        spawn("stderr", move || {
            // The search may be over.
            let _ = sender.send(read_last_line(BufReader::new(stderr)));
        })?;
        Ok(Self { process, last_line, started, endpoint })
    }

    /// Waits until the search is over. If the mouse waits in the goal, releases the slot, so that
    /// another search can use the processor.
    fn wait(
        &mut self,
        limits: SearchLimits,
        progress: &SharedProgress,
        over: &Receiver<EndSignal>,
        slot: &mut Slot<'_>,
        is_interrupted: &AtomicBool,
    ) -> SearchEnd {
        let (mut messages, mut heard, mut interval) = (0, Instant::now(), CHECK_INTERVAL);
        let mut has_output_ended = false;
        loop {
            match over.recv_timeout(interval) {
                // The mouse is about to exit, unless it has only closed its output.
                Ok(EndSignal::OutputEnded) => {
                    (has_output_ended, interval) = (true, Duration::from_micros(50));
                }
                Ok(over) => return SearchEnd::Signal(over),
                Err(_) => interval = CHECK_INTERVAL.min(2 * interval),
            }
            if is_interrupted.load(Ordering::Relaxed) {
                return SearchEnd::Interrupted;
            }
            let now = lock(progress).messages;
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
                    return SearchEnd::Exited(status);
                }
                Ok(Some(_)) => continue,
                Ok(None) => {}
                Err(error) => {
                    return SearchEnd::Failed(format!("cannot get the exit status: {error}"));
                }
            }
            if is_late {
                return SearchEnd::TimeLimit;
            }
            let progress = lock(progress);
            let waits = |time| progress.track.is_goal_reached() && progress.moved.elapsed() >= time;
            if waits(IDLE_AT_GOAL) {
                return SearchEnd::Idle;
            }
            if waits(WAITING_AT_GOAL) {
                slot.release();
            }
        }
    }
}

/// Starts a thread that ends when the output of the mouse ends.
fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), String> {
    let spawned = thread::Builder::new().name(name.into()).spawn(work);
    spawned.map(drop).map_err(|error| format!("cannot start a thread: {error}"))
}

/// Returns how the search ended, and the reason if it ended early.
fn conclude(
    ended: &SearchEnd,
    limits: SearchLimits,
    progress: &Progress,
    last_line: &Receiver<String>,
) -> (Ending, Option<String>) {
    if let Some([from, to]) = progress.track.jump() {
        let reason = format!("jumped from {from} to {to}, which no movement can reach");
        return (Ending::Failed, Some(reason));
    }
    let is_reached = progress.track.is_goal_reached();
    let unheard =
        format!(" (it has neither written mms commands nor connected to {ENDPOINT_VARIABLE})");
    let unheard = if progress.kind.is_none() { unheard } else { String::new() };
    let fault = progress.fault.as_ref().filter(|_| !is_reached);
    let hint = unheard + &fault.map(|fault| format!("; {fault}")).unwrap_or_default();
    match ended {
        SearchEnd::Exited(status) if !status.success() => {
            let line = last_line.recv_timeout(LAST_LINE_TIMEOUT).unwrap_or_default();
            let line = if line.is_empty() { hint } else { format!(": {line}") };
            (Ending::Failed, Some(format!("{}{line}", exit_text(*status))))
        }
        SearchEnd::Exited(_) | SearchEnd::Idle if is_reached => (Ending::Finished, None),
        SearchEnd::Exited(_) | SearchEnd::Idle => {
            (Ending::GaveUp, Some(format!("exited without reaching the goal{hint}")))
        }
        SearchEnd::TimeLimit => {
            let seconds = limits.time.as_secs_f64();
            (Ending::TimeLimit, Some(format!("stopped after {seconds} s{hint}")))
        }
        SearchEnd::Signal(EndSignal::StepLimit | EndSignal::OutputEnded) => {
            let limit = counted(limits.states, "state");
            (Ending::StepLimit, Some(format!("stopped after {limit}")))
        }
        SearchEnd::Signal(EndSignal::Flood) => {
            let limit = MAX_INVALID_BYTES >> 20;
            let reason = format!("wrote {limit} MiB without a valid command{hint}");
            (Ending::Failed, Some(reason))
        }
        SearchEnd::Failed(reason) => (Ending::Failed, Some(reason.clone())),
        SearchEnd::Interrupted => (Ending::Skipped, Some("interrupted".into())),
    }
}
