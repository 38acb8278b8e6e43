//! A mouse process and its pipes.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_mms::Response;
use mmsim_viewer::MouseControl;

use super::log::MouseLog;
use crate::mouse_process::{MouseProcess, Program, WaitError};

/// The maximum length of a line in bytes, including the newline.
pub(crate) const MAX_LINE_BYTES: usize = 4096;

/// The maximum length of an excerpt from a line, in bytes.
const START_BYTES: usize = 40;

/// The maximum number of lines that are queued for execution.
const MAX_LINES_AHEAD: usize = 256;

/// The maximum number of unread replies. This many take about 10 MB.
const MAX_UNREAD_REPLIES: usize = 1 << 20;

/// A mouse that reads replies from its stdin and writes commands to its stdout.
pub(crate) struct Child {
    process: MouseProcess,
    lines: Receiver<Line>,
    /// The channel to the thread that writes replies, or `None` after [`Self::end_replies`].
    replies: Option<Sender<Response>>,
    unread: Arc<AtomicUsize>,
    incomplete_line: Arc<Mutex<Vec<u8>>>,
}

/// A line of output from a mouse.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// A complete line, including the newline.
    Whole(Vec<u8>),
    /// The start of a line that exceeds the maximum length.
    TooLong(Vec<u8>),
    /// The last line of the output, if it does not end with a newline.
    Unfinished(Vec<u8>),
}

impl Child {
    /// Starts a mouse. With a log, copies the stderr of the mouse to the stderr of this process;
    /// otherwise the mouse inherits it.
    pub(crate) fn start(program: &Program, log: Option<&MouseLog>) -> Result<Self, String> {
        let mut command = program.command();
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        if log.is_some() {
            command.stderr(Stdio::piped());
        }
        let mut process = MouseProcess::start(&mut command)?;
        let pipes = &mut process.0;
        let (Some(stdin), Some(stdout)) = (pipes.stdin.take(), pipes.stdout.take()) else {
            return Err("cannot open the pipes of the mouse".into());
        };
        if let (Some(log), Some(stderr)) = (log, pipes.stderr.take()) {
            log.collect(stderr);
        }
        // Commands are read and replies are written on threads of their own, so a mouse may write
        // before it reads.
        let (read, lines) = mpsc::sync_channel(MAX_LINES_AHEAD);
        let incomplete_line = Arc::default();
        let stdout = LineTracker { pipe: stdout, incomplete_line: Arc::clone(&incomplete_line) };
        thread::spawn(move || read_lines(BufReader::new(stdout), &read));
        let (replies, to_write) = mpsc::channel();
        let unread = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&unread);
        thread::spawn(move || write_replies(stdin, &to_write, &counter));
        Ok(Self { process, lines, replies: Some(replies), unread, incomplete_line })
    }

    /// Waits for the next line from the mouse.
    pub(crate) fn next_line(&self, timeout: Duration) -> Result<Line, RecvTimeoutError> {
        self.lines.recv_timeout(timeout)
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

    /// Returns the start of the mouse's incomplete last line, or an empty vector if the last line
    /// is complete.
    pub(crate) fn incomplete_line(&self) -> Vec<u8> {
        self.incomplete_line.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Closes the mouse's stdin after all replies have been written.
    pub(crate) fn end_replies(&mut self) {
        self.replies = None;
    }

    /// Returns true if the mouse has exited.
    pub(crate) fn has_exited(&mut self) -> bool {
        self.process.status().is_ok_and(|status| status.is_some())
    }

    /// Waits until the mouse exits. Returns an error as soon as the mouse must stop.
    pub(crate) fn wait(&mut self, control: &MouseControl) -> Result<ExitStatus, WaitError> {
        self.process.wait(control)
    }
}

/// Reads the mouse's output and stores the start of an incomplete last line.
struct LineTracker<R> {
    pipe: R,
    incomplete_line: Arc<Mutex<Vec<u8>>>,
}

impl<R: Read> Read for LineTracker<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.pipe.read(buffer)?;
        let read = buffer.get(..length).unwrap_or_default();
        let mut incomplete = self.incomplete_line.lock().unwrap_or_else(PoisonError::into_inner);
        let rest = match read.iter().rposition(|&byte| byte == b'\n') {
            Some(end) => {
                incomplete.clear();
                &read[end + 1..]
            }
            None => read,
        };
        let room = START_BYTES.saturating_sub(incomplete.len());
        incomplete.extend(&rest[..rest.len().min(room)]);
        Ok(length)
    }
}

fn read_lines(mut stdout: impl BufRead, lines: &SyncSender<Line>) {
    // An error ends the output.
    while let Ok(Some(line)) = read_line(&mut stdout) {
        if lines.send(line).is_err() {
            return;
        }
    }
}

/// Reads the next line, or returns `None` at the end of output. Truncates overlong lines.
pub(crate) fn read_line(stdout: &mut impl BufRead) -> io::Result<Option<Line>> {
    let mut line = Vec::new();
    stdout.by_ref().take(MAX_LINE_BYTES as u64).read_until(b'\n', &mut line)?;
    if line.ends_with(b"\n") {
        return Ok(Some(Line::Whole(line)));
    }
    if line.len() < MAX_LINE_BYTES {
        return Ok((!line.is_empty()).then_some(Line::Unfinished(line)));
    }
    stdout.skip_until(b'\n')?;
    line.truncate(START_BYTES);
    Ok(Some(Line::TooLong(line)))
}

fn write_replies(mut stdin: ChildStdin, replies: &Receiver<Response>, unread: &AtomicUsize) {
    while let Ok(reply) = replies.recv() {
        if stdin.write_all(format!("{reply}\n").as_bytes()).is_err() {
            return;
        }
        unread.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlong_and_unfinished_lines_are_distinguished() {
        let long = vec![b'x'; 3 * MAX_LINE_BYTES];
        let longest = [&long[..MAX_LINE_BYTES - 1], b"\n"].concat();
        let text = [&b"one\n\ntwo\r\n"[..], &longest, &long, b"\nthree"].concat();
        let mut reader = BufReader::with_capacity(7, &text[..]);
        let mut next = || read_line(&mut reader).unwrap();
        for whole in [&b"one\n"[..], b"\n", b"two\r\n", &longest] {
            assert_eq!(next(), Some(Line::Whole(whole.to_vec())));
        }
        assert_eq!(next(), Some(Line::TooLong(long[..START_BYTES].to_vec())));
        assert_eq!(next(), Some(Line::Unfinished(b"three".to_vec())));
        assert_eq!(next(), None);
    }
}
