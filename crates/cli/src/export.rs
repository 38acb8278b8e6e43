//! `mmsim export`: write a recording as an HTML file or as a packed recording.

pub(crate) mod args;

use std::io::Cursor;
use std::path::Path;

use args::ExportArgs;
use mmsim_recording::Recording;
use mmsim_viewer::{Vehicles, export_html};

use crate::args::CommandResult;
use crate::output::{print, replace};
use crate::playback::is_undamaged;
use crate::progress::progress_bar;
use crate::retention::{messages_unless, recording_budget};
use crate::vehicle::warn_about;

/// The path that stands for stdout.
const STANDARD: &str = "-";

pub(crate) fn run(args: &ExportArgs) -> CommandResult {
    let is_recording = args.is_recording()?;
    let recording = Recording::open_within(&args.file, &recording_budget(&args.reading))?;
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
    if args.output == Path::new(STANDARD) {
        print(&page)?;
    } else {
        replace(&args.output, &page)?;
    }
    Ok(is_intact)
}
