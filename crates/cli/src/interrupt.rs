//! Ctrl-C and the signals that ask a process to exit.

use std::error::Error;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

use mmsim_mouse::{StopCheck, StopReason};

use crate::exit;
use crate::output::note;

/// A receiver of Ctrl-C and other signals.
pub(crate) struct Interrupt {
    signals: Receiver<()>,
    /// An unused sender, which keeps the channel open even if every signal is ignored.
    _open: Sender<()>,
}

impl Interrupt {
    /// The exit code of `mmsim run` after an interrupt.
    pub(crate) const CODE: i32 = StopReason::Exit.exit_code();

    /// Starts catching SIGINT, SIGTERM and SIGHUP, except those that were ignored when the process
    /// started. Call this once per process.
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

    /// Acts on another thread as soon as there is an interrupt.
    pub(crate) fn then(self, act: impl FnOnce() + Send + 'static) {
        thread::spawn(move || {
            self.wait();
            act();
        });
    }

    /// Waits for an interrupt, but at most for the given time. Returns true if there was an
    /// interrupt.
    pub(crate) fn wait_for(&self, timeout: Duration) -> bool {
        !matches!(self.signals.recv_timeout(timeout), Err(RecvTimeoutError::Timeout))
    }
}

/// A flag that Ctrl-C sets while programs of the user are running, so that they can be killed. The
/// default flag is never set.
#[derive(Default)]
pub(crate) struct StopFlag {
    is_set: Arc<AtomicBool>,
    are_running: Arc<AtomicBool>,
}

impl StopFlag {
    /// Starts catching Ctrl-C if programs of the user are running. Call this once per process.
    pub(crate) fn catch_if(are_running: bool) -> Result<Self, Box<dyn Error>> {
        if !are_running {
            return Ok(Self::default());
        }
        let interrupt = Interrupt::catch()?;
        let is_set = Arc::new(AtomicBool::new(false));
        let are_running = Arc::new(AtomicBool::new(true));
        let flag = Self { is_set: Arc::clone(&is_set), are_running: Arc::clone(&are_running) };
        interrupt.then(move || {
            is_set.store(true, Ordering::SeqCst);
            if !are_running.load(Ordering::SeqCst) {
                exit(Interrupt::CODE);
            }
        });
        Ok(flag)
    }

    /// Returns a function that returns true once the flag is set.
    pub(crate) fn check(&self) -> StopCheck {
        let is_set = Arc::clone(&self.is_set);
        Arc::new(move || is_set.load(Ordering::SeqCst))
    }

    pub(crate) fn is_set(&self) -> bool {
        self.is_set.load(Ordering::SeqCst)
    }

    /// Exits if Ctrl-C has stopped the programs. From now on, Ctrl-C ends the process directly.
    pub(crate) fn end(self) {
        self.are_running.store(false, Ordering::SeqCst);
        if self.is_set() {
            exit(Interrupt::CODE);
        }
    }
}

/// Calls `notify` on SIGINT, SIGTERM and SIGHUP, except those that are ignored. `nohup` makes a
/// process ignore SIGHUP, and a shell makes the background jobs of a script ignore SIGINT.
#[cfg(unix)]
fn on_signal(notify: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // `sigaction` needs `unsafe`, and only Linux has a status file. On other systems SIGHUP is
    // never caught, so that `nohup` works there too.
    let status = std::fs::read_to_string("/proc/self/status").ok();
    let ignored = status.map_or(1 << (SIGHUP - 1), |status| ignored(&status));
    let signals = [SIGINT, SIGTERM, SIGHUP].into_iter();
    let mut signals = Signals::new(signals.filter(|signal| ignored >> (signal - 1) & 1 == 0))?;
    std::thread::spawn(move || signals.forever().for_each(|_| notify()));
    Ok(())
}

/// Returns the set of ignored signals from the content of /proc/self/status. Bit n - 1 is set if
/// signal n is ignored.
#[cfg(unix)]
fn ignored(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Calls `notify` on Ctrl-C and on other events that ask the process to exit.
#[cfg(not(unix))]
fn on_signal(notify: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(notify)
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_status() {
        let status = "Name:\tmmsim\nSigBlk:\tffffffffffffffff\nSigIgn:\t0000000000001001\n";
        assert_eq!(ignored(status), 1 | 1 << 12, "SIGHUP and SIGPIPE");
        assert_eq!(ignored(""), 0);
    }
}
