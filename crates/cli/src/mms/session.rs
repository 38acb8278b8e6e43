//! The run of a mouse: reading its commands, answering them, and waiting for its exit.

use std::process::ExitStatus;
use std::sync::mpsc::RecvTimeoutError::{Disconnected, Timeout};
use std::time::Duration;

use mmsim_client::Transport;
use mmsim_mms::{Command, Response, ScoreRules, SimulatedMouse, excerpt};
use mmsim_viewer::{MouseControl, StopReason};

use super::child::{Child, Line};
use super::exit::{ExitCause, MouseExit};
use super::invalid_lines::{InvalidLine, InvalidLines};
use super::simulator::Simulator;
use crate::output::warn;

/// The interval between checks for Ctrl-C while the mouse computes.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The time after which a line that the mouse waits for is reported. Must be a multiple of
/// [`POLL_INTERVAL`].
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);

/// A running mouse.
pub(crate) struct Session<'a, T> {
    simulator: Simulator<'a, T>,
    /// True if the simulator is another process, which may not reply.
    is_remote: bool,
    control: &'a MouseControl,
    mouse: SimulatedMouse,
    limit: Option<u32>,
    lines: u64,
    crashes: u64,
    invalid_lines: InvalidLines,
}

impl<'a, T: Transport> Session<'a, T> {
    pub(crate) fn new(
        mouse: SimulatedMouse,
        simulator: Simulator<'a, T>,
        is_remote: bool,
        control: &'a MouseControl,
        limit: Option<u32>,
    ) -> Self {
        let invalid_lines = InvalidLines::default();
        Self { simulator, is_remote, control, mouse, limit, lines: 0, crashes: 0, invalid_lines }
    }

    /// Runs the mouse until it exits or is stopped.
    pub(crate) fn run(mut self, child: Result<Child, String>) -> MouseExit {
        let cause = match child {
            Ok(child) => self.serve(child),
            Err(error) => ExitCause::NotStarted(error),
        };
        let Self { mouse, crashes, invalid_lines, .. } = self;
        MouseExit { mouse, cause, crashes, refused: invalid_lines.total() }
    }

    fn serve(&mut self, mut child: Child) -> ExitCause {
        let cause = match self.serve_until_exit(&mut child) {
            Ok(status) => ExitCause::Exited(status),
            Err(cause @ ExitCause::LostSimulator(_)) => return cause,
            // After Ctrl-C, do not wait for a simulator that may not reply.
            Err(cause @ ExitCause::Stopped(StopReason::Exit)) if self.is_remote => return cause,
            Err(cause) => cause,
        };
        // Killing the mouse and its child processes ends the log.
        drop(child);
        self.simulator.end_log();
        // The mouse may have set markers or written to its log after the last state was sent.
        let sent = self.simulator.update(&self.mouse);
        if matches!(cause, ExitCause::Exited(_)) { sent.err().unwrap_or(cause) } else { cause }
    }

    fn serve_until_exit(&mut self, child: &mut Child) -> Result<ExitStatus, ExitCause> {
        self.simulator.update(&self.mouse)?;
        self.answer_all(child)?;
        child.end_replies();
        Ok(child.wait(self.control)?)
    }

    /// Answers the mouse's commands until its output ends. Between two movements, sends what the mouse
    /// displays.
    fn answer_all(&mut self, child: &mut Child) -> Result<(), ExitCause> {
        let mut silence = Duration::ZERO;
        loop {
            ExitCause::check(self.control)?;
            self.simulator.show_changes(&self.mouse)?;
            match child.next_line(POLL_INTERVAL) {
                Ok(line) => {
                    self.answer(&line, child)?;
                    silence = Duration::ZERO;
                }
                // A process that the mouse has started may keep the pipe open after the mouse
                // exits.
                Err(Timeout) if child.has_exited() => return Ok(()),
                Err(Timeout) => {
                    let incomplete = child.incomplete_line();
                    let may_wait = !incomplete.is_empty() || self.invalid_lines.has_withheld();
                    silence = if may_wait { silence + POLL_INTERVAL } else { Duration::ZERO };
                    if silence == SILENCE_TIMEOUT {
                        self.explain_silence(&incomplete);
                    }
                }
                Err(Disconnected) => return Ok(()),
            }
        }
    }

    /// Reports an incomplete or invalid line, because the mouse may be waiting for a reply to it.
    fn explain_silence(&mut self, incomplete: &[u8]) {
        if !incomplete.is_empty() {
            let (line, start) = (self.lines + 1, excerpt(incomplete));
            self.report(&format!("mms: line {line}: waiting for a newline after {start}"));
        } else if let Some(report) = self.invalid_lines.take_withheld() {
            self.report(&report);
        }
    }

    /// Prints a message about the mouse, which also appears in its log on the page.
    fn report(&self, message: &str) {
        warn(message);
        self.simulator.add_to_log(message);
    }

    fn answer(&mut self, line: &Line, child: &Child) -> Result<(), ExitCause> {
        self.lines += 1;
        if matches!(line, Line::Whole(line) if line.trim_ascii().is_empty()) {
            return Ok(());
        }
        if self.control.was_reset_pressed() {
            self.mouse.press_reset();
        }
        match InvalidLine::parse(line, self.mouse.map().size()) {
            Ok(command) => {
                self.invalid_lines.accept();
                let reply = self.execute(command)?;
                reply.map_or(Ok(()), |reply| child.reply(reply)).map_err(ExitCause::Failed)
            }
            Err(invalid_line) => {
                if let Some(message) = self.invalid_lines.add(self.lines, &invalid_line) {
                    self.report(&message);
                }
                Ok(())
            }
        }
    }

    fn execute(&mut self, command: Command<'_>) -> Result<Option<Response>, ExitCause> {
        let is_movement = matches!(command, Command::Forward { .. } | Command::Turn { .. });
        let reply = self.mouse.execute(command, &mut self.simulator)?;
        self.crashes += u64::from(reply == Some(Response::Crash));
        // The limit counts what the mouse does, so it does not depend on the rules for scores.
        let cost = self.mouse.scores_by(ScoreRules::Cells).total().cost();
        match self.limit {
            Some(limit) if is_movement && cost > limit.into() => Err(ExitCause::Limit(limit)),
            _ => Ok(reply),
        }
    }
}
