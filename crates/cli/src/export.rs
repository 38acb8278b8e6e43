//! `mmsim export`: write a maze or a recording as a picture, a recording as a page, or pack it.

mod drawing;

use std::error::Error;
use std::ffi::OsStr;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use clap::Args;
use mmsim_compare::NamedMaze;
use mmsim_fastrun::Vehicle;
use mmsim_recording::Recording;
use mmsim_viewer::{Vehicles, export_html};

use crate::args::{CommandResult, ReadingArgs, UsageError, extension, wrong_extension};
use crate::output::{replace, replace_or_print};
use crate::picture::{PictureFile, PictureFormat, parse_picture};
use crate::recordings::{self, is_undamaged, messages_unless, recording_budget};
use crate::selection::{MAZE_HELP, Selection, is_recording, join};
use crate::terminal::progress_bar;
use crate::vehicle::{parse_vehicle, warn_about};
use drawing::{DRAWING, DrawingArgs};

const AFTER_HELP: &str = "\
Examples:
  mmsim export harbour -o harbour.svg             draw a maze
  mmsim export winding river --heat -o maze.png   colour it by the distance to the goal
  mmsim export run.mcap -o run.png                draw the last state of a recording
  mmsim export run.mcap -o run.gif                animate it
  mmsim export run.mcap -o run.html               save it as a page that any browser shows
  mmsim export run.mcap -o packed.mcap            pack it, as the server does after a run";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct ExportArgs {
    #[arg(
        required = true,
        value_name = "MAZE|RECORDING",
        help = format!(
            "Recording file, of which the intact part is exported, or {}",
            MAZE_HELP.to_lowercase()
        )
    )]
    source: Vec<PathBuf>,
    /// File to write: .svg or .png for a picture and, of a recording, .gif for an animation, .html
    /// for a page, .mcap for a packed recording, or - to write the page to stdout. An existing file is
    /// replaced
    #[arg(short, long, value_name = "FILE", value_parser = parse_output)]
    output: ExportFile,
    #[command(flatten)]
    drawing: DrawingArgs,
    /// Add the vehicle in FILE (TOML) to those whose fast runs the page plays; may be repeated
    #[arg(long, value_name = "FILE", conflicts_with = DRAWING, value_parser = parse_vehicle)]
    vehicle: Vec<Vehicle>,
    /// Write only the states to .mcap, without the JSON channels for Foxglove and other tools
    #[arg(long, conflicts_with_all = [DRAWING, "vehicle"])]
    states_only: bool,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// The file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
enum ExportFile {
    Picture(PictureFile),
    Page(PathBuf),
    Recording(PathBuf),
}

impl ExportArgs {
    /// Returns an error if an option does not apply to the file.
    fn check(&self) -> Result<(), UsageError> {
        let for_picture = self.drawing.given();
        let for_page = given(&[("--vehicle", !self.vehicle.is_empty())]);
        let for_recording = given(&[("--states-only", self.states_only)]);
        let pictures = match for_picture {
            Some("--width") => "a .png or .gif file",
            _ => "an .svg, .png or .gif file",
        };
        let picture = (for_picture, pictures);
        let (page, recording) = ((for_page, "an .html file"), (for_recording, "an .mcap file"));
        let others = match &self.output {
            ExportFile::Picture(_) => [page, recording],
            ExportFile::Page(_) => [picture, recording],
            ExportFile::Recording(_) => [picture, page],
        };
        let message = others.iter().find_map(|(option, file)| Some((option.as_ref()?, file)));
        match (message, &self.output) {
            (Some((option, file)), _) => Err(format!("{option} needs {file}")),
            (None, ExportFile::Picture(picture)) => picture.check_width(self.drawing.width),
            (None, _) => Ok(()),
        }
        .map_err(|message| UsageError::new("export", message))
    }
}

/// Returns the name of the first option that was given.
fn given(options: &[(&'static str, bool)]) -> Option<&'static str> {
    options.iter().find(|(_, is_given)| *is_given).map(|(name, _)| *name)
}

fn parse_output(text: &str) -> Result<ExportFile, String> {
    match &extension(Path::new(text))[..] {
        "html" | "htm" => Ok(ExportFile::Page(text.into())),
        "mcap" => Ok(ExportFile::Recording(text.into())),
        "" if text == "-" => Ok(ExportFile::Page(text.into())),
        other => parse_picture(text)
            .map(ExportFile::Picture)
            .map_err(|_| wrong_extension(".svg, .png, .gif, .html or .mcap", other)),
    }
}

pub(crate) fn run(args: &ExportArgs) -> CommandResult {
    args.check()?;
    let source = join(&args.source);
    let file = Path::new(&source);
    let is_named_recording = extension(file) == "mcap" && file.exists();
    // The file that is written decides what a pipe contains.
    let is_pipe = file.exists() && !file.is_file() && !file.is_dir();
    let is_piped_recording = is_pipe && !matches!(args.output, ExportFile::Picture(_));
    if !is_named_recording && !is_piped_recording && !is_recording(file) {
        export_maze(args, &source)?;
        return Ok(true);
    }
    let recording = recordings::open(file, &recording_budget(&args.reading))?;
    match &args.output {
        ExportFile::Picture(picture) => {
            replace(&picture.path, &args.drawing.draw_recording(picture, file, &recording)?)?;
            Ok(is_undamaged(file, &recording))
        }
        ExportFile::Page(path) => {
            let is_intact = is_undamaged(file, &recording);
            replace_or_print(path, &page(args, file, recording)?)?;
            Ok(is_intact)
        }
        ExportFile::Recording(path) => {
            let mut packed = Cursor::new(Vec::new());
            recording.save(&mut packed, messages_unless(args.states_only))?;
            replace(path, packed.get_ref())?;
            Ok(is_undamaged(file, &recording))
        }
    }
}

/// Draws a maze.
fn export_maze(args: &ExportArgs, maze: &OsStr) -> Result<(), Box<dyn Error>> {
    let NamedMaze { path, maze, .. } = Selection::read(maze)?.first()?;
    let limit = ("--history-limit", args.reading.history_limit.is_some());
    let option = args.drawing.given_for_recording().or_else(|| given(&[limit]));
    let wrong = match (&args.output, option) {
        (ExportFile::Page(_), _) => "an .html file",
        (ExportFile::Recording(_), _) => "an .mcap file",
        (ExportFile::Picture(picture), _) if picture.format == PictureFormat::Gif => "a .gif file",
        (ExportFile::Picture(_), Some(option)) => option,
        (ExportFile::Picture(PictureFile { path, format }), None) => {
            return Ok(replace(path, &args.drawing.draw_maze(*format, &maze)?)?);
        }
    };
    Err(format!("{}: {wrong} needs a recording, not a maze", path.display()).into())
}

/// Writes a recording as a page.
fn page(args: &ExportArgs, file: &Path, recording: Recording) -> Result<Vec<u8>, Box<dyn Error>> {
    let title = file.file_name().unwrap_or_default().to_string_lossy();
    let states = recording.history().len() as u64;
    let progress = progress_bar(Some(states), "{pos} of {len} states");
    let mut page = Vec::new();
    args.vehicle.iter().for_each(warn_about);
    let vehicles = Vehicles::new(args.vehicle.clone())?;
    export_html(&title, recording, &vehicles, &mut page, |states| {
        progress.set_position(states as u64);
    })
    .map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_selects_what_is_written() {
        for path in ["a/b.HTML", "run.htm", "-"] {
            assert_eq!(parse_output(path), Ok(ExportFile::Page(path.into())));
        }
        assert_eq!(parse_output("run.mcap"), Ok(ExportFile::Recording("run.mcap".into())));
        assert!(matches!(parse_output("run.gif"), Ok(ExportFile::Picture(_))));
        let error = "expected a file ending in .svg, .png, .gif, .html or .mcap, found .jpeg";
        assert_eq!(parse_output("run.jpeg"), Err(error.into()));
        assert!(parse_output("html").is_err() && parse_output("").is_err());
    }
}
