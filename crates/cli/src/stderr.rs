//! Writing to stderr on a separate thread, so that a full pipe does not block a server.

use std::io::{self, Write};
use std::mem;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// The maximum size of the queued messages in bytes, excluding messages that are being written.
const MAX_QUEUED_BYTES: usize = 1 << 20;

/// The maximum time to wait at exit for the remaining messages to be written.
const FLUSH_TIMEOUT: Duration = Duration::from_millis(500);

/// The queue of messages for the writing thread.
static BACKLOG: Backlog = Backlog::new();

/// True if the writing thread is running.
static IS_IN_BACKGROUND: AtomicBool = AtomicBool::new(false);

/// Starts a thread that writes all messages from now on. While the queue is full, further messages
/// are dropped and counted. Call this once per process.
pub(crate) fn write_in_background() {
    // If the thread cannot start, each message is still written directly.
    if thread::Builder::new().spawn(|| BACKLOG.write_to(io::stderr())).is_ok() {
        IS_IN_BACKGROUND.store(true, Ordering::Relaxed);
    }
}

/// Waits up to half a second for the remaining messages to be written.
pub(crate) fn flush() {
    BACKLOG.flush(FLUSH_TIMEOUT);
}

/// A writer to stderr that ignores errors.
pub(crate) struct Stderr;

impl Write for Stderr {
    fn write(&mut self, message: &[u8]) -> io::Result<usize> {
        if IS_IN_BACKGROUND.load(Ordering::Relaxed) {
            BACKLOG.push(message);
        } else {
            let _ = io::stderr().write_all(message);
        }
        Ok(message.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A bounded queue of messages for the writing thread.
struct Backlog {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    queued: Vec<u8>,
    /// The number of messages dropped since the queue became full.
    lost: u64,
    is_writing: bool,
}

impl State {
    const fn is_empty(&self) -> bool {
        self.queued.is_empty() && self.lost == 0
    }
}

impl Backlog {
    const fn new() -> Self {
        let state = State { queued: Vec::new(), lost: 0, is_writing: false };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues a message, or drops it if the queue is full.
    fn push(&self, message: &[u8]) {
        let mut state = self.lock();
        if state.lost == 0 && state.queued.len() + message.len() <= MAX_QUEUED_BYTES {
            state.queued.extend_from_slice(message);
        } else {
            state.lost += 1;
        }
        self.changed.notify_all();
    }

    /// Writes queued messages in an endless loop.
    fn write_to(&self, mut out: impl Write) -> ! {
        loop {
            let state = self.changed.wait_while(self.lock(), |state| state.is_empty());
            let mut state = state.unwrap_or_else(PoisonError::into_inner);
            let (mut messages, lost) = (mem::take(&mut state.queued), mem::take(&mut state.lost));
            state.is_writing = true;
            drop(state);
            if lost > 0 {
                let report = format!("{lost} messages lost: stderr was not read in time\n");
                messages.extend(report.bytes());
            }
            // There is no place to report an error.
            let _ = out.write_all(&messages);
            self.lock().is_writing = false;
            self.changed.notify_all();
        }
    }

    /// Waits until all messages are written or the timeout expires.
    fn flush(&self, timeout: Duration) {
        let is_busy = |state: &mut State| state.is_writing || !state.is_empty();
        let _ = self.changed.wait_timeout_while(self.lock(), timeout, is_busy);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{self, Receiver, Sender};

    use super::*;

    /// A pipe that blocks each write until the test sends a message on the channel `read`.
    struct Pipe {
        begun: Sender<()>,
        read: Receiver<()>,
        written: Sender<String>,
    }

    impl Write for Pipe {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.begun.send(()).unwrap();
            self.read.recv().map_err(|_| io::ErrorKind::BrokenPipe)?;
            self.written.send(String::from_utf8_lossy(bytes).into()).unwrap();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn an_unread_pipe_loses_messages_without_blocking() {
        let backlog: &Backlog = Box::leak(Box::new(Backlog::new()));
        let ((begun, has_begun), (read, reads)) = (mpsc::channel(), mpsc::channel());
        let (written, text) = mpsc::channel();
        thread::spawn(move || backlog.write_to(Pipe { begun, read: reads, written }));
        backlog.push(b"first\n");
        has_begun.recv().unwrap();
        // The thread is blocked now, so further messages are queued or lost.
        let message = [&[b'x'; 99][..], b"\n"].concat();
        let (room, lost) = (MAX_QUEUED_BYTES / message.len(), 1000);
        for _ in 0..room + lost {
            backlog.push(&message);
        }
        backlog.flush(Duration::ZERO);
        read.send(()).unwrap();
        assert_eq!(text.recv().unwrap(), "first\n");
        read.send(()).unwrap();
        let rest = text.recv().unwrap();
        assert_eq!(rest.lines().filter(|line| line.starts_with('x')).count(), room);
        assert!(rest.ends_with("\n1000 messages lost: stderr was not read in time\n"));
        backlog.push(b"last\n");
        read.send(()).unwrap();
        backlog.flush(Duration::MAX);
        assert_eq!(text.recv().unwrap(), "last\n");
        // A write error does not stop the thread.
        drop(read);
        backlog.push(b"unread\n");
        backlog.flush(Duration::MAX);
    }
}
