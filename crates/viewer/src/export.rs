//! Exports a recording as one HTML file.
//!
//! The file contains the page with its scripts and styles, and everything that the page requests
//! from the server for one recording. The script `embedded.js` reads these data, which are JSON,
//! compressed with gzip and encoded in Base64, so that no text from a recording can end a script:
//!
//! - `responses`: the responses of the server by path
//! - `log`: all log lines, each with the index of its state
//! - `states`, once per block of states: the view of each state, as the change from the view of the
//!   previous state in the block (see [`patch`])

mod document;
mod patch;

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::sync::Arc;

use base64::prelude::BASE64_STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::GzEncoder;
use mmsim_drawing::page_json;
use mmsim_recording::{Block, LogEnd, MemoryBudget, Recording};
use serde::ser::{SerializeSeq, Serializer as _};
use serde_json::{Serializer, Value, json};

use crate::api_error::ApiError;
use crate::jobs::CancelToken;
use crate::page_info::PageInfo;
use crate::source::Source;
use crate::source_info::SourceInfo;
use crate::state_view::StateView;
use crate::{pictures, recordings};

/// The ID of the recording on an exported page.
const ID: &str = "1";

/// Writes a recording as one HTML file, which shows the recording in a browser without a server.
/// Calls `on_progress` with the number of states that have been written.
///
/// ```
/// use mmsim_recording::{Recording, save};
/// use mmsim_server::Simulation;
///
/// let simulation = Simulation::new("small", "o---o---o\n| S   G |\no---o---o\n".parse()?);
/// let mut file = Vec::new();
/// let states = [(0, vec![], b"S\0\0NC\x01\0C\x01\0".to_vec())];
/// save(&mut file, &simulation.info(), Some(simulation.maze()), states)?;
///
/// let mut page = Vec::new();
/// let recording = Recording::read(&file[..])?;
/// mmsim_viewer::export_html("run.mcap", recording, &mut page, |states| println!("{states}"))?;
/// assert!(page.starts_with(b"<!doctype html>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Returns an error if a state cannot be decoded or if the file cannot be written.
pub fn export_html(
    title: &str,
    recording: Recording,
    out: impl Write,
    on_progress: impl FnMut(usize),
) -> io::Result<()> {
    let source = Source::recording(title, recording);
    Ok(write(&source, out, &CancelToken::default(), on_progress)?)
}

/// Writes a run to a temporary HTML file and rewinds the file.
pub(crate) fn to_file(
    source: &Arc<Source>,
    run: u32,
    budget: &Arc<MemoryBudget>,
    cancel: &CancelToken,
) -> Result<File, ApiError> {
    let source = match source.integrity() {
        Some(_) => Arc::clone(source),
        // The live run may grow or end while it is written.
        None => Arc::new(copy(source, run, budget, cancel)?),
    };
    let written = || {
        let mut file = tempfile::tempfile()?;
        write(&source, BufWriter::new(&mut file), cancel, |_| {})?;
        file.rewind()?;
        Ok(file)
    };
    written().map_err(|error| match error {
        ExportError::Api(error) => error,
        error => ApiError::internal(format!("cannot save the page: {error}")),
    })
}

/// Returns a recording of the states that a run has now.
fn copy(
    source: &Source,
    run: u32,
    budget: &Arc<MemoryBudget>,
    cancel: &CancelToken,
) -> Result<Source, ApiError> {
    let file = recordings::save(source, run, cancel)?;
    let recording = Recording::read_within(io::BufReader::new(file), budget)
        .map_err(|error| ApiError::conflict(format!("cannot export the run: {error}")))?;
    Ok(Source::recording(&source.describe(run)?.title, recording))
}

/// An error while writing a page.
#[derive(Debug, thiserror::Error)]
enum ExportError {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Api(#[from] ApiError),
}

impl From<ExportError> for io::Error {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Io(error) => error,
            ExportError::Json(error) => error.into(),
            ExportError::Api(error) => Self::other(error),
        }
    }
}

/// Writes a recording.
fn write(
    source: &Source,
    mut out: impl Write,
    cancel: &CancelToken,
    mut on_progress: impl FnMut(usize),
) -> Result<(), ExportError> {
    let (run, _, states) = source.current_run()?;
    let (head, tail) = document::parts(&title(source)?)?;
    out.write_all(head.as_bytes())?;
    element(&mut out, "responses", |out| {
        Ok(serde_json::to_writer(out, &responses(source, cancel)?)?)
    })?;
    element(&mut out, "log", |out| write_log(source, cancel, out))?;
    for first in (0..states).step_by(Block::STATES) {
        cancel.check()?;
        let end = states.min(first + Block::STATES);
        element(&mut out, "states", |out| {
            let mut block = Serializer::new(out);
            let mut block = block.serialize_seq(Some(end - first))?;
            let mut previous = Value::Null;
            for index in first..end {
                let view = json(&StateView::new(source, run, index)?)?;
                let change = patch::change(&previous, &view).unwrap_or_else(|| json!({}));
                block.serialize_element(&change)?;
                previous = view;
            }
            Ok(block.end()?)
        })?;
        on_progress(end);
    }
    out.write_all(tail.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes an element with data.
fn element<W: Write>(
    out: &mut W,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    write!(out, "<script type=\"text/plain\" data-embedded=\"{name}\">")?;
    let mut text = EncoderWriter::new(&mut *out, &BASE64_STANDARD);
    let mut gzip = GzEncoder::new(&mut text, Compression::best());
    write(&mut gzip)?;
    gzip.finish()?;
    text.finish()?;
    drop(text);
    Ok(writeln!(out, "</script>")?)
}

/// Returns the responses of the server by path, except those that depend on a state.
fn responses(source: &Source, cancel: &CancelToken) -> Result<Value, ApiError> {
    let (run, ..) = source.current_run()?;
    let path = |resource: &str| format!("/api/sources/{ID}{resource}");
    let responses = [
        ("/api/page".to_string(), json(&PageInfo::exported(ID))?.to_string()),
        ("/drawing.json".into(), page_json()),
        (path(""), json(&SourceInfo::new(ID.into(), source, None)?)?.to_string()),
        (path("/drawing.svg"), pictures::page_svg(source, run)?),
        (path("/costs"), json(&source.distances(run, cancel)?)?.to_string()),
    ];
    Ok(responses.into_iter().collect())
}

/// Writes the log lines, reading those of one block of states at a time.
fn write_log(
    source: &Source,
    cancel: &CancelToken,
    out: &mut dyn Write,
) -> Result<(), ExportError> {
    let (run, _, states) = source.current_run()?;
    let mut log = Serializer::new(out);
    let mut log = log.serialize_seq(None)?;
    for first in (0..states).step_by(Block::STATES) {
        let range = first..=states.min(first + Block::STATES) - 1;
        for line in source.log(run, &range, LogEnd::First, usize::MAX, cancel, |_| true)? {
            log.serialize_element(&(line.state, line.text))?;
        }
    }
    Ok(log.end()?)
}

/// Returns the title of the document: the names of the recording, the maze and the mouse.
fn title(source: &Source) -> Result<String, ApiError> {
    let (run, description, states) = source.current_run()?;
    let last = states.checked_sub(1);
    let context = last.and_then(|last| source.block(run, last).ok()?.context(last));
    let mouse = context.as_ref().and_then(|context| context.notes().mouse());
    let mouse = mouse.map(|mouse| format!(", {mouse}")).unwrap_or_default();
    Ok(format!("{}: {}{mouse} – mmsim", description.title, description.info.name))
}

fn json(value: &impl serde::Serialize) -> Result<Value, ApiError> {
    serde_json::to_value(value).map_err(ApiError::internal)
}
