//! The result of a command, and usage errors that clap does not detect.

use std::error::Error;

/// The result of a command. `Ok(true)` stands for success, `Ok(false)` for a failure that the
/// command has already reported, and `Err` for an error that is still to be reported.
pub(crate) type CommandResult = Result<bool, Box<dyn Error>>;

/// A command-line error that clap does not detect. The process exits with code 2.
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
