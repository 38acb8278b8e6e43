//! The result of a command, and mistakes on the command line that clap cannot detect.

use std::error::Error;

/// Whether the work succeeded: the goal was reached, every maze is valid. An error says why it could
/// not be attempted.
pub(crate) type CommandResult = Result<bool, Box<dyn Error>>;

/// Arguments that do not fit together. The process exits with code 2.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(crate) struct UsageError {
    /// The names of the command and its parents, separated by spaces, such as `mazes convert`. Empty
    /// for `mmsim` itself.
    pub(crate) command: &'static str,
    pub(crate) message: String,
}

impl UsageError {
    pub(crate) fn new(command: &'static str, message: impl Into<String>) -> Self {
        Self { command, message: message.into() }
    }
}
