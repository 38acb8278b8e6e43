//! The log of a mouse: the lines that it writes to stderr.

use std::fs::File;
use std::io::{self, Read, Write};
use std::mem;
#[cfg(unix)]
use std::os::fd::OwnedFd as Handle;
#[cfg(windows)]
use std::os::windows::io::OwnedHandle as Handle;
use std::process::ChildStderr;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use anstream::adapter::strip_str;
use mmsim_maze::{counted, needs_escape};
use mmsim_protocol::MAX_LOG_BYTES;

use crate::process::{cut, spawn};
use crate::{lock, wait_while};

/// The capacity of a pipe. One read of this size returns everything that a pipe contains.
const PIPE_BYTES: usize = 1 << 16;

/// The number of bytes of a line that are kept until its end is read.
const MAX_RAW_BYTES: usize = 4 * MAX_LOG_BYTES;

/// The maximum size of the lines that wait for the next state, in bytes. Further lines are counted.
const MAX_WAITING_BYTES: usize = 1 << 15;

/// The maximum time to wait for lines that the mouse has already written. They can be late only if
/// the stderr of this process is blocked.
const MAX_DELAY: Duration = Duration::from_secs(1);

/// The log of a mouse. A thread copies the stderr of the mouse to the stderr of this process and
/// collects the lines. The condition variable is notified after each read.
#[derive(Clone, Default)]
pub(crate) struct MouseLog(Arc<(Mutex<Lines>, Condvar)>);

impl MouseLog {
    /// Starts copying and collecting the stderr of a mouse.
    pub(crate) fn collect(&self, stderr: ChildStderr) -> Result<(), String> {
        let pipe = Arc::new(File::from(Handle::from(stderr)));
        self.lock().pipe = Some(Arc::clone(&pipe));
        let log = self.clone();
        spawn("stderr", move || log.copy(&pipe, &mut io::stderr()))
    }

    /// Adds a line of this process.
    pub(crate) fn add(&self, line: &str) {
        self.lock().add(clean(line.as_bytes()));
    }

    /// Takes all lines that the mouse has written so far.
    pub(crate) fn take(&self) -> Vec<String> {
        let lines = self.lock();
        let reads = lines.reads;
        let is_late = |lines: &mut Lines| lines.reads == reads && lines.is_behind();
        wait_while(&self.0.1, lines, MAX_DELAY, is_late).take()
    }

    /// Returns true if there are no lines to take.
    pub(crate) fn is_empty(&self) -> bool {
        let lines = self.lock();
        lines.complete.is_empty() && !lines.is_behind()
    }

    /// Waits until the stderr of the mouse is closed. If the mouse has started a process that keeps
    /// its stderr open, waits for a short time.
    pub(crate) fn wait_for_end(&self) {
        drop(wait_while(&self.0.1, self.lock(), MAX_DELAY, |lines| lines.pipe.is_some()));
    }

    fn copy(&self, pipe: &File, terminal: &mut impl Write) {
        let mut buffer = vec![0; PIPE_BYTES];
        while let Ok(length @ 1..) = self.read(pipe, &mut buffer) {
            self.0.1.notify_all();
            // Errors are ignored, as with all messages.
            let _ = terminal.write_all(&buffer[..length]).and_then(|()| terminal.flush());
        }
        self.lock().finish();
        self.0.1.notify_all();
    }

    /// Reads and splits the next part of the output. Holds the lock while it reads and splits, so no
    /// other thread sees bytes that have been read but not yet stored.
    #[cfg(unix)]
    fn read(&self, mut pipe: &File, buffer: &mut [u8]) -> io::Result<usize> {
        poll(pipe, None)?;
        let mut lines = self.lock();
        let length = pipe.read(buffer)?;
        lines.push(&buffer[..length]);
        Ok(length)
    }

    #[cfg(not(unix))]
    fn read(&self, mut pipe: &File, buffer: &mut [u8]) -> io::Result<usize> {
        let length = pipe.read(buffer)?;
        self.lock().push(&buffer[..length]);
        Ok(length)
    }

    fn lock(&self) -> MutexGuard<'_, Lines> {
        lock(&self.0.0)
    }
}

/// The stderr of a mouse, split into lines.
#[derive(Default)]
struct Lines {
    /// The pipe, or `None` at the end of the output.
    pipe: Option<Arc<File>>,
    /// The number of reads from the pipe.
    reads: u64,
    /// The start of a line whose end has not been read.
    partial: Vec<u8>,
    /// The lines that wait to be taken.
    complete: Vec<String>,
    complete_bytes: usize,
    /// The number of lines that were dropped because too many lines wait.
    omitted: u64,
}

impl Lines {
    /// Returns true if there is output that has not been read. Always false on Windows.
    fn is_behind(&self) -> bool {
        #[cfg(unix)]
        return self
            .pipe
            .as_ref()
            .is_some_and(|pipe| poll(pipe, Some(Duration::ZERO)).is_ok_and(|ready| ready));
        #[cfg(not(unix))]
        false
    }

    fn push(&mut self, output: &[u8]) {
        self.reads += 1;
        for piece in output.split_inclusive(|&byte| byte == b'\n') {
            let room = MAX_RAW_BYTES.saturating_sub(self.partial.len());
            self.partial.extend(&piece[..piece.len().min(room)]);
            if piece.ends_with(b"\n") {
                self.end_line();
            }
        }
    }

    fn end_line(&mut self) {
        let line = clean(&mem::take(&mut self.partial));
        self.add(line);
    }

    fn add(&mut self, line: String) {
        // An empty line needs memory too.
        let bytes = line.len() + 16;
        if self.complete_bytes + bytes > MAX_WAITING_BYTES {
            self.omitted += 1;
        } else {
            self.complete_bytes += bytes;
            self.complete.push(line);
        }
    }

    fn finish(&mut self) {
        if !self.partial.is_empty() {
            self.end_line();
        }
        self.pipe = None;
    }

    fn take(&mut self) -> Vec<String> {
        self.complete_bytes = 0;
        let mut lines = mem::take(&mut self.complete);
        let omitted = mem::take(&mut self.omitted);
        if omitted > 0 {
            lines.push(format!("({} omitted)", counted(omitted, "line")));
        }
        lines
    }
}

/// Returns a line as a terminal shows it: without its end, escape sequences, control characters
/// other than tabs, and text that a carriage return overwrites. Cuts a long line.
fn clean(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line.strip_suffix(b"\n").unwrap_or(line));
    let text = text.rsplit('\r').find(|part| !part.is_empty()).unwrap_or_default();
    let mut shown = strip_str(text).to_string();
    shown.retain(|c| c == '\t' || !needs_escape(c));
    if shown.len() > MAX_LOG_BYTES {
        cut(&mut shown, MAX_LOG_BYTES - '\u{2026}'.len_utf8());
        shown.push('\u{2026}');
    }
    shown
}

/// Waits until the pipe has output or ends. Returns false after a timeout.
#[cfg(unix)]
fn poll(pipe: &File, timeout: Option<Duration>) -> io::Result<bool> {
    use rustix::event::{PollFd, PollFlags, Timespec};

    let timeout = timeout.and_then(|timeout| Timespec::try_from(timeout).ok());
    loop {
        match rustix::event::poll(&mut [PollFd::new(pipe, PollFlags::IN)], timeout.as_ref()) {
            Ok(ready) => return Ok(ready > 0),
            Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_shown_as_on_a_terminal() {
        for (line, shown) in [
            (&b"at (3, 4)\n"[..], "at (3, 4)"),
            (b"crlf\r\n", "crlf"),
            (b"10%\r50%\r\n", "50%"),
            (b"\x1b[1;31mred\x1b[0m\ttab\x07\x08", "red\ttab"),
            (b"\x1b]0;title\x07a\x1b]0;title\x1b\\b\x1b(Bc\x1b=d", "abcd"),
            (b"\xffcaf\xc3\xa9 \xe2\x80\xaeright", "\u{fffd}caf\u{e9} right"),
            (b"unfinished \x1b[", "unfinished "),
            (b"\x1b", ""),
            (b"", ""),
        ] {
            assert_eq!(clean(line), shown, "{line:?}");
        }
        assert_eq!(clean(&[b'x'; 1000]), "x".repeat(1000));
        assert_eq!(clean(&[b'x'; 1001]), "x".repeat(997) + "\u{2026}");
        assert_eq!(clean("\u{e9}".repeat(600).as_bytes()), "\u{e9}".repeat(498) + "\u{2026}");
    }

    #[test]
    fn output_is_split_into_lines() {
        let mut lines = Lines::default();
        lines.push(b"one\n\ntw");
        assert_eq!(lines.take(), ["one", ""]);
        lines.push(b"o\n");
        lines.push(b"three");
        assert_eq!(lines.take(), ["two"]);
        lines.push(&b"x".repeat(1 << 20));
        assert_eq!(lines.partial.len(), MAX_RAW_BYTES);
        lines.finish();
        let last = lines.take();
        assert_eq!((last.len(), last[0].len()), (1, MAX_LOG_BYTES));
        assert!(last[0].starts_with("threexx"));
    }

    #[test]
    fn lines_beyond_the_limit_are_counted() {
        let mut lines = Lines::default();
        lines.push(&b"\n".repeat(5000));
        let taken = lines.take();
        assert_eq!((taken.len(), taken[2048].as_str()), (2049, "(2952 lines omitted)"));
        lines.push(b"again\n");
        assert_eq!(lines.take(), ["again"]);
    }

    #[cfg(unix)]
    #[test]
    fn lines_that_were_written_are_taken() {
        let log = MouseLog::default();
        let script = "for i in 1 2 3; do echo $i >&2; echo; read reply; done; printf end >&2";
        let mut mouse = std::process::Command::new("sh")
            .args(["-c", script])
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        log.collect(mouse.stderr.take().unwrap()).unwrap();
        let (mut stdin, mut stdout) = (mouse.stdin.take().unwrap(), mouse.stdout.take().unwrap());
        for expected in ["1", "2", "3"] {
            stdout.read_exact(&mut [0]).unwrap();
            assert!(!log.is_empty());
            assert_eq!(log.take(), [expected]);
            assert!(log.is_empty());
            stdin.write_all(b"\n").unwrap();
        }
        log.wait_for_end();
        assert_eq!(log.take(), ["end"]);
        assert!(mouse.wait().unwrap().success());
    }
}
