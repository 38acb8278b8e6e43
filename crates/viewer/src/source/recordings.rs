//! Lists, opens, receives, saves, renames and deletes recordings.

use std::fmt::Display;
use std::fs;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::Json;
use axum::body::Body;
use axum::extract::{Extension, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use mmsim_recording::{
    Block, Recording, TrailingAnnotations, is_being_written, save as save_recording,
};
use serde::{Deserialize, Serialize};

use crate::app::{AppState, SharedState, title};
use crate::http::jobs::{ApiError, ApiResult, CancelToken, run_blocking};
use crate::http::limits::{MAX_RECORDING_BYTES, receive_body};
use crate::http::shares::Connection;
use crate::source::StateSource;
use crate::source::views::RecordingSummary;

/// The maximum number of listed recordings.
const MAX_LISTED: usize = 500;

/// The maximum size of a recording whose result the page lists, in bytes. It contains at least 100,000
/// states.
const MAX_SUMMARIZED_BYTES: u64 = 8 << 20;

/// The maximum length of a name that a user gives to a recording, in bytes. File systems allow file
/// names of up to 255 bytes.
const MAX_NAME_BYTES: usize = 200;

/// An entry in the page's list of recordings.
#[derive(Debug, Serialize)]
pub(crate) struct RecordingEntry {
    name: String,
    bytes: u64,
    /// The time of the last modification, in UTC.
    modified: Option<Timestamp>,
    /// True if the recording is still being written.
    #[serde(rename = "being_written")]
    is_being_written: bool,
}

/// Lists the newest recordings in a folder, newest first.
fn list(folder: &Path) -> ApiResult<Vec<RecordingEntry>> {
    let failed = |error| ApiError::internal(format!("cannot read the recordings: {error}"));
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let Ok(entry) = entry else { continue };
        let is_recording = entry.path().extension().is_some_and(|extension| extension == "mcap");
        let Ok(name) = entry.file_name().into_string() else { continue };
        let Ok(metadata) = entry.metadata() else { continue };
        if metadata.is_file() && is_recording {
            let modified = metadata.modified().ok().and_then(|time| time.try_into().ok());
            let bytes = metadata.len();
            entries.push(RecordingEntry { name, bytes, modified, is_being_written: false });
        }
    }
    entries.sort_by(|a, b| (b.modified, &b.name).cmp(&(a.modified, &a.name)));
    entries.truncate(MAX_LISTED);
    for entry in &mut entries {
        entry.is_being_written = is_being_written(&folder.join(&entry.name));
    }
    Ok(entries)
}

/// Returns the path of a listed recording. Only listed names are accepted, so a name cannot refer
/// to a file outside the folder.
fn find(folder: Option<&Path>, name: &str) -> ApiResult<PathBuf> {
    let not_found = || ApiError::not_found(format!("no listed recording has the name {name:?}"));
    let folder = folder.ok_or_else(not_found)?;
    let is_listed = list(folder)?.iter().any(|entry| entry.name == name);
    if is_listed { Ok(folder.join(name)) } else { Err(not_found()) }
}

/// Returns the file name for a name that a user has typed, with or without `.mcap`. It is valid on any
/// file system, and names no hidden file, other folder or device.
fn file_name(typed: &str) -> ApiResult<String> {
    let name = typed.trim();
    let stem = name.strip_suffix(".mcap").unwrap_or(name);
    let is_plain = |c: char| c.is_alphanumeric() || " -_.,()".contains(c);
    let first = stem.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let is_device = ["CON", "PRN", "AUX", "NUL"].contains(&&first[..])
        || (first.chars().count() == 4 && (first.starts_with("COM") || first.starts_with("LPT")));
    if first.is_empty() || is_device || stem.len() > MAX_NAME_BYTES || !stem.chars().all(is_plain) {
        let text = format!(
            "cannot name a recording {name:?} (use up to {MAX_NAME_BYTES} letters, digits, spaces and \
             - _ . , ( ), beginning with none of these)"
        );
        return Err(ApiError::bad_request(text));
    }
    Ok(format!("{stem}.mcap"))
}

/// Renames a file unless another file has the new name.
fn rename(from: &Path, to: &Path) -> io::Result<()> {
    // Renaming would replace another file.
    fs::File::create_new(to)?;
    fs::rename(from, to).inspect_err(|_| drop(fs::remove_file(to)))
}

/// Saves a run to a temporary file and rewinds the file.
pub(crate) fn save(source: &StateSource, run: u32, cancel: &CancelToken) -> ApiResult<fs::File> {
    let failed =
        |error: io::Error| ApiError::internal(format!("cannot save the recording: {error}"));
    let (description, times) = (source.describe(run)?, source.times(run)?);
    let mut file = tempfile::tempfile().map_err(failed)?;
    // If the run ends in the meantime, nothing is saved.
    let mut failure = None;
    let read_block = |first: usize| {
        cancel.check()?;
        let states = source.read_block(run, first)?;
        let messages = (first..first + states.len()).filter_map(|index| {
            Some((states.update(index)?.to_vec(), states.get(index)?.to_vec()))
        });
        Ok::<Vec<_>, ApiError>(messages.collect())
    };
    let firsts = (0..times.len()).step_by(Block::STATES);
    let blocks =
        firsts.map_while(|first| read_block(first).map_err(|error| failure = Some(error)).ok());
    let states =
        times.iter().zip(blocks.flatten()).map(|(time, (update, state))| (time, update, state));
    let (writer, truth) = (io::BufWriter::new(&mut file), description.truth.as_ref());
    let trailing = match times.len().checked_sub(1) {
        Some(last) => source.trailing(run, last)?,
        None => TrailingAnnotations::default(),
    };
    save_recording(writer, &description.info, truth, states, &trailing).map_err(failed)?;
    if let Some(error) = failure {
        return Err(error);
    }
    file.rewind().map_err(failed)?;
    Ok(file)
}

pub(crate) async fn list_recordings(State(state): SharedState) -> ApiResult<Response> {
    run_blocking(move || {
        let folder = state.config.recordings_dir.as_deref();
        let entries = folder.map(list).transpose()?.unwrap_or_default();
        Ok(Json(entries).into_response())
    })
    .await
}

#[derive(Deserialize)]
pub(crate) struct RecordingName {
    name: String,
}

#[derive(Deserialize, Serialize)]
pub(crate) struct RecordingId {
    id: String,
}

pub(crate) async fn open_recording(
    State(state): SharedState,
    Extension(connection): Extension<Arc<Connection>>,
    Json(RecordingName { name }): Json<RecordingName>,
) -> ApiResult<Json<RecordingId>> {
    Arc::clone(&state)
        .recording_jobs
        .run_for(Some(connection.network), move |cancel| {
            state.recordings().check_capacity()?;
            let path = find(state.config.recordings_dir.as_deref(), &name)?;
            let failed = |error: &dyn Display| ApiError::bad_request(format!("{name}: {error}"));
            let file = fs::File::open(&path).map_err(|error| failed(&error))?;
            let recording = Recording::read_within(cancel.reader(file), &state.config.budget)
                .map_err(|error| failed(&error))?;
            Ok(Json(RecordingId { id: state.open(&name, recording)? }))
        })
        .await
}

pub(crate) async fn close_recording(
    State(state): SharedState,
    Json(RecordingId { id }): Json<RecordingId>,
) -> ApiResult<StatusCode> {
    state.close(&id)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Returns the summary of a listed recording, or `None` if reading the recording would take long.
pub(crate) async fn summarize_recording(
    State(state): SharedState,
    Extension(connection): Extension<Arc<Connection>>,
    Query(RecordingName { name }): Query<RecordingName>,
) -> ApiResult<Json<Option<RecordingSummary>>> {
    Arc::clone(&state)
        .recording_jobs
        .run_for(Some(connection.network), move |cancel| {
            let path = find(state.config.recordings_dir.as_deref(), &name)?;
            let file = fs::File::open(&path).map_err(ApiError::internal)?;
            if file.metadata().is_ok_and(|metadata| metadata.len() > MAX_SUMMARIZED_BYTES) {
                return Ok(Json(None));
            }
            let recording = Recording::read_within(cancel.reader(file), &state.config.budget);
            Ok(Json(Some(RecordingSummary::new(recording)?)))
        })
        .await
}

/// Changes the file of a listed recording, unless the recording is being written.
async fn change_file(
    state: Arc<AppState>,
    name: String,
    change: impl FnOnce(&Path) -> ApiResult<()> + Send + 'static,
) -> ApiResult<StatusCode> {
    run_blocking(move || {
        let path = find(state.config.recordings_dir.as_deref(), &name)?;
        if is_being_written(&path) {
            let text = format!("{name} is still being recorded (try again after the next reset)");
            return Err(ApiError::conflict(text));
        }
        change(&path)?;
        state.recording_changes.fetch_add(1, Ordering::Relaxed);
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

pub(crate) async fn delete_recording(
    State(state): SharedState,
    Json(RecordingName { name }): Json<RecordingName>,
) -> ApiResult<StatusCode> {
    let failed = |error| ApiError::conflict(format!("cannot delete the recording: {error}"));
    change_file(state, name, move |path| fs::remove_file(path).map_err(failed)).await
}

#[derive(Deserialize)]
pub(crate) struct NewName {
    name: String,
    to: String,
}

pub(crate) async fn rename_recording(
    State(state): SharedState,
    Json(NewName { name, to }): Json<NewName>,
) -> ApiResult<StatusCode> {
    let to = file_name(&to)?;
    change_file(state, name, move |path| {
        rename(path, &path.with_file_name(&to)).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                ApiError::conflict(format!("{to} already exists (choose another name)"))
            }
            _ => ApiError::conflict(format!("cannot rename the recording: {error}")),
        })
    })
    .await
}

/// Receives an uploaded recording and opens it.
pub(crate) async fn upload(
    State(state): SharedState,
    Extension(connection): Extension<Arc<Connection>>,
    Query(RecordingName { name }): Query<RecordingName>,
    body: Body,
) -> ApiResult<Json<RecordingId>> {
    state.recordings().check_capacity()?;
    let permit = state.uploads.acquire(Some(connection.network)).await?;
    // The file has no name, so the system deletes it even if the process is killed.
    let mut file = tempfile::tempfile().map_err(ApiError::internal)?;
    receive_body(body, MAX_RECORDING_BYTES, state.limits, |chunk| file.write_all(&chunk)).await?;
    Arc::clone(&state)
        .recording_jobs
        .run_for(Some(connection.network), move |cancel| {
            let _permit = permit;
            file.rewind().map_err(ApiError::internal)?;
            let file = cancel.reader(io::BufReader::new(file));
            let title = title(&name);
            let recording = Recording::read_within(file, &state.config.budget)
                .map_err(|error| ApiError::bad_request(format!("{title}: {error}")))?;
            Ok(Json(RecordingId { id: state.open(&title, recording)? }))
        })
        .await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_recordings_in_the_folder_are_found() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for name in ["a.mcap", "b.mcap", "notes.txt"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        fs::create_dir(folder.path().join("folder.mcap")).unwrap();
        fs::write(elsewhere.path().join("c.mcap"), "").unwrap();
        let mut names: Vec<_> =
            list(folder.path()).unwrap().into_iter().map(|entry| entry.name).collect();
        names.sort();
        assert_eq!(names, ["a.mcap", "b.mcap"]);
        assert!(find(Some(folder.path()), "a.mcap").is_ok());
        let outside = elsewhere.path().join("c.mcap").display().to_string();
        for name in ["", "c.mcap", "notes.txt", "./a.mcap", "../a.mcap", "folder.mcap", &outside] {
            assert!(find(Some(folder.path()), name).is_err(), "{name}");
        }
        assert!(find(None, "a.mcap").is_err());
    }

    #[test]
    fn names_stay_in_the_folder_and_replace_no_file() {
        assert_eq!(file_name(" my run (2), 3.4_é ").unwrap(), "my run (2), 3.4_é.mcap");
        assert_eq!(file_name("a.mcap").unwrap(), "a.mcap");
        let long = "x".repeat(MAX_NAME_BYTES + 1);
        for name in [
            "", " ", ".mcap", ".a", "..", "../a", "a/b", "a\\b", "/a", "C:a", "a\nb", "a\0", "a*",
            "NUL", "con.a", "Com1", &long,
        ] {
            assert_eq!(file_name(name).unwrap_err().status, StatusCode::BAD_REQUEST, "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        let [a, b, c] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| folder.path().join(name));
        fs::write(&a, "a").unwrap();
        fs::write(&b, "b").unwrap();
        assert_eq!(rename(&a, &b).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert!(rename(&c, &folder.path().join("d.mcap")).is_err(), "nothing to rename");
        rename(&a, &c).unwrap();
        let names = |path: &Path| list(path).unwrap().into_iter().map(|entry| entry.name);
        let mut names: Vec<_> = names(folder.path()).collect();
        names.sort();
        assert_eq!(names, ["b.mcap", "c.mcap"]);
        assert_eq!([b, c].map(|path| fs::read_to_string(path).unwrap()), ["b", "a"]);
    }
}
