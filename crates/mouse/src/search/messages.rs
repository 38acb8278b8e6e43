//! The messages of a mouse in a search: the commands of mms that it writes, or its requests.

use std::io::{self, BufReader, BufWriter, Read, Write};
use std::mem;
use std::sync::MutexGuard;

use mmsim_maze::{Cell, Heading, Maze};
use mmsim_mms::{Environment, Response, SimulatedMouse};
use mmsim_protocol::{Annotation, Request};
use mmsim_run::Judge;
use mmsim_server::Simulation;
use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, Service};

use super::progress::{MouseKind, SearchEnd, SearchProgress, SharedProgress};
use crate::commands::{CommandSource, InvalidLine, Line, execute_all, read_line};
use crate::endpoint::refuse;
use crate::lock;

/// The number of bytes without a command after which a mouse is stopped.
pub const MAX_INVALID_BYTES: usize = 4 << 20;

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

    fn next_line(&mut self, _: &SimulatedMouse) -> Result<Option<Line>, SearchOver> {
        loop {
            self.locked = None;
            // The mouse may wait for the replies to all commands that it has written. It may also have
            // closed its stdin.
            if !self.output.buffer().contains(&b'\n') {
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
        self.environment().fault = Some(format!("last invalid line: {line}"));
    }

    fn reply(&mut self, _: &SimulatedMouse, reply: Response) -> Result<(), SearchOver> {
        if reply == Response::Crash {
            self.environment().judge.as_mut().map(Judge::crash);
        }
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

    fn on_pose_change(&mut self, mouse: &SimulatedMouse) -> Result<(), SearchOver> {
        self.add(mouse.pose(), false).then_some(()).ok_or(SearchOver)
    }

    fn on_restart(&mut self, mouse: &SimulatedMouse) -> Result<(), SearchOver> {
        self.add(mouse.pose(), true).then_some(()).ok_or(SearchOver)
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
    fn answer(&mut self, _: ClientId, request: &[u8], _frames: usize, reply: &mut Vec<u8>) -> bool {
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
        match Request::decode(request, self.simulation.maze().size()) {
            Ok(Request::Walls(pose)) => judge.read_walls(pose),
            Ok(Request::Reset) => self.is_reset = true,
            Ok(Request::Annotations(list)) => {
                self.is_reset |= list.iter().any(|one| one == Annotation::Restart);
            }
            Ok(Request::State(state)) => {
                if !progress.add(state.pose(), mem::take(&mut self.is_reset)) {
                    return refuse(reply, OVER);
                }
            }
            Ok(_) => {}
            Err(error) => progress.fault = Some(format!("last refused request: {error}")),
        }
        drop(progress);
        self.simulation.handle(request, reply);
        true
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        refuse(reply, reason);
    }
}
