//! The result of a command, and usage errors that clap does not detect.

use std::error::Error;

/// The result of a command: true for exit code 0, false for exit code 1 after the command has
/// reported a failure, or an error to report.
pub(crate) type CommandResult = Result<bool, Box<dyn Error>>;

/// An error in the combination of arguments. The process exits with code 2.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(crate) struct UsageError {
    /// The path of the command, such as `mazes convert`, or an empty string for `mmsim` itself.
    pub(crate) command: &'static str,
    pub(crate) message: String,
}

impl UsageError {
    pub(crate) fn new(command: &'static str, message: impl Into<String>) -> Self {
        Self { command, message: message.into() }
    }
}
