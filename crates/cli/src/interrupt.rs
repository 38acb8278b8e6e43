//! Ctrl-C and the signals that ask a process to end.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use crate::output::note;

/// Told once the user wants the command to end.
pub(crate) struct Interrupt {
    told: Receiver<()>,
    /// Keeps the channel open where every signal is ignored.
    _open: Sender<()>,
}

impl Interrupt {
    /// The exit code of a command that was interrupted, where it passes on another's.
    pub(crate) const CODE: i32 = 130;

    /// From now on SIGINT, SIGTERM and SIGHUP end nothing but are told here. Those that the process
    /// was started to ignore stay ignored. Once in a process.
    pub(crate) fn catch() -> Result<Self, Box<dyn Error>> {
        let (tell, told) = mpsc::channel();
        let open = tell.clone();
        on_signal(move || {
            if io::stderr().is_terminal() {
                // Past the ^C that the terminal shows.
                note("");
            }
            let _ = tell.send(());
        })?;
        Ok(Self { told, _open: open })
    }

    /// Waits until the command shall end.
    pub(crate) fn wait(&self) {
        let _ = self.told.recv();
    }

    /// Waits this long; `true` if the command shall end.
    pub(crate) fn wait_for(&self, pause: Duration) -> bool {
        !matches!(self.told.recv_timeout(pause), Err(RecvTimeoutError::Timeout))
    }
}

/// Calls `notify` on each of the signals, except for ignored ones: `nohup` ignores SIGHUP, and a shell
/// ignores SIGINT for the background jobs of a script.
#[cfg(unix)]
fn on_signal(notify: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // Without `unsafe` nobody can ask `sigaction`, and only Linux has the status in a file. Elsewhere
    // SIGHUP is never caught, so that `nohup` works there, too.
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

/// Calls `notify` on Ctrl-C and its like.
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
