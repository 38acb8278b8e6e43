//! Recordings: those of the folder in which the server records, and those that a page brings.

use std::fs;
use std::io::{self, Seek};
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use mmsim_recording::{Block, Recording, save as save_recording};
use serde::Serialize;

use crate::api_error::ApiError;
use crate::source::Source;
use crate::state::AppState;
use crate::work::CancelToken;

/// How many recordings are listed at most, the newest.
const MAX_LISTED: usize = 500;

/// A recording of the folder.
#[derive(Debug, Serialize)]
pub(crate) struct Listed {
    name: String,
    bytes: u64,
    /// When it was last written, in UTC.
    modified: Option<Timestamp>,
}

/// The recordings in a folder, newest first.
pub(crate) fn list(folder: &Path) -> Result<Vec<Listed>, ApiError> {
    let failed = |error| ApiError::failed(format!("{}: cannot be read: {error}", folder.display()));
    let mut listed = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let Ok(entry) = entry else { continue };
        let is_recording = entry.path().extension().is_some_and(|ending| ending == "mcap");
        let Ok(name) = entry.file_name().into_string() else { continue };
        let Ok(metadata) = entry.metadata() else { continue };
        if metadata.is_file() && is_recording {
            let modified = metadata.modified().ok().and_then(|time| time.try_into().ok());
            listed.push(Listed { name, bytes: metadata.len(), modified });
        }
    }
    listed.sort_by(|a, b| (b.modified, &b.name).cmp(&(a.modified, &a.name)));
    listed.truncate(MAX_LISTED);
    Ok(listed)
}

/// Opens a recording of the folder; gives its number.
pub(crate) fn open_listed(state: &AppState, name: &str) -> Result<String, ApiError> {
    state.check_room()?;
    let path = find(state.recordings.as_deref(), name)?;
    let recording = Recording::open_within(&path, &state.budget).map_err(ApiError::bad)?;
    state.open(name, recording)
}

/// The file of this name, which leads nowhere else.
fn find(folder: Option<&Path>, name: &str) -> Result<PathBuf, ApiError> {
    let wrong = || ApiError::not_found(format!("expected a recording of the list, found {name:?}"));
    let folder = folder.ok_or_else(wrong)?;
    let is_listed = list(folder)?.iter().any(|listed| listed.name == name);
    if is_listed { Ok(folder.join(name)) } else { Err(wrong()) }
}

/// Writes a run into a file of its own, which is read from its beginning.
pub(crate) fn save(source: &Source, run: u32, wanted: &CancelToken) -> Result<fs::File, ApiError> {
    let failed = |error: io::Error| ApiError::failed(format!("cannot save: {error}"));
    let (described, times) = (source.describe(run)?, source.times(run)?);
    let mut file = tempfile::tempfile().map_err(failed)?;
    // A run that ends meanwhile is not saved at all, rather than in part.
    let mut broken = None;
    let states = (0..times.len()).step_by(Block::STATES).map_while(|first| {
        let states = wanted.check().and_then(|()| source.read(run, first));
        states.map_err(|refusal| broken = Some(refusal)).ok().map(|states| (first, states))
    });
    let states = states.flat_map(|(first, states)| {
        let messages =
            (first..first + states.len()).map_while(|index| states.get(index).map(Vec::from));
        messages.collect::<Vec<_>>()
    });
    let states = times.iter().zip(states);
    save_recording(
        io::BufWriter::new(&mut file),
        &described.info,
        described.truth.as_ref(),
        states,
    )
    .map_err(failed)?;
    if let Some(refusal) = broken {
        return Err(refusal);
    }
    file.rewind().map_err(failed)?;
    Ok(file)
}

/// The name of a recording that a page brings, fit to be shown.
pub(crate) fn title(name: &str) -> String {
    let title: String = name.chars().filter(|c| !c.is_control()).take(100).collect();
    if title.is_empty() { "recording".into() } else { title }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_recordings_of_the_folder_are_found() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for name in ["a.mcap", "b.mcap", "notes.txt"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        fs::create_dir(folder.path().join("folder.mcap")).unwrap();
        fs::write(elsewhere.path().join("c.mcap"), "").unwrap();
        let mut names: Vec<_> =
            list(folder.path()).unwrap().into_iter().map(|listed| listed.name).collect();
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
    fn titles_are_short_and_of_one_line() {
        assert_eq!(title("a\nb\u{1b}[2J.mcap"), "ab[2J.mcap");
        assert_eq!(title(&"x".repeat(1000)).len(), 100);
        assert_eq!(title("\n"), "recording");
    }
}
