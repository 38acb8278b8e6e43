//! `mmsim export`: write a recording as an HTML file.

pub(crate) mod args;

use std::io::{self, BufWriter, Write};
use std::path::Path;

use args::ExportArgs;
use indicatif::ProgressBar;
use mmsim_recording::Recording;
use mmsim_viewer::export_html;

use crate::output::{progress, replace_with, unless_closed};
use crate::playback::is_undamaged;
use crate::retention::recording_budget;
use crate::usage::CommandResult;

/// The path that stands for stdout.
const STANDARD: &str = "-";

pub(crate) fn run(args: &ExportArgs) -> CommandResult {
    let recording = Recording::open_within(&args.file, &recording_budget(&args.reading))?;
    let is_intact = is_undamaged(&args.file, &recording);
    let title = args.file.file_name().unwrap_or_default().to_string_lossy();
    let states = recording.history().len() as u64;
    let bar = progress(ProgressBar::new(states), "{wide_bar} {pos} of {len} states");
    let write = |out: &mut dyn Write| {
        export_html(&title, recording, out, |states| bar.set_position(states as u64))
    };
    if args.output == Path::new(STANDARD) {
        unless_closed(write(&mut BufWriter::new(io::stdout().lock())))?;
    } else {
        replace_with(&args.output, write)?;
    }
    bar.finish_and_clear();
    Ok(is_intact)
}
