//! The messages of a mouse in a search: the commands of mms that it writes, or its requests. All
//! threads of a search share its progress.

use std::io::{self, BufReader, BufWriter, Read, Write};
use std::mem;
use std::process::ExitStatus;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use mmsim_maze::{Cell, Heading, Maze, Pose, WallSensor, WallState};
use mmsim_mms::{Environment, Response, SimulatedMouse};
use mmsim_protocol::{Annotation, Reply, Request};
use mmsim_run::{EndFacts, Judge, Messages};
use mmsim_server::Simulation;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, Service};

use crate::commands::{CommandSource, InvalidLine, Line, execute_all, read_line};
use crate::endpoint::refuse;
use crate::kind::MouseKind;
use crate::lock;
use crate::process::Shortage;
use crate::search::SearchLimits;

/// The number of bytes without a command after which a mouse is stopped.
pub const MAX_INVALID_BYTES: usize = 4 << 20;

/// Why a search has ended.
#[derive(Clone, Debug)]
pub enum SearchEnd {
    /// The mouse has exited. The text is the last line of its stderr if it has failed.
    Exited(ExitStatus, String),
    /// The mouse does not move after it has reached the goal.
    Idle,
    /// The mouse has reached the goal, where the search ends.
    Goal,
    /// The mouse has reached the time limit.
    TimeLimit,
    /// The mouse has reached the limit of poses.
    StepLimit,
    /// The mouse has written [`MAX_INVALID_BYTES`](crate::MAX_INVALID_BYTES) without a command.
    Flood,
    /// The caller has interrupted the search.
    Interrupted,
    /// The program cannot be run, or its guard process has been killed.
    Failed(String),
    /// The system lacks something that the search needs.
    Shortage(Shortage),
}

/// The progress of a search.
pub(super) struct SearchProgress {
    /// `None` once the search is over.
    pub(super) judge: Option<Judge>,
    /// `None` until the mouse has sent a command or a request.
    pub(super) kind: Option<MouseKind>,
    /// The latest invalid line or refused request.
    pub(super) fault: Option<String>,
    /// True if the latest line was invalid, or the latest request was refused.
    is_refused: bool,
    /// The number of poses.
    pub(super) states: u32,
    limits: SearchLimits,
    /// The number of commands and requests.
    pub(super) messages: u64,
    pub(super) moved: Instant,
    sensor: WallSensor,
    pub(super) has_output_ended: bool,
    /// The reason why the search must end.
    pub(super) end: Option<SearchEnd>,
    /// Wakes the thread that waits for the end of the search.
    wake: Sender<()>,
}

/// The progress of a search, shared by its threads.
pub(super) type SharedProgress = Arc<Mutex<SearchProgress>>;

impl SearchProgress {
    /// Returns the progress of a search that begins. `wake` is notified when the output or the search
    /// ends.
    pub(super) fn new(
        judge: Judge,
        limits: SearchLimits,
        sensor: WallSensor,
        wake: Sender<()>,
    ) -> Self {
        Self {
            judge: Some(judge),
            kind: None,
            fault: None,
            is_refused: false,
            states: 0,
            limits,
            messages: 0,
            moved: Instant::now(),
            sensor,
            has_output_ended: false,
            end: None,
            wake,
        }
    }

    /// Notes a command or a request. Returns `None` if it must be ignored, because the search is over
    /// or because the mouse uses the other protocol.
    pub(super) fn accept(&mut self, kind: MouseKind) -> Option<&mut Judge> {
        let is_accepted = self.end.is_none() && kind.accept(&mut self.kind);
        self.messages += u64::from(is_accepted);
        self.is_refused &= !is_accepted;
        self.judge.as_mut().filter(|_| is_accepted)
    }

    /// Returns what the mouse has sent.
    pub(super) fn facts(&self) -> EndFacts {
        let messages = self.kind.map(|kind| match kind {
            MouseKind::Mms => Messages::Commands(self.messages),
            MouseKind::Client => Messages::Requests(self.messages),
        });
        EndFacts { messages, is_refused: self.is_refused, ..EndFacts::default() }
    }

    /// Notes in which walls a mouse for mms believes. See [`Judge::believe`].
    fn believe(&mut self, is_shown: bool, mouse: &SimulatedMouse) {
        if let Some(judge) = &mut self.judge {
            let map = mouse.map();
            judge.believe(is_shown, |cell, heading| map.wall(cell, heading) == WallState::Present);
        }
    }

    /// Adds a pose. Returns false if the search is over.
    pub(super) fn add(&mut self, pose: Pose, is_restart: bool) -> bool {
        match &mut self.judge {
            Some(judge) if self.states < self.limits.states => judge.add(pose, is_restart),
            _ => {
                self.end(SearchEnd::StepLimit);
                return false;
            }
        }
        self.states += 1;
        self.moved = Instant::now();
        true
    }

    /// Ends the search if the mouse has reached the goal and the search ends there.
    fn end_at_goal(&mut self) {
        let is_reached = |judge: &Judge| judge.phases().is_goal_reached();
        if self.limits.stops_at_goal && self.judge.as_ref().is_some_and(is_reached) {
            self.end(SearchEnd::Goal);
        }
    }

    /// Ends the search, unless it must already end for another reason.
    pub(super) fn end(&mut self, reason: SearchEnd) {
        self.end.get_or_insert(reason);
        self.wake();
    }

    pub(super) fn end_output(&mut self) {
        self.has_output_ended = true;
        self.wake();
    }

    fn wake(&self) {
        // The receiver exists as long as the search.
        let _ = self.wake.send(());
    }
}

/// Executes commands until the output of the mouse ends or the search is over. Output of a mouse that
/// does not write commands is ignored. Uses no other thread, because handing over each line would take
/// most of the time.
pub(super) fn execute_commands(
    output: impl Read,
    input: impl Write,
    maze: &Maze,
    progress: &SharedProgress,
) {
    let mut mouse = SimulatedMouse::new(maze.size(), maze.start().cell, *maze.goals());
    let mut commands = SearchCommands {
        locked: None,
        output: BufReader::new(Limited { output, left: MAX_INVALID_BYTES }),
        replies: BufWriter::new(input),
        progress,
    };
    // An error means that the search is over.
    let _ = execute_all(&mut mouse, &mut commands);
    // Sends the last replies.
    drop(commands);
    lock(progress).end_output();
}

/// The commands of a mouse in a search.
struct SearchCommands<'p, R, W: Write> {
    /// The progress while a line is executed, which is locked only once for each line. Dropped before
    /// the last replies are sent.
    locked: Option<MutexGuard<'p, SearchProgress>>,
    output: BufReader<Limited<R>>,
    replies: BufWriter<W>,
    progress: &'p SharedProgress,
}

impl<R: Read, W: Write> CommandSource<SearchProgress> for SearchCommands<'_, R, W> {
    fn environment(&mut self) -> &mut SearchProgress {
        self.locked.get_or_insert_with(|| lock(self.progress))
    }

    fn next_line(&mut self, mouse: &SimulatedMouse) -> Result<Option<Line>, SearchOver> {
        loop {
            self.locked = None;
            // The mouse may wait for the replies to all commands that it has written. It may also have
            // closed its stdin.
            if !self.output.buffer().contains(&b'\n') {
                lock(self.progress).believe(false, mouse);
                let _ = self.replies.flush();
            }
            // An error ends the output.
            let line = read_line(&mut self.output).ok().flatten();
            let is_flood = self.output.get_ref().left == 0;
            let progress = self.locked.insert(lock(self.progress));
            if progress.kind == Some(MouseKind::Client) {
                self.output.get_mut().left = MAX_INVALID_BYTES;
                if line.is_some() || is_flood {
                    continue;
                }
            } else if line.is_none() && is_flood {
                progress.end(SearchEnd::Flood);
            }
            return Ok(line.filter(|_| progress.end.is_none() && progress.judge.is_some()));
        }
    }

    fn accept(&mut self, mouse: &mut SimulatedMouse) -> bool {
        self.output.get_mut().left = MAX_INVALID_BYTES;
        let progress = self.environment();
        let is_accepted = progress.accept(MouseKind::Mms).is_some();
        is_accepted && (progress.states > 0 || progress.add(mouse.pose(), false))
    }

    fn refuse(&mut self, line: &InvalidLine<'_>) {
        let progress = self.environment();
        progress.is_refused = true;
        progress.fault = Some(format!("last invalid line: {line}"));
    }

    fn reply(&mut self, mouse: &SimulatedMouse, reply: Response) -> Result<(), SearchOver> {
        if let Some(judge) = &mut self.environment().judge {
            if reply == Response::Crash {
                judge.crash();
            }
            if let Some(run) = mouse.fast_run() {
                judge.drive(run);
            }
        }
        self.environment().end_at_goal();
        // Writing may take a long time.
        self.locked = None;
        let _ = writeln!(self.replies, "{reply}");
        Ok(())
    }
}

/// The output of a mouse, which ends after a number of bytes.
struct Limited<R> {
    output: R,
    /// The number of bytes until the end.
    left: usize,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let max = buffer.len().min(self.left);
        let length = self.output.read(&mut buffer[..max])?;
        self.left -= length;
        Ok(length)
    }
}

/// The search is over.
#[derive(Debug)]
pub(super) struct SearchOver;

impl Environment for SearchProgress {
    type Error = SearchOver;

    fn has_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, SearchOver> {
        self.judge.as_mut().map(|judge| judge.read_wall(cell, heading)).ok_or(SearchOver)
    }

    fn read_wall(&mut self, cell: Cell, heading: Heading) -> Result<bool, SearchOver> {
        let Some(judge) = &mut self.judge else { return Err(SearchOver) };
        let is_wrong = self.sensor.misreads(judge.maze().size(), cell, heading);
        Ok(judge.read_wall(cell, heading) != is_wrong)
    }

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), SearchOver> {
        self.add(mouse.pose(), false).then(|| self.believe(true, mouse)).ok_or(SearchOver)
    }

    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), SearchOver> {
        self.add(mouse.pose(), true).then(|| self.believe(true, mouse)).ok_or(SearchOver)
    }
}

/// The reply to requests after the end of a search.
const OVER: &str = "the search is over";

/// A simulation whose requests are noted in the progress of the search.
pub(super) struct Requests {
    pub(super) simulation: Simulation,
    pub(super) progress: SharedProgress,
    /// True after a reset, which puts the mouse back at the start before the next state.
    pub(super) is_reset: bool,
}

impl Service for Requests {
    fn answer(
        &mut self,
        _: ClientId,
        request: &[u8],
        _frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer {
        let mut progress = lock(&self.progress);
        let Some(judge) = progress.accept(MouseKind::Client) else {
            let reason = match progress.kind {
                Some(MouseKind::Mms) if progress.end.is_none() => {
                    "the mouse has written commands of mms to its stdout"
                }
                _ => OVER,
            };
            return refuse(reply, reason);
        };
        self.simulation.handle(request, reply);
        let error = Reply::decode(reply).ok().filter(|reply| matches!(reply, Reply::Error(_)));
        let is_refused = error.as_ref().is_some_and(|error| !error.is_crash());
        match Request::decode(request, self.simulation.maze().size()) {
            _ if error.is_some_and(|error| error.is_crash()) => judge.crash(),
            Ok(Request::Walls(pose)) => judge.read_walls(pose),
            Ok(Request::Reset) => {
                self.is_reset = true;
                judge.reset();
            }
            Ok(Request::Annotations(list)) => {
                self.is_reset |= list.iter().any(|one| one == Annotation::Restart);
            }
            Ok(Request::State(state)) => {
                if !progress.add(state.pose(), mem::take(&mut self.is_reset)) {
                    return refuse(reply, OVER);
                }
                if let Some(judge) = &mut progress.judge {
                    judge.believe(true, |cell, heading| state.has_wall(cell, heading));
                }
                progress.end_at_goal();
            }
            Ok(_) => {}
            Err(error) => progress.fault = Some(format!("last refused request: {error}")),
        }
        progress.is_refused = is_refused;
        Answer::Reply { is_activity: true }
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        refuse(reply, reason);
    }
}
