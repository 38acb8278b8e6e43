//! Recognizes how a mouse communicates: by commands of mms on its stdout, or by requests over `ZeroMQ`.

use std::io::{self, BufRead, Read, Write};
use std::mem;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, TryLockError};

use mmsim_maze::MazeSize;
use mmsim_mms::{Command, excerpt};
use serde::Serialize;

use crate::commands::{Line, MAX_LINE_BYTES, START_BYTES, read_lines};
use crate::lock;

/// How a mouse communicates. The names are JSON values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MouseKind {
    /// It writes the commands of mms to its stdout.
    Mms,
    /// It sends requests over ZeroMQ.
    Client,
}

impl MouseKind {
    /// Returns true if a message of this kind comes from a mouse of this kind. The first message
    /// decides.
    pub(crate) fn accept(self, recognized: &mut Option<Self>) -> bool {
        *recognized.get_or_insert(self) == self
    }
}

/// The maximum size of the output that is held back, in bytes.
const MAX_HELD_BYTES: usize = 1 << 16;

/// The output of a mouse that has not been recognized. It is held back: it belongs either to the commands
/// of a mouse for mms, or on the stdout of this process.
pub(crate) struct Output {
    copy: Mutex<Box<dyn Write + Send>>,
    heard: Mutex<Heard>,
}

/// What a mouse has written.
#[derive(Debug, Default)]
struct Heard {
    held: Vec<u8>,
    /// True if output is copied at once.
    is_released: bool,
    /// The number of lines that were copied.
    lines: u64,
    /// The start of the latest complete line that is not blank, or no bytes.
    latest_line: Vec<u8>,
    /// The start of the incomplete last line, or no bytes.
    incomplete_line: Vec<u8>,
}

impl Output {
    /// Returns an empty output, which is copied to `copy` once it is known not to be commands.
    pub(crate) fn new(copy: impl Write + Send + 'static) -> Self {
        Self { copy: Mutex::new(Box::new(copy)), heard: Mutex::default() }
    }

    /// Copies what was held back. May wait for the reader of the copy.
    pub(crate) fn release(&self) {
        let mut copy = lock(&self.copy);
        let held = {
            let mut heard = lock(&self.heard);
            heard.is_released = true;
            let held = mem::take(&mut heard.held);
            heard.lines += held.iter().map(|&byte| u64::from(byte == b'\n')).sum::<u64>();
            held
        };
        // The mouse must not wait because its output cannot be copied.
        let _ = copy.write_all(&held).and_then(|()| copy.flush());
    }

    /// Adds the next part of a line.
    fn add(&self, part: &[u8]) {
        let mut heard = lock(&self.heard);
        heard.held.extend(part);
        if heard.is_released || heard.held.len() > MAX_HELD_BYTES {
            drop(heard);
            self.release();
        }
    }

    /// Notes a complete line that is not a command.
    fn note(&self, line: &[u8]) {
        let text = line.trim_ascii();
        if !text.is_empty() {
            lock(&self.heard).latest_line = text[..text.len().min(START_BYTES)].into();
        }
    }

    /// Returns true while the reader of the copy keeps this process waiting.
    pub(crate) fn is_copying(&self) -> bool {
        matches!(self.copy.try_lock(), Err(TryLockError::WouldBlock))
    }

    /// Returns the number of lines that were copied.
    pub(crate) fn copied_lines(&self) -> u64 {
        lock(&self.heard).lines
    }

    /// Returns the start of the incomplete last line, or no bytes.
    pub(crate) fn incomplete_line(&self) -> Vec<u8> {
        lock(&self.heard).incomplete_line.clone()
    }

    /// Returns what the mouse may be waiting for, if it has written something.
    pub(crate) fn explain(&self) -> String {
        let heard = lock(&self.heard);
        match (&heard.incomplete_line[..], &heard.latest_line[..]) {
            ([], []) => String::new(),
            ([], line) => format!("; its last line {} is not a command of mms", excerpt(line)),
            (start, _) => format!("; waiting for a newline after {}", excerpt(start)),
        }
    }
}

/// Reads the output of a mouse until it ends. Sends the lines of a mouse for mms to `lines`, and copies
/// any other output. `recognize` decides, with the kind that a line shows, if any, whether the mouse
/// has been recognized.
pub(crate) fn distribute(
    mut stdout: impl BufRead,
    size: MazeSize,
    recognize: impl Fn(Option<MouseKind>) -> Option<MouseKind>,
    output: &Output,
    lines: &SyncSender<Line>,
) {
    // The current line, up to a maximum length.
    let mut line = Vec::new();
    loop {
        let kind = recognize(None);
        if kind == Some(MouseKind::Mms) {
            break;
        }
        if kind == Some(MouseKind::Client) {
            output.release();
        }
        // An error ends the output.
        let Ok(bytes @ [_, ..]) = stdout.fill_buf() else { return output.release() };
        let end = bytes.iter().position(|&byte| byte == b'\n').filter(|_| kind.is_none());
        let length = end.map_or(bytes.len(), |end| end + 1);
        let part = &bytes[..length];
        line.extend(&part[..length.min(MAX_LINE_BYTES + 1 - line.len())]);
        output.add(part);
        stdout.consume(length);
        if end.is_some() {
            let is_command = line.len() <= MAX_LINE_BYTES && Command::parse(&line, size).is_ok();
            if recognize(is_command.then_some(MouseKind::Mms)) == Some(MouseKind::Mms) {
                break;
            }
            output.note(&line);
            line.clear();
        }
    }
    let held = mem::take(&mut lock(&output.heard).held);
    // A line that was copied is still a command.
    let start = if held.is_empty() { line } else { held };
    read_lines(start.chain(stdout), lines);
}

/// Reads the output of a mouse and stores the start of an incomplete last line.
pub(crate) struct LineTracker<R> {
    pub(crate) pipe: R,
    pub(crate) output: Arc<Output>,
}

impl<R: Read> Read for LineTracker<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.pipe.read(buffer)?;
        let read = buffer.get(..length).unwrap_or_default();
        let incomplete = &mut lock(&self.output.heard).incomplete_line;
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io::BufReader;
    use std::sync::mpsc;

    use super::*;

    /// A writer whose bytes can be read by other threads.
    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            lock(&self.0).write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// A pipe whose reads call a function.
    struct Reads<R>(R);

    impl<R: FnMut(&mut [u8]) -> io::Result<usize>> Read for Reads<R> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            (self.0)(buffer)
        }
    }

    /// Returns the lines of a mouse, what is copied, and the output.
    fn distributed(stdout: &[u8], kind: Option<MouseKind>) -> (Vec<Line>, String, Output) {
        let (kind, copy) = (Mutex::new(kind), Shared::default());
        let output = Output::new(copy.clone());
        let recognize = |shown: Option<MouseKind>| {
            let mut kind = lock(&kind);
            shown.map(|shown| shown.accept(&mut kind));
            *kind
        };
        let (send, lines) = mpsc::sync_channel(100);
        distribute(stdout, MazeSize::CLASSIC, recognize, &output, &send);
        drop(send);
        let copied = String::from_utf8(lock(&copy.0).clone()).unwrap();
        (lines.iter().collect(), copied, output)
    }

    #[test]
    fn the_first_command_decides() {
        let whole = |line: &str| Line::Whole(line.into());
        let (lines, copied, _) = distributed(b"hello\n\nmazeWidth\nhello\n", None);
        let expected = ["hello\n", "\n", "mazeWidth\n", "hello\n"].map(whole);
        assert!(lines == expected && copied.is_empty(), "{lines:?} {copied}");
        let (lines, copied, _) = distributed(b"mazeWidth\nhello", Some(MouseKind::Client));
        assert_eq!((lines.len(), copied.as_str()), (0, "mazeWidth\nhello"));
        let (lines, copied, output) = distributed(b"hello\nhello", None);
        assert_eq!((lines.len(), copied.as_str()), (0, "hello\nhello"));
        assert_eq!(output.copied_lines(), 1);
    }

    #[test]
    fn an_unfinished_line_and_a_long_line_are_no_commands() {
        for text in ["mazeWidth".into(), "mazeWidth ".repeat(MAX_LINE_BYTES) + "\n"] {
            let (lines, copied, _) = distributed(text.as_bytes(), None);
            assert_eq!((lines.len(), copied), (0, text));
        }
        let talk = "hello\n".repeat(1 + MAX_HELD_BYTES / 6);
        let (lines, copied, output) = distributed((talk.clone() + "turnLeft\n").as_bytes(), None);
        assert_eq!(lines, [Line::Whole(b"turnLeft\n".into())], "the rest was too long to be held");
        assert!(copied == talk + "turnLeft\n" && output.copied_lines() > 10_000);
    }

    #[test]
    fn the_output_of_a_client_is_copied_at_once() {
        let (copy, calls) = (Shared::default(), Cell::new(0));
        let (output, mut copied) = (Output::new(copy.clone()), Vec::new());
        let mut parts = [&b"Searching"[..], b".", b"."].into_iter();
        let read = |buffer: &mut [u8]| {
            copied.push(lock(&copy.0).len());
            let part = parts.next().unwrap_or_default();
            buffer[..part.len()].copy_from_slice(part);
            Ok(part.len())
        };
        let stdout = BufReader::new(Reads(read));
        // A request arrives after the first part.
        let recognize = |_| (calls.replace(calls.get() + 1) > 0).then_some(MouseKind::Client);
        distribute(stdout, MazeSize::CLASSIC, recognize, &output, &mpsc::sync_channel(1).0);
        assert_eq!(copied, [0, 9, 10, 11]);
    }

    #[test]
    fn what_the_mouse_may_wait_for_is_explained() {
        let (_, _, output) = distributed(b"moveforward\n\n", None);
        assert_eq!(output.explain(), r#"; its last line "moveforward" is not a command of mms"#);
        let output = Arc::new(output);
        let mut tracker = LineTracker { pipe: &b"mazeW"[..], output: Arc::clone(&output) };
        io::copy(&mut tracker, &mut io::sink()).unwrap();
        assert_eq!(output.explain(), r#"; waiting for a newline after "mazeW""#);
        assert_eq!(Output::new(io::sink()).explain(), "");
    }
}
