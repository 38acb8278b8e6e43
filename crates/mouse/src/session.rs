//! The run of a mouse that was written for mms: its pipes, its commands, the replies to them, and its
//! scores.

use std::fmt::{Arguments, Write as _};
use std::sync::mpsc::RecvTimeoutError::{Disconnected, Timeout};
use std::time::Duration;

use mmsim_client::{RunError, Transport};
use mmsim_fastrun::{FastRun, Vehicle};
use mmsim_maze::{KnownMaze, WallSensor, counted};
use mmsim_mms::{GeneralFormat, Response, ScoreRules, SimulatedMouse, Stat, excerpt};
use mmsim_protocol::MAX_LOG_BYTES;
use mmsim_run::{DRIVEN_RUN, EndFacts, Judge, Messages, Phases};

use crate::commands::{CommandSource, InvalidLine, InvalidLines, Line, execute_all};
use crate::control::{MouseControl, StopReason};
use crate::kind::MouseKind;
use crate::pipes::PipedMouse;
use crate::process::{CHECK_INTERVAL, ExitCause, RunEnd};
use crate::report::MouseReport;
use crate::simulator::Simulator;

/// The time after which a line that the mouse waits for is reported. Must be a multiple of
/// [`CHECK_INTERVAL`].
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);

/// A run of a mouse that was written for mms, as a client of a simulator.
#[derive(Debug)]
pub struct Session<'a> {
    /// The name of the mouse.
    pub name: &'a str,
    /// The maze, of which only the size, the start and the goal are known.
    pub maze: &'a KnownMaze,
    /// The sensor of a mouse that misreads walls.
    pub sensor: Option<&'a WallSensor>,
    /// The rules for the scores.
    pub rules: ScoreRules,
    /// The mouse is stopped when its number of turns plus its distance in cells exceeds this limit.
    pub limit: Option<u32>,
    /// The vehicle that drives the fast runs of the mouse.
    pub vehicle: &'a Vehicle,
    /// True if the simulator accepts annotations.
    pub has_annotations: bool,
    /// True if the simulator is another process, which may not reply.
    pub is_remote: bool,
    /// The control of the mouse.
    pub control: &'a MouseControl,
    /// Called with warnings about the lines of the mouse.
    pub warn: fn(Arguments<'_>),
}

impl Session<'_> {
    /// Runs a mouse that was started, or reports that it could not be started, until it exits or is
    /// stopped. If the simulator accepts annotations, the stderr of the mouse is sent as its log.
    ///
    /// # Errors
    /// Returns an error if the simulator does not accept a reset.
    pub fn run(
        &self,
        transport: impl Transport,
        started: Result<PipedMouse, String>,
    ) -> Result<MouseExit, RunError> {
        let Self { name, maze, control, .. } = *self;
        let log = started.as_ref().ok().and_then(|mouse| mouse.log.clone());
        let annotator = log.filter(|_| self.has_annotations).map(|log| (name, log));
        let mut simulator =
            Simulator::new(transport, maze, control, annotator, self.sensor.cloned())?;
        let mut mouse = SimulatedMouse::new(maze.size(), maze.start().cell, *maze.goals())
            .with_score_rules(self.rules);
        let (cause, counts) = match started {
            Ok(pipes) => self.execute(&mut mouse, &mut simulator, pipes),
            Err(error) => (ExitCause::NotStarted(error), Counts::default()),
        };
        Ok(MouseExit { mouse, cause, counts, phases: simulator.phases, judge: None })
    }

    /// Executes the commands of the mouse until it exits. Also returns what was counted.
    fn execute(
        &self,
        mouse: &mut SimulatedMouse,
        simulator: &mut Simulator<'_, impl Transport>,
        pipes: PipedMouse,
    ) -> (ExitCause, Counts) {
        let lines = pipes.output.copied_lines();
        let (counts, invalid_lines) = (Counts::default(), InvalidLines::default());
        let mut commands = SessionCommands {
            session: self,
            simulator,
            pipes,
            lines,
            counts,
            latest_run: None,
            invalid_lines,
        };
        let executed = match commands.simulator.update(mouse) {
            Ok(()) => execute_all(mouse, &mut commands),
            Err(cause) => Err(cause),
        };
        let SessionCommands { simulator, mut pipes, counts, invalid_lines, .. } = commands;
        let mut cause = match executed {
            Ok(()) => {
                // Closes the stdin of the mouse after all replies have been written.
                pipes.replies = None;
                pipes.process.wait(self.control)
            }
            Err(cause) => cause,
        };
        // Killing the mouse and its child processes ends the log.
        drop(pipes);
        // After Ctrl-C, do not wait for a simulator that may not reply.
        let is_gone = matches!(cause, ExitCause::LostSimulator(_))
            || self.is_remote && matches!(cause, ExitCause::Stopped(StopReason::Exit));
        if !is_gone {
            simulator.end_log();
            // The mouse may have set markers or written to its log after the last state was sent.
            let sent = simulator.update(mouse);
            if let (ExitCause::Exited(_), Err(error)) = (&cause, sent) {
                cause = error;
            }
        }
        (cause, Counts { refused: invalid_lines.total(), ..counts })
    }
}

/// The commands of a running mouse, which change its simulator.
struct SessionCommands<'a, 's, T> {
    session: &'a Session<'a>,
    simulator: &'a mut Simulator<'s, T>,
    pipes: PipedMouse,
    lines: u64,
    counts: Counts,
    /// The latest fast run of the mouse.
    latest_run: Option<FastRun>,
    invalid_lines: InvalidLines,
}

/// What is counted while a mouse runs.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// The number of movements that ended in a crash.
    crashes: u64,
    /// The number of these since the last pose.
    blocked: u32,
    /// The number of states at the last crash.
    states: u32,
    /// The number of valid commands.
    commands: u64,
    /// The number of invalid commands.
    refused: u64,
    /// True if the last line was invalid.
    is_refused: bool,
    /// The fast run that takes the least time, and this time in s.
    fastest_run: Option<(FastRun, f64)>,
}

impl<T: Transport> SessionCommands<'_, '_, T> {
    /// Reports an incomplete or invalid line, because the mouse may be waiting for a reply to it.
    fn explain_silence(&mut self, incomplete: &[u8]) {
        if !incomplete.is_empty() {
            let (line, start) = (self.lines + 1, excerpt(incomplete));
            self.report(&format!("mms: line {line}: waiting for a newline after {start}"));
        } else if let Some(report) = self.invalid_lines.take_withheld() {
            self.report(&report);
        }
    }

    /// Logs a fast run that the mouse has just completed, and reports its time.
    fn note_fast_run(&mut self, run: &FastRun) {
        let vehicle = self.session.vehicle;
        let line = format!("{DRIVEN_RUN}{run}");
        if line.len() <= MAX_LOG_BYTES {
            self.simulator.add_to_log(&line);
        } else {
            let turns = run.turns().len();
            self.report(&format!("mms: the page cannot play the fast run of {turns} turns"));
        }
        let timed = run.with_fastest_speeds(vehicle).and_then(|run| {
            let time = run.time(vehicle)?;
            Ok((run, time))
        });
        match timed {
            Ok((run, time)) => {
                self.report(&format!("mms: fast run in {time:.4} s with {}", vehicle.name()));
                if self.counts.fastest_run.as_ref().is_none_or(|&(_, least)| time < least) {
                    self.counts.fastest_run = Some((run, time));
                }
            }
            Err(error) => self.report(&format!("mms: fast run without a time: {error}")),
        }
    }

    /// Reports a message about the mouse, which also appears in its log on the page.
    fn report(&self, message: &str) {
        (self.session.warn)(format_args!("{message}"));
        self.simulator.add_to_log(message);
    }
}

impl<'s, T: Transport> CommandSource<Simulator<'s, T>> for SessionCommands<'_, 's, T> {
    fn environment(&mut self) -> &mut Simulator<'s, T> {
        self.simulator
    }

    /// Waits for a line. Until then, sends what the mouse displays between two movements.
    fn next_line(&mut self, mouse: &SimulatedMouse) -> Result<Option<Line>, ExitCause> {
        let mut silence = Duration::ZERO;
        loop {
            ExitCause::check(self.session.control)?;
            self.simulator.show_changes(mouse)?;
            let line = match self.pipes.first_line.take() {
                Some(line) => Ok(line),
                None => self.pipes.lines.recv_timeout(CHECK_INTERVAL),
            };
            match line {
                Ok(line) => {
                    self.lines += 1;
                    return Ok(Some(line));
                }
                Err(Disconnected) => return Ok(None),
                // A process that the mouse has started may keep the pipe open after the mouse
                // exits.
                Err(Timeout) if !matches!(self.pipes.process.status(), Ok(None)) => {
                    return Ok(None);
                }
                Err(Timeout) => {
                    let incomplete = self.pipes.output.incomplete_line();
                    let may_wait = !incomplete.is_empty() || self.invalid_lines.has_withheld();
                    silence = if may_wait { silence + CHECK_INTERVAL } else { Duration::ZERO };
                    if silence == SILENCE_TIMEOUT {
                        self.explain_silence(&incomplete);
                    }
                }
            }
        }
    }

    fn accept(&mut self, mouse: &mut SimulatedMouse) -> bool {
        if self.session.control.was_reset_pressed() {
            mouse.press_reset();
        }
        self.counts.commands += 1;
        self.counts.is_refused = false;
        self.invalid_lines.accept();
        true
    }

    fn refuse(&mut self, line: &InvalidLine<'_>) {
        self.counts.is_refused = true;
        if let Some(message) = self.invalid_lines.add(self.lines, line) {
            self.report(&message);
        }
    }

    fn reply(&mut self, mouse: &SimulatedMouse, reply: Response) -> Result<(), ExitCause> {
        if reply == Response::Crash {
            let (states, counts) = (self.simulator.phases.states, &mut self.counts);
            counts.crashes += 1;
            counts.blocked = if counts.states == states { counts.blocked } else { 0 } + 1;
            counts.states = states;
        }
        if mouse.fast_run() != self.latest_run.as_ref() {
            self.latest_run = mouse.fast_run().cloned();
            // A run without slalom turns is no news.
            if let Some(run) = self.latest_run.clone().filter(|run| !run.turns().is_empty()) {
                self.note_fast_run(&run);
            }
        }
        self.session.control.note_progress(&self.simulator.phases);
        // The limit counts what the mouse does, so it does not depend on the rules for scores.
        let cost = mouse.scores_by(ScoreRules::Cells).total().cost();
        match self.session.limit {
            Some(limit) if cost > limit.into() => Err(ExitCause::Limit(limit)),
            _ => self.pipes.reply(reply).map_err(ExitCause::Failed),
        }
    }
}

/// A mouse that is not running.
#[derive(Debug)]
pub struct MouseExit {
    pub(crate) mouse: SimulatedMouse,
    /// The reason why it is not running.
    pub cause: ExitCause,
    pub(crate) counts: Counts,
    /// What the mouse did.
    pub(crate) phases: Phases,
    /// The judge of its states, if it is known.
    pub judge: Option<Judge>,
}

impl MouseExit {
    /// Returns what the mouse did.
    pub const fn phases(&self) -> &Phases {
        &self.phases
    }

    /// Returns how the run ended.
    pub fn facts(&self) -> EndFacts {
        let Counts { commands, blocked, states, is_refused, .. } = self.counts;
        let messages = (commands > 0).then_some(Messages::Commands(commands));
        let blocked = if states == self.phases.states { blocked } else { 0 };
        self.cause.add_to(EndFacts { messages, is_refused, blocked, ..EndFacts::default() })
    }

    /// Returns the outcome for the viewer page and the exit code.
    pub fn end(&self) -> RunEnd {
        let count = |count, noun| match count {
            0 => String::new(),
            count => format!("; {}", counted(count, noun)),
        };
        let crashes = count(self.counts.crashes, "crashed movement");
        let invalid = count(self.counts.refused, "invalid line");
        let score = GeneralFormat(self.mouse.scores().score());
        let details = format!(", score {score}{crashes}{invalid}");
        self.cause.end(&self.phases, &details, self.judge.as_ref(), &self.facts())
    }

    /// Returns the scores that mms competitions use, one per line.
    pub fn scores(&self) -> String {
        let scores = self.mouse.scores();
        Stat::COMPETITION.iter().fold(String::new(), |mut text, &stat| {
            let value = scores.stat(stat);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{stat}: {value}");
            text
        })
    }

    /// Returns the report on the run. `maze` is the name of the maze, if it is known.
    pub fn report<'m>(&self, maze: Option<&'m str>, mouse: &'m str) -> MouseReport<'m> {
        let Counts { crashes, refused, fastest_run, .. } = &self.counts;
        let counts = (self.phases.states, *crashes, *refused);
        let report =
            MouseReport::new(maze, mouse, Some(MouseKind::Mms), &self.end(), &self.cause, counts);
        report.with_scores(&self.mouse, fastest_run.as_ref())
    }
}
