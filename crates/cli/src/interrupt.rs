//! Ctrl-C and the signals that ask a process to end.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use crate::output::say;

/// Told once the user wants the command to end.
pub(crate) struct Interrupt {
    told: Receiver<()>,
}

impl Interrupt {
    /// The exit code of a command that was interrupted, where it passes on another's.
    pub(crate) const CODE: i32 = 130;

    /// From now on SIGINT and SIGTERM end nothing but are told here. Once in a process.
    pub(crate) fn catch() -> Result<Self, ctrlc::Error> {
        let (tell, told) = mpsc::channel();
        ctrlc::set_handler(move || {
            if io::stderr().is_terminal() {
                // Past the ^C that the terminal shows.
                say("");
            }
            let _ = tell.send(());
        })?;
        Ok(Self { told })
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
