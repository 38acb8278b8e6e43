//! Progress bars.

use std::io::{self, IsTerminal, Read, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use terminal_size::{Width, terminal_size_of};

use crate::output::is_quiet;

/// The minimum time between two updates of a bar.
const INTERVAL: Duration = Duration::from_millis(100);

/// A progress bar in the last line of a terminal. It is removed when it is dropped.
pub(crate) struct Progress {
    /// The number of units when the work is complete, if known.
    total: Option<u64>,
    /// Describes the completed units, the total and the remaining time.
    describe: fn(u64, Option<u64>, Duration) -> String,
    start: Instant,
    state: Mutex<State>,
}

struct State {
    done: u64,
    /// The time of the next update, or `None` if the bar is not shown.
    next: Option<Instant>,
    /// The number of characters in the line.
    shown: usize,
}

impl Progress {
    /// Shows a progress bar on stderr if stderr is a terminal, unless `--quiet` is set.
    pub(crate) fn new(
        total: Option<u64>,
        describe: fn(u64, Option<u64>, Duration) -> String,
    ) -> Self {
        let start = Instant::now();
        let is_shown = io::stderr().is_terminal() && !is_quiet();
        // Work that ends at once shows no bar.
        let next = is_shown.then_some(start + INTERVAL);
        Self { total, describe, start, state: Mutex::new(State { done: 0, next, shown: 0 }) }
    }

    /// Counts completed units.
    pub(crate) fn add(&self, units: u64) {
        self.update(|done| done + units);
    }

    /// Sets the number of completed units.
    pub(crate) fn set(&self, units: u64) {
        self.update(|_| units);
    }

    fn update(&self, done: impl FnOnce(u64) -> u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.done = done(state.done);
        let now = Instant::now();
        if state.next.is_none_or(|next| now < next) {
            return;
        }
        state.next = Some(now + INTERVAL);
        let left = left(now - self.start, state.done, self.total);
        let text = (self.describe)(state.done, self.total, left);
        let columns = terminal_size_of(io::stderr()).map_or(80, |(Width(columns), _)| columns);
        let line = line(columns.into(), state.done, self.total, &text);
        state.show(&line);
    }

    /// Counts the bytes that are read.
    pub(crate) fn reader<R: Read>(&self, reader: R) -> impl Read {
        Reader { reader, progress: self }
    }
}

impl State {
    /// Replaces the line.
    fn show(&mut self, line: &str) {
        let length = line.chars().count();
        let rest = " ".repeat(self.shown.saturating_sub(length));
        let _ = write!(io::stderr(), "\r{line}{rest}{}", if length == 0 { "\r" } else { "" });
        self.shown = length;
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        if state.shown > 0 {
            state.show("");
        }
    }
}

struct Reader<'a, R> {
    reader: R,
    progress: &'a Progress,
}

impl<R: Read> Read for Reader<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(buffer)?;
        self.progress.add(count as u64);
        Ok(count)
    }
}

/// Estimates the remaining time from the time so far.
fn left(time: Duration, done: u64, total: Option<u64>) -> Duration {
    let (Some(total), true) = (total, done > 0) else { return Duration::ZERO };
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let ratio = total.saturating_sub(done) as f64 / done as f64;
    Duration::try_from_secs_f64(time.as_secs_f64() * ratio).unwrap_or(Duration::MAX)
}

/// Returns a bar, if there is room for one, and the text.
fn line(columns: usize, done: u64, total: Option<u64>, text: &str) -> String {
    // The last column stays empty, since some terminals start a new line after it.
    let room = columns.saturating_sub(text.chars().count() + 2);
    let Some(total) = total.filter(|_| room >= 8) else {
        return text.chars().take(columns.saturating_sub(1)).collect();
    };
    let full = (room as u64).saturating_mul(done.min(total)) / total.max(1);
    let full = usize::try_from(full).unwrap_or(room);
    format!("{}{} {text}", "█".repeat(full), "░".repeat(room - full))
}

/// Formats a remaining time, such as `5 s` or `3 min`.
pub(crate) fn time_left(left: Duration) -> String {
    match left.as_secs() {
        seconds @ 0..100 => format!("{seconds} s"),
        seconds @ 100..6000 => format!("{} min", seconds / 60),
        seconds => format!("{} h", seconds / 3600),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_fills_the_line() {
        assert_eq!(line(20, 3, Some(10), "3 of 10"), "███░░░░░░░░ 3 of 10");
        assert_eq!(line(20, 10, Some(10), "10 of 10"), "██████████ 10 of 10");
        assert_eq!(line(20, 11, Some(10), "11 of 10"), "██████████ 11 of 10");
        assert_eq!(line(20, 0, Some(0), "0 of 0"), "░░░░░░░░░░░░ 0 of 0");
        assert_eq!(line(20, 7, None, "7 bytes"), "7 bytes");
        assert_eq!(line(10, 3, Some(10), "3 of 10 searches"), "3 of 10 s");
    }

    #[test]
    fn the_remaining_time_is_estimated() {
        let second = Duration::from_secs(1);
        assert_eq!(left(10 * second, 20, Some(80)), 30 * second);
        assert_eq!(left(10 * second, 0, Some(80)), Duration::ZERO);
        assert_eq!(left(10 * second, 20, None), Duration::ZERO);
        let times = [99, 100, 5999, 6000].map(|seconds| time_left(seconds * second));
        assert_eq!(times, ["99 s", "1 min", "99 min", "1 h"]);
    }

    #[test]
    fn bytes_are_counted_and_nothing_is_shown_without_a_terminal() {
        let mut progress = Progress::new(Some(9), |done, _, _| done.to_string());
        progress.state.get_mut().unwrap().next = None;
        let mut read = Vec::new();
        progress.reader(&b"abcdefghi"[..]).read_to_end(&mut read).unwrap();
        assert_eq!((read.len(), progress.state.lock().unwrap().done), (9, 9));
        progress.set(4);
        let state = progress.state.lock().unwrap();
        assert_eq!((state.done, state.shown), (4, 0));
    }
}
