//! Ctrl-C and the signals that ask a process to exit.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use crate::output::note;

/// Receives Ctrl-C and signals.
pub(crate) struct Interrupt {
    signals: Receiver<()>,
    /// Keeps the channel open if every signal is ignored.
    _open: Sender<()>,
}

impl Interrupt {
    /// The exit code of an interrupted command that otherwise passes on the code of another process.
    pub(crate) const CODE: i32 = 130;

    /// Catches SIGINT, SIGTERM and SIGHUP from now on. Signals that the process was started to ignore
    /// stay ignored. Call this once per process.
    pub(crate) fn catch() -> Result<Self, Box<dyn Error>> {
        let (sender, signals) = mpsc::channel();
        let open = sender.clone();
        on_signal(move || {
            if io::stderr().is_terminal() {
                // Start a new line after the ^C that the terminal shows.
                note("");
            }
            let _ = sender.send(());
        })?;
        Ok(Self { signals, _open: open })
    }

    /// Waits for an interrupt.
    pub(crate) fn wait(&self) {
        let _ = self.signals.recv();
    }

    /// Waits for an interrupt until the timeout. Returns whether there was one.
    pub(crate) fn wait_for(&self, timeout: Duration) -> bool {
        !matches!(self.signals.recv_timeout(timeout), Err(RecvTimeoutError::Timeout))
    }
}

/// Calls `notify` on each of the signals, except for ignored ones: `nohup` ignores SIGHUP, and a shell
/// ignores SIGINT for the background jobs of a script.
#[cfg(unix)]
fn on_signal(notify: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // `sigaction` needs `unsafe`, and only Linux has a status file. Elsewhere SIGHUP is never caught,
    // so that `nohup` works there too.
    let status = std::fs::read_to_string("/proc/self/status").ok();
    let ignored = status.map_or(1 << (SIGHUP - 1), |status| ignored(&status));
    let signals = [SIGINT, SIGTERM, SIGHUP].into_iter();
    let mut signals = Signals::new(signals.filter(|signal| ignored >> (signal - 1) & 1 == 0))?;
    std::thread::spawn(move || signals.forever().for_each(|_| notify()));
    Ok(())
}

/// Returns the ignored signals from the status of a process: bit n - 1 is signal n.
#[cfg(unix)]
fn ignored(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Calls `notify` on Ctrl-C and similar events.
#[cfg(not(unix))]
fn on_signal(notify: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(notify)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_status() {
        let status = "Name:\tmmsim\nSigBlk:\tffffffffffffffff\nSigIgn:\t0000000000001001\n";
        assert_eq!(ignored(status), 1 | 1 << 12, "SIGHUP and SIGPIPE");
        assert_eq!(ignored(""), 0);
    }
}
