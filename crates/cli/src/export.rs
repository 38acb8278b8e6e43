//! `mmsim export`: write a recording as an HTML file or as a packed recording.

use std::io::Cursor;
use std::path::PathBuf;

use clap::Args;
use mmsim_fastrun::Vehicle;
use mmsim_viewer::{Vehicles, export_html};

use crate::args::{CommandResult, ReadingArgs, UsageError, extension, wrong_extension};
use crate::output::{replace, replace_or_print};
use crate::recordings::{self, is_undamaged, messages_unless, recording_budget};
use crate::terminal::progress_bar;
use crate::vehicle::{parse_vehicle, warn_about};

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Recording file; if the file is truncated, the intact part is exported
    file: PathBuf,
    /// File to write: .html for a page, .mcap for a packed recording, or - to write the page to
    /// stdout. An existing file is replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_output)]
    output: PathBuf,
    /// Add the vehicle in FILE (TOML) to those whose fast runs the page plays; may be repeated
    #[arg(long, value_name = "FILE", value_parser = parse_vehicle)]
    vehicle: Vec<Vehicle>,
    /// Write only the states to .mcap, without the JSON channels for Foxglove and other tools
    #[arg(long, conflicts_with = "vehicle")]
    states_only: bool,
    #[command(flatten)]
    reading: ReadingArgs,
}

impl ExportArgs {
    /// Returns true if the output is a recording, or an error if the options belong to the other
    /// format.
    fn is_recording(&self) -> Result<bool, UsageError> {
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
        other => Err(wrong_extension(".html or .mcap", other)),
    }
}

pub(crate) fn run(args: &ExportArgs) -> CommandResult {
    let is_recording = args.is_recording()?;
    let recording = recordings::open(&args.file, &recording_budget(&args.reading))?;
    let is_intact = is_undamaged(&args.file, &recording);
    if is_recording {
        let mut file = Cursor::new(Vec::new());
        recording.save(&mut file, messages_unless(args.states_only))?;
        replace(&args.output, file.get_ref())?;
        return Ok(is_intact);
    }
    let title = args.file.file_name().unwrap_or_default().to_string_lossy();
    let states = recording.history().len() as u64;
    let progress = progress_bar(Some(states), "{pos} of {len} states");
    let mut page = Vec::new();
    args.vehicle.iter().for_each(warn_about);
    let vehicles = Vehicles::new(args.vehicle.clone())?;
    export_html(&title, recording, &vehicles, &mut page, |states| {
        progress.set_position(states as u64);
    })
    .map_err(|error| format!("{}: {error}", args.file.display()))?;
    drop(progress);
    replace_or_print(&args.output, &page)?;
    Ok(is_intact)
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
