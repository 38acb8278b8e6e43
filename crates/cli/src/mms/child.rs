//! The mouse's process, and the pipes to it.

use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::process::{self, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use mmsim_mms::Response;

/// The longest line that is read, in bytes, with the end of it.
pub(crate) const MAX_LINE_BYTES: usize = 4096;

/// How much is kept of a longer one, in bytes.
const START_BYTES: usize = 40;

/// How many lines are read ahead.
const LINES_AHEAD: usize = 256;

/// How many replies may wait for a mouse that does not read them: some 10 MB.
const MAX_UNREAD: usize = 1 << 20;

/// A mouse in a process of its own, which is ended when this is dropped.
pub(crate) struct Child {
    process: process::Child,
    lines: Receiver<Line>,
    /// Where replies go; `None` once there are no more.
    replies: Option<Sender<Response>>,
    unread: Arc<AtomicUsize>,
    begun: Arc<Mutex<Vec<u8>>>,
}

/// What a mouse has written.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// A line, with the end of it.
    Whole(Vec<u8>),
    /// The first words of a line that is longer than any is read.
    TooLong(Vec<u8>),
    /// What there is of a line whose end never came.
    Unfinished(Vec<u8>),
}

/// What comes next from a mouse.
pub(crate) enum Next {
    Line(Line),
    /// Nothing yet.
    Silence,
    /// Nothing any more.
    End,
}

impl Child {
    /// Starts a program with its arguments. What it says on stderr is said on ours.
    pub(crate) fn start(command: &[OsString]) -> Result<Self, String> {
        let [program, arguments @ ..] = command else {
            return Err("expected a program after --, found nothing".into());
        };
        let mut mouse = Command::new(program);
        // So that it can be ended with all that it has started.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut mouse, 0);
        let pipes = mouse.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = pipes.spawn().map_err(|error| {
            let hint = match error.kind() {
                ErrorKind::NotFound => {
                    "; a program that is not in the PATH is named by its path, as in -- ./my-mouse"
                }
                _ => "",
            };
            format!("cannot start the mouse {}: {error}{hint}", program.display())
        })?;
        let (Some(stdin), Some(stdout)) = (process.stdin.take(), process.stdout.take()) else {
            return Err("expected pipes to the mouse, found none".into());
        };
        // So that a mouse may write before it reads, reading its commands and writing replies wait
        // for nobody but the mouse.
        let (read, lines) = mpsc::sync_channel(LINES_AHEAD);
        let begun = Arc::default();
        let stdout = Watched { pipe: stdout, begun: Arc::clone(&begun) };
        thread::spawn(move || read_lines(BufReader::new(stdout), &read));
        let (replies, to_write) = mpsc::channel();
        let unread = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&unread);
        thread::spawn(move || write_replies(stdin, &to_write, &counter));
        Ok(Self { process, lines, replies: Some(replies), unread, begun })
    }

    /// What the mouse writes next, if it does within this time.
    pub(crate) fn next(&self, patience: Duration) -> Next {
        match self.lines.recv_timeout(patience) {
            Ok(line) => Next::Line(line),
            Err(RecvTimeoutError::Timeout) => Next::Silence,
            Err(RecvTimeoutError::Disconnected) => Next::End,
        }
    }

    /// Replies to the mouse. If it does not listen any more, nothing comes of it.
    pub(crate) fn reply(&self, reply: Response) -> Result<(), String> {
        let unread = self.unread.fetch_add(1, Ordering::Relaxed);
        if unread >= MAX_UNREAD {
            return Err(format!("expected the mouse to read its replies, found {unread} unread"));
        }
        if let Some(replies) = &self.replies {
            let _ = replies.send(reply);
        }
        Ok(())
    }

    /// The beginning of the line that the mouse is writing; nothing between two lines.
    pub(crate) fn begun(&self) -> Vec<u8> {
        self.begun.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Tells the mouse that there will be no more replies.
    pub(crate) fn end_replies(&mut self) {
        self.replies = None;
    }

    /// How the mouse has ended, if it has.
    pub(crate) fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        self.process.try_wait()
    }
}

impl Drop for Child {
    /// Ends the mouse, and what it may have started.
    fn drop(&mut self) {
        #[cfg(unix)]
        if let Some(group) = rustix::process::Pid::from_raw(self.process.id().cast_signed()) {
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A pipe from the mouse that knows which line is not yet at its end.
struct Watched<R> {
    pipe: R,
    begun: Arc<Mutex<Vec<u8>>>,
}

impl<R: Read> Read for Watched<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.pipe.read(buffer)?;
        let read = buffer.get(..length).unwrap_or_default();
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let rest = match read.iter().rposition(|&byte| byte == b'\n') {
            Some(end) => {
                begun.clear();
                &read[end + 1..]
            }
            None => read,
        };
        let room = START_BYTES.saturating_sub(begun.len());
        begun.extend(&rest[..rest.len().min(room)]);
        Ok(length)
    }
}

fn read_lines(mut stdout: impl BufRead, lines: &SyncSender<Line>) {
    // A pipe that fails has nothing more to say.
    while let Ok(Some(line)) = read_line(&mut stdout) {
        if lines.send(line).is_err() {
            return;
        }
    }
}

/// The next line, `None` at the end. What a line is too long by is passed over.
fn read_line(stdout: &mut impl BufRead) -> io::Result<Option<Line>> {
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
    fn lines_end_somewhere() {
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
