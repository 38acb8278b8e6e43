//! The pipes of a mouse that was written for mms.

use std::io::{self, BufReader, PipeWriter, Read, Write};
use std::process::Stdio;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex};

use mmsim_mms::Response;

use crate::commands::{Line, START_BYTES, read_lines};
use crate::lock;
use crate::log::MouseLog;
use crate::process::{MouseProcess, Program, spawn};

/// The maximum number of lines that are queued for execution.
const MAX_LINES_AHEAD: usize = 256;

/// The maximum number of unread replies. This many take about 10 MB.
const MAX_UNREAD_REPLIES: usize = 1 << 20;

/// A mouse that reads replies from its stdin and writes commands to its stdout. Both have threads of
/// their own, so a mouse may write before it reads.
pub(crate) struct Pipes {
    pub(crate) process: MouseProcess,
    pub(crate) lines: Receiver<Line>,
    /// The start of the incomplete last line, or no bytes if the last line is complete.
    pub(crate) incomplete_line: Arc<Mutex<Vec<u8>>>,
    pub(crate) replies: Option<Sender<Response>>,
    unread: Arc<AtomicUsize>,
}

impl Pipes {
    /// Starts a mouse. Without a log, the mouse inherits stderr.
    pub(crate) fn open(program: &Program, log: Option<&MouseLog>) -> Result<Self, String> {
        let stderr = if log.is_some() { Stdio::piped() } else { Stdio::inherit() };
        let (mut process, stdin, stdout) = MouseProcess::start_piped(program, None, stderr)?;
        if let (Some(log), Some(stderr)) = (log, process.take_stderr()) {
            log.collect(stderr)?;
        }
        let (read, lines) = mpsc::sync_channel(MAX_LINES_AHEAD);
        let incomplete_line = Arc::default();
        let stdout = LineTracker { pipe: stdout, incomplete_line: Arc::clone(&incomplete_line) };
        spawn("stdout", move || read_lines(BufReader::new(stdout), &read))?;
        let (replies, to_write) = mpsc::channel();
        let unread = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&unread);
        spawn("stdin", move || write_replies(stdin, &to_write, &counter))?;
        Ok(Self { process, lines, incomplete_line, replies: Some(replies), unread })
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

/// Reads the mouse's output and stores the start of an incomplete last line.
struct LineTracker<R> {
    pipe: R,
    incomplete_line: Arc<Mutex<Vec<u8>>>,
}

impl<R: Read> Read for LineTracker<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.pipe.read(buffer)?;
        let read = buffer.get(..length).unwrap_or_default();
        let mut incomplete = lock(&self.incomplete_line);
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
