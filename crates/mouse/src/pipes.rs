//! A running mouse whose stdin, stdout and stderr are pipes.

use std::io::{BufReader, PipeWriter, Write};
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::RecvTimeoutError::{Disconnected, Timeout};
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{Duration, Instant};

use mmsim_maze::MazeSize;
use mmsim_mms::Response;

use crate::ENDPOINT_VARIABLE;
use crate::commands::Line;
use crate::control::MouseControl;
use crate::kind::{LineTracker, MouseKind, Output, distribute};
use crate::log::MouseLog;
use crate::process::{CHECK_INTERVAL, ExitCause, MouseProcess, spawn};
use crate::program::Program;

/// The maximum number of lines that are queued for execution.
const MAX_LINES_AHEAD: usize = 256;

/// The maximum number of unread replies. This many take about 10 MB.
const MAX_UNREAD_REPLIES: usize = 1 << 20;

/// The time after which a mouse that has not been recognized is reported.
const RECOGNITION_TIMEOUT: Duration = Duration::from_secs(3);

/// The maximum time to wait for the last output of a mouse that has exited.
const OUTPUT_TIMEOUT: Duration = Duration::from_secs(1);

/// A running mouse that writes to pipes and reads replies from another one. The pipes have threads of
/// their own, so a mouse may write before it reads.
pub struct PipedMouse {
    pub(crate) process: MouseProcess,
    /// The lines of a mouse for mms. The output of any other mouse is copied to stdout.
    pub(crate) lines: Receiver<Line>,
    /// The first of these lines, if it has been received.
    pub(crate) first_line: Option<Line>,
    pub(crate) output: Arc<Output>,
    pub(crate) replies: Option<Sender<Response>>,
    pub(crate) log: Option<MouseLog>,
    unread: Arc<AtomicUsize>,
}

impl PipedMouse {
    /// Starts a mouse in a maze of this size. Its environment contains the address of a simulator, if
    /// there is an `endpoint`. If `has_log` is true, the stderr of the mouse is collected and copied.
    /// `copy` receives the output of a mouse that is not one for mms.
    ///
    /// # Errors
    /// Returns the reason if the mouse cannot start.
    pub fn start(
        program: &Program,
        endpoint: Option<&str>,
        size: MazeSize,
        has_log: bool,
        control: &Arc<MouseControl>,
        copy: impl Write + Send + 'static,
    ) -> Result<Self, String> {
        let log = has_log.then(MouseLog::default);
        let stderr = if has_log { Stdio::piped() } else { Stdio::inherit() };
        let (mut process, stdin, stdout) = MouseProcess::start_piped(program, endpoint, stderr)?;
        if let (Some(log), Some(stderr)) = (&log, process.take_stderr()) {
            log.collect(stderr)?;
        }
        let (read, lines) = mpsc::sync_channel(MAX_LINES_AHEAD);
        let output = Arc::new(Output::new(copy));
        let stdout = LineTracker { pipe: stdout, output: Arc::clone(&output) };
        let (noted, control, run) = (Arc::clone(&output), Arc::clone(control), control.runs());
        spawn("stdout", move || {
            let recognize = |shown| control.recognize(run, shown);
            distribute(BufReader::new(stdout), size, recognize, &noted, &read);
        })?;
        let (replies, to_write) = mpsc::channel();
        let unread = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&unread);
        spawn("stdin", move || write_replies(stdin, &to_write, &counter))?;
        let replies = Some(replies);
        Ok(Self { process, lines, first_line: None, output, replies, log, unread })
    }

    /// Waits until the mouse is recognized or has exited. Returns `None` if it was not recognized.
    /// `report` is called if this takes long.
    ///
    /// # Errors
    /// Returns an error if the mouse must stop.
    pub fn recognize(
        &mut self,
        control: &MouseControl,
        report: impl Fn(&str),
    ) -> Result<Option<MouseKind>, ExitCause> {
        let (started, run, mut is_reported) = (Instant::now(), control.runs(), false);
        loop {
            ExitCause::check(control)?;
            let kind = control.recognize(run, None);
            if kind == Some(MouseKind::Client) {
                self.release()?;
                return Ok(kind);
            }
            // Before the lines, so that no line of a mouse that has exited is missed.
            let has_exited = !matches!(self.process.status(), Ok(None));
            if has_exited {
                self.process.kill_group();
            }
            let timeout = if has_exited { OUTPUT_TIMEOUT } else { CHECK_INTERVAL };
            match self.lines.recv_timeout(timeout) {
                Ok(line) => {
                    self.first_line = Some(line);
                    return Ok(Some(MouseKind::Mms));
                }
                Err(_) if has_exited => return Ok(control.recognize(run, None)),
                // The mouse has closed its output, and may still be a client.
                Err(Disconnected) => drop(control.wait_for_stop(CHECK_INTERVAL)),
                Err(Timeout) => {}
            }
            if !is_reported && kind.is_none() && started.elapsed() >= RECOGNITION_TIMEOUT {
                let said = self.output.explain();
                report(&format!(
                    "no command of mms and no request after {} s{said} (a mouse for mms writes \
                     commands to stdout, a client connects to {ENDPOINT_VARIABLE}, a robot needs \
                     --as robot)",
                    RECOGNITION_TIMEOUT.as_secs()
                ));
                is_reported = true;
                self.release()?;
            }
        }
    }

    /// Copies the output that was held back, on another thread, because nobody may be reading it.
    fn release(&self) -> Result<(), ExitCause> {
        let output = Arc::clone(&self.output);
        spawn("output", move || output.release()).map_err(ExitCause::Failed)
    }

    /// Waits until a mouse that reads nothing exits or must stop, and until its output is copied.
    pub fn wait(mut self, control: &MouseControl) -> ExitCause {
        self.replies = None;
        let cause = self.process.wait(control);
        // Killing the mouse and its child processes ends their output.
        drop(self.process);
        let mut until = Instant::now() + OUTPUT_TIMEOUT;
        loop {
            match self.lines.recv_timeout(CHECK_INTERVAL) {
                // A line that shows too late that the mouse is one for mms is ignored.
                Ok(_) => {}
                Err(Disconnected) => break,
                Err(Timeout) => {
                    // A mouse that must stop does not wait for a reader.
                    let must_stop = control.wait_for_stop(Duration::ZERO).is_some();
                    if self.output.is_copying() && !must_stop {
                        until = Instant::now() + OUTPUT_TIMEOUT;
                    }
                    if Instant::now() >= until {
                        break;
                    }
                }
            }
        }
        self.log.iter().for_each(MouseLog::wait_for_end);
        cause
    }

    /// Sends a reply to the mouse. Does nothing if the mouse has closed its stdin.
    pub(crate) fn reply(&self, reply: Response) -> Result<(), String> {
        let unread = self.unread.fetch_add(1, Ordering::Relaxed);
        if unread >= MAX_UNREAD_REPLIES {
            return Err(format!("the mouse is not reading its replies ({unread} unread)"));
        }
        if let Some(replies) = &self.replies {
            let _ = replies.send(reply);
        }
        Ok(())
    }
}

fn write_replies(mut stdin: PipeWriter, replies: &Receiver<Response>, unread: &AtomicUsize) {
    while let Ok(reply) = replies.recv() {
        if stdin.write_all(format!("{reply}\n").as_bytes()).is_err() {
            return;
        }
        unread.fetch_sub(1, Ordering::Relaxed);
    }
}
