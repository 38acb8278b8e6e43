//! Arguments of `mmsim export`.

use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_fastrun::Vehicle;

use crate::args::{ReadingArgs, UsageError};
use crate::vehicle::parse_vehicle;

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Recording file; if the file is truncated, the intact part is exported
    pub(crate) file: PathBuf,
    /// File to write: .html for a page, .mcap for a packed recording, or - to write the page to
    /// stdout. An existing file is replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_output)]
    pub(crate) output: PathBuf,
    /// Add the vehicle in FILE (TOML) to those whose fast runs the page plays; may be repeated
    #[arg(long, value_name = "FILE", value_parser = parse_vehicle)]
    pub(crate) vehicle: Vec<Vehicle>,
    /// Write only the states to .mcap, without the JSON channels for Foxglove and other tools
    #[arg(long, conflicts_with = "vehicle")]
    pub(crate) states_only: bool,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

impl ExportArgs {
    /// Returns true if the output is a recording, or an error if the options belong to the other
    /// format.
    pub(crate) fn is_recording(&self) -> Result<bool, UsageError> {
        let is_recording = extension(&self.output) == "mcap";
        let message = if is_recording && !self.vehicle.is_empty() {
            "a recording has no --vehicle; only .html does"
        } else if !is_recording && self.states_only {
            "a page has no --states-only; only .mcap does"
        } else {
            return Ok(is_recording);
        };
        Err(UsageError::new("export", message))
    }
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match &extension(&path)[..] {
        "html" | "htm" | "mcap" => Ok(path),
        "" if text == "-" => Ok(path),
        "" => Err("expected a file ending in .html or .mcap".into()),
        other => Err(format!("expected a file ending in .html or .mcap, found .{other}")),
    }
}

/// Returns the extension in lower case.
fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_and_recordings_are_written() {
        for path in ["a/b.HTML", "run.htm", "run.mcap", "-"] {
            assert_eq!(parse_output(path), Ok(path.into()));
        }
        let error = "expected a file ending in .html or .mcap, found .gif".to_string();
        assert_eq!(parse_output("run.gif"), Err(error));
        assert!(parse_output("html").is_err() && parse_output("").is_err());
    }
}
