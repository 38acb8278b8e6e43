//! Exports a recording as one HTML file.
//!
//! The file contains the page with its scripts and styles, and everything that the page requests
//! from the server for one recording. An open page requests the same data of a run, to show the run
//! when the server has stopped. The script `embedded.js` reads these data, which are JSON,
//! compressed with gzip and encoded in Base64, so that no text from a recording can end a script:
//!
//! - `responses`: the responses of the server by path
//! - `log`: all log lines, each with the index of its state
//! - `states`, once per block of states: the view of each state, as the change from the view of the
//!   previous state in the block (see [`patch`])

mod patch;

use std::fs::File;
use std::io::{self, BufWriter, IntoInnerError, Seek, Write};
use std::sync::Arc;

use base64::prelude::BASE64_STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::GzEncoder;
use mmsim_drawing::page_json;
use mmsim_fastrun::{Planner, Vehicle};
use mmsim_recording::{Block, LogEnd, MemoryBudget, Recording};
use mmsim_run::EndFacts;
use serde::ser::{SerializeSeq, Serializer as _};
use serde_json::{Serializer, Value, json};

use crate::http::assets;
use crate::http::events::PageInfo;
use crate::http::jobs::{ApiError, ApiResult, CancelToken};
use crate::source::fast_runs::Vehicles;
use crate::source::views::{SourceInfo, StateView};
use crate::source::{StateSource, fast_runs, pictures, recordings};

/// The ID of the recording on an exported page.
const ID: &str = "1";

/// Writes a recording as one HTML file, which shows the recording in a browser without a server. The
/// first given one of `vehicles`, or the default of the maze, times the runs.
/// Calls `on_progress` with the number of states that have been written.
///
/// ```
/// use mmsim_recording::{Recording, save};
/// use mmsim_server::Simulation;
/// use mmsim_viewer::{Vehicles, export_html};
///
/// let simulation = Simulation::new("small", "o---o---o\n| S   G |\no---o---o\n".parse()?);
/// let mut file = std::io::Cursor::new(Vec::new());
/// let states = [(0, vec![], b"S\0\0NC\x01\0C\x01\0".to_vec())];
/// save(&mut file, &simulation.info(), Some(simulation.maze()), states, &simulation.trailing())?;
///
/// let mut page = Vec::new();
/// let recording = Recording::read(&file.into_inner()[..])?;
/// export_html("run.mcap", recording, &Vehicles::default(), &mut page, |states| println!("{states}"))?;
/// assert!(page.starts_with(b"<!doctype html>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Returns an error if a state cannot be decoded or if the file cannot be written.
pub fn export_html(
    title: &str,
    recording: Recording,
    vehicles: &Vehicles,
    out: impl Write,
    on_progress: impl FnMut(usize),
) -> io::Result<()> {
    let source = StateSource::recording(title, recording);
    let vehicle = vehicles.selected(source.current_run()?.1.size);
    write(&source, vehicle, Content::Page, out, &CancelToken::default(), on_progress)
}

/// What a file contains.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Content {
    /// The page and the data of a run.
    Page,
    /// The data of a run, for a page that is open.
    Data,
}

/// Writes a run to a temporary HTML file and rewinds the file.
pub(crate) fn to_file(
    source: &Arc<StateSource>,
    run: u32,
    content: Content,
    vehicle: Vehicle,
    budget: &Arc<MemoryBudget>,
    cancel: &CancelToken,
) -> ApiResult<File> {
    source.describe(run)?;
    let source = if source.integrity().is_some() {
        Arc::clone(source)
    } else {
        // The live run may grow or end while it is written.
        let file = io::BufReader::new(recordings::save(source, run, cancel)?);
        let recording = Recording::read_within(file, budget)
            .map_err(|error| ApiError::conflict(format!("cannot export the run: {error}")))?;
        Arc::new(StateSource::recording(&source.describe(run)?.title, recording))
    };
    let written = || -> io::Result<File> {
        let mut file = tempfile::tempfile()?;
        write(&source, vehicle, content, BufWriter::new(&mut file), cancel, |_| {})?;
        file.rewind()?;
        Ok(file)
    };
    let failed = |error| ApiError::internal(format!("cannot save the page: {error}"));
    written().map_err(|error| error.downcast().unwrap_or_else(failed))
}

/// Lets the functions that write a page return only one kind of error. [`to_file`] converts it back.
impl From<ApiError> for io::Error {
    fn from(error: ApiError) -> Self {
        Self::other(error)
    }
}

/// Writes a recording with the times of a vehicle.
fn write(
    source: &StateSource,
    vehicle: Vehicle,
    content: Content,
    mut out: impl Write,
    cancel: &CancelToken,
    mut on_progress: impl FnMut(usize),
) -> io::Result<()> {
    let (run, _, states) = source.current_run()?;
    let vehicles = Vehicles::only(vehicle.clone());
    let mut planner = Planner::new(vehicle);
    let (head, tail) = match content {
        Content::Page => assets::document(&title(source)?)?,
        Content::Data => Default::default(),
    };
    out.write_all(head.as_bytes())?;
    element(&mut out, "responses", |out| {
        Ok(serde_json::to_writer(out, &responses(source, &vehicles, cancel)?)?)
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
                let view = json(&StateView::new(source, run, index, &mut planner)?)?;
                let change = patch::change(&previous, &view).unwrap_or_else(|| json!({}));
                block.serialize_element(&change)?;
                previous = view;
            }
            Ok(block.end()?)
        })?;
        on_progress(end);
    }
    out.write_all(tail.as_bytes())?;
    out.flush()
}

/// Writes an element with data.
fn element<W: Write>(
    out: &mut W,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "<script type=\"text/plain\" data-embedded=\"{name}\">")?;
    let mut text = EncoderWriter::new(&mut *out, &BASE64_STANDARD);
    // JSON is written in tiny pieces, which are slow to compress one by one.
    let mut gzip = BufWriter::new(GzEncoder::new(&mut text, Compression::best()));
    write(&mut gzip)?;
    gzip.into_inner().map_err(IntoInnerError::into_error)?.finish()?;
    text.finish()?;
    drop(text);
    writeln!(out, "</script>")
}

/// Returns the responses of the server by path, except those that depend on a state. Known walls are
/// those of the last state.
fn responses(source: &StateSource, vehicles: &Vehicles, cancel: &CancelToken) -> ApiResult<Value> {
    let (run, _, states) = source.current_run()?;
    let path = |resource: &str| format!("/api/sources/{ID}{resource}");
    let size = source.describe(run)?.size;
    let mut responses = vec![
        ("/api/page".to_string(), json(&PageInfo::exported(ID, vehicles))?.to_string()),
        ("/drawing.json".into(), page_json()),
        (path(""), json(&SourceInfo::new(ID.into(), source, vehicles, None)?)?.to_string()),
        (path("/drawing.svg"), pictures::page_svg(source, run)?),
        (path("/costs"), json(&source.bounds(run, cancel)?)?.to_string()),
        (path("/events"), json(&source.events(run, cancel)?)?.to_string()),
        (path("/result"), json(&source.result(run, vehicles.selected(size), cancel)?)?.to_string()),
    ];
    let description = source.describe(run)?;
    for vehicle in &vehicles.all {
        cancel.check()?;
        if let Some(maze) = &description.truth {
            let runs = json(&fast_runs::in_maze(maze, vehicle))?.to_string();
            responses.push((path(&format!("/fast-runs/{}", vehicle.name())), runs));
        }
        if let Some(last) = states.checked_sub(1) {
            let runs = json(&fast_runs::of_mouse(source, run, last, vehicle, cancel)?)?;
            let path = path(&format!("/mouse-fast-runs/{}", vehicle.name()));
            responses.push((path, runs.to_string()));
        }
    }
    Ok(responses.into_iter().collect())
}

/// Writes the log lines, reading those of one block of states at a time.
fn write_log(source: &StateSource, cancel: &CancelToken, out: &mut dyn Write) -> io::Result<()> {
    let (run, _, states) = source.current_run()?;
    let mut log = Serializer::new(out);
    let mut log = log.serialize_seq(None)?;
    for first in (0..states).step_by(Block::STATES) {
        let end = first + Block::STATES;
        // The lines after the last state belong to the number of states.
        let range = first..=if end < states { end - 1 } else { states };
        let is_own = |line: &str| !EndFacts::is_log_line(line);
        for line in source.log(run, &range, LogEnd::First, usize::MAX, cancel, is_own)? {
            log.serialize_element(&(line.state, line.text))?;
        }
    }
    Ok(log.end()?)
}

/// Returns the title of the document: the names of the recording, the maze and the mouse.
fn title(source: &StateSource) -> ApiResult<String> {
    let (run, description, states) = source.current_run()?;
    let context = source.last_context(run, states);
    let mouse = context.as_ref().and_then(|context| context.notes().mouse());
    let mouse = mouse.map(|mouse| format!(", {mouse}")).unwrap_or_default();
    Ok(format!("{}: {}{mouse} – mmsim", description.title, description.info.maze))
}

fn json(value: &impl serde::Serialize) -> ApiResult<Value> {
    serde_json::to_value(value).map_err(ApiError::internal)
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::Cursor;
    use std::ops::ControlFlow;
    use std::sync::LazyLock;

    use base64::Engine as _;
    use flate2::read::GzDecoder;
    use mmsim_client::{InMemory, search_run};
    use mmsim_maze::{KnownMaze, Maze};
    use mmsim_recording::save;
    use mmsim_server::Simulation;
    use mmsim_solvers::{Mouse, ShortestPathSearch};

    use super::*;

    /// The maximum size of a page without the states, in bytes.
    const MAX_PAGE_BYTES: usize = 400_000;

    /// The maximum size of a state of a 32x32 maze, in bytes.
    const MAX_STATE_BYTES: usize = 200;

    /// A request that writes a log line.
    const LOG: &[u8] = b"AL\x0d\0<!--</script>";

    /// A recording of a search.
    static RECORDED: LazyLock<Vec<u8>> = LazyLock::new(record);

    /// The page of the recording, and the reported progress.
    static PAGE: LazyLock<(String, Vec<usize>)> = LazyLock::new(|| {
        let (mut page, mut progress) = (Vec::new(), Vec::new());
        export_html("run.mcap", recording(), &Vehicles::default(), &mut page, |states| {
            progress.push(states);
        })
        .unwrap();
        (String::from_utf8(page).unwrap(), progress)
    });

    pub(crate) fn recording() -> Recording {
        Recording::read(&RECORDED[..]).unwrap()
    }

    /// Records a search of several blocks of states, which writes a log line before each 100th state.
    fn record() -> Vec<u8> {
        let maze: Maze = mmsim_mazes::OLD_QUARTER.parse().unwrap();
        let mut simulation = Simulation::new("old quarter", maze.clone());
        let mut transport = InMemory::new(|request: &[u8], reply: &mut Vec<u8>| {
            if request[0] == b'S' && simulation.history().len().is_multiple_of(100) {
                simulation.handle(LOG, &mut Vec::new());
            }
            simulation.handle(request, reply)
        });
        let strategy = ShortestPathSearch::new();
        let mut mouse = Mouse::new(strategy, KnownMaze::unexplored(&maze), maze.start());
        search_run(&mut transport, &mut mouse, 10_000, |_, _| ControlFlow::Continue(())).unwrap();
        let history = simulation.history();
        let blocks = (0..history.len()).step_by(Block::STATES);
        let blocks = blocks.map(|first| history.block(first / Block::STATES).unwrap().unpack());
        let states = blocks.map(Option::unwrap).zip(0..).flat_map(|(states, block)| {
            let first = block * Block::STATES;
            (first..first + states.len()).map(move |index| {
                (
                    index as u64,
                    states.update(index).unwrap().to_vec(),
                    states.get(index).unwrap().to_vec(),
                )
            })
        });
        let mut file = Cursor::new(Vec::new());
        save(&mut file, &simulation.info(), Some(&maze), states, &simulation.trailing()).unwrap();
        file.into_inner()
    }

    /// Returns the data of an exported page with this name.
    fn embedded(page: &str, name: &str) -> Vec<Value> {
        let start = format!("data-embedded=\"{name}\">");
        let elements = page.split(&start).skip(1).map(|rest| rest.split_once('<').unwrap().0);
        let decode = |element| {
            let compressed = BASE64_STANDARD.decode(element).unwrap();
            serde_json::from_reader(GzDecoder::new(&compressed[..])).unwrap()
        };
        elements.map(decode).collect()
    }

    /// Applies a change, as `patch` in `embedded.js` does.
    pub(super) fn patch(old: &Value, change: &Value) -> Value {
        match change {
            Value::Object(changes) => changes.get("=").cloned().unwrap_or_else(|| {
                let mut object = old.as_object().unwrap().clone();
                for (key, change) in changes {
                    let old = object.get(key).unwrap_or(&Value::Null);
                    object.insert(key.clone(), patch(old, change));
                }
                Value::Object(object)
            }),
            Value::Array(splices) => {
                let mut array = old.as_array().unwrap().clone();
                for splice in splices {
                    let splice = splice.as_array().unwrap();
                    let [index, count] =
                        [0, 1].map(|i| usize::try_from(splice[i].as_u64().unwrap()).unwrap());
                    array.splice(index..index + count, splice[2..].iter().cloned());
                }
                Value::Array(array)
            }
            _ => change.clone(),
        }
    }

    #[test]
    fn a_page_contains_everything_about_each_state() {
        let (page, progress) = &*PAGE;
        let source = StateSource::recording("run.mcap", recording());
        let states = source.states(0).unwrap();
        assert!(states > 3 * Block::STATES, "{states}");
        assert_eq!(progress, &[256, 512, 768, states]);
        let (mut index, mut planner) = (0, Planner::new(Vehicle::kerise()));
        for block in embedded(page, "states") {
            let mut view = Value::Null;
            for change in block.as_array().unwrap() {
                view = patch(&view, change);
                let expected = StateView::new(&source, 0, index, &mut planner).unwrap();
                assert_eq!(view, json(&expected).unwrap());
                index += 1;
            }
        }
        assert_eq!(index, states);
        let lines = embedded(page, "log").remove(0);
        assert_eq!(lines.as_array().unwrap().len(), states.div_ceil(100));
        assert_eq!(lines[1], json!([100, "<!--</script>"]));
        let responses = embedded(page, "responses").remove(0);
        let info: Value =
            serde_json::from_str(responses["/api/sources/1"].as_str().unwrap()).unwrap();
        assert_eq!((&info["states"], &info["maze"]), (&json!(states), &json!("old quarter")));
        let page_info: Value =
            serde_json::from_str(responses["/api/page"].as_str().unwrap()).unwrap();
        assert_eq!(page_info["opened"], json!(["1"]));
        assert_eq!(page_info["vehicles"], json!(["kerise"]), "that of the times");
        assert!(page.contains("<title>run.mcap: old quarter – mmsim</title>"));
    }

    #[test]
    fn a_page_is_small() {
        let page = &PAGE.0;
        let states = page.lines().filter(|line| line.contains("data-embedded=\"states\""));
        let bytes: usize = states.map(str::len).sum();
        assert!(page.len() - bytes <= MAX_PAGE_BYTES, "{} bytes", page.len() - bytes);
        let count = recording().history().len();
        assert!(bytes <= MAX_STATE_BYTES * count, "{bytes} bytes for {count} states");
    }

    #[test]
    fn a_recording_without_states_is_exported() {
        let maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let (simulation, mut file) = (Simulation::new("small", maze), Cursor::new(Vec::new()));
        save(&mut file, &simulation.info(), None, [(0, "", ""); 0], &simulation.trailing())
            .unwrap();
        let (recording, mut page) = (Recording::read(&file.get_ref()[..]).unwrap(), Vec::new());
        export_html("empty.mcap", recording, &Vehicles::default(), &mut page, |_| ()).unwrap();
        let page = String::from_utf8(page).unwrap();
        assert_eq!(embedded(&page, "log"), [json!([])]);
        assert!(embedded(&page, "states").is_empty() && page.contains("<title>empty.mcap: small"));
    }

    #[test]
    fn a_cancelled_export_ends() {
        let source = StateSource::recording("run.mcap", recording());
        let (vehicle, cancel) = (Vehicle::expert(), CancelToken::cancelled());
        let error =
            write(&source, vehicle, Content::Page, io::sink(), &cancel, |_| ()).unwrap_err();
        assert_eq!(error.to_string(), "request cancelled");
    }
}
