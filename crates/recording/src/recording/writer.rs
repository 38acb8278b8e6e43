//! Writes a recording, one state at a time.

use std::path::{Path, PathBuf};
use std::{fs, io};

use bytesize::ByteSize;
use mmsim_maze::Maze;
use mmsim_protocol::Info;
use tracing::debug;

use crate::history::times::Clock;
use crate::recording::format::RecordError;
use crate::recording::pack::{Packing, Unpacked, remove_unfinished};
use crate::recording::save::{NewMessages, RecordWriter};
use crate::recording::sink::{Identity, RecordingFile, Sink};

/// The maximum default limit on the size of a recording, in bytes.
const MAX_DEFAULT_LIMIT: u64 = 4 << 30;

/// Returns the folder of the file at `path`.
fn folder(path: &Path) -> &Path {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new("."))
}

/// Returns the default limit on the size of a recording in bytes: a tenth of the `free` bytes of the
/// disk, at most `MAX_DEFAULT_LIMIT`, or this maximum if the free space is unknown.
fn default_limit(free: Option<u64>) -> u64 {
    free.map_or(MAX_DEFAULT_LIMIT, |free| MAX_DEFAULT_LIMIT.min(free / 10))
}

/// Writes a recording.
///
/// Each state is handed to the operating system before [`write`](Self::write) returns. A written
/// state therefore survives if the process is killed, even by `kill -9`, but a power failure may
/// destroy it.
///
/// Dropping the writer closes the recording. [`close`](Self::close) also compresses the recording
/// and reports errors. A recording that was never closed is readable too.
pub struct RecordingWriter {
    path: PathBuf,
    identity: Identity,
    clock: Clock,
    /// `None` once closed.
    records: Option<RecordWriter<Sink<RecordingFile>>>,
    /// True if a state could not be written. In this case, the file gets no summary, because the
    /// counts in the summary would be wrong.
    has_failed: bool,
    messages: Option<NewMessages>,
    /// The maximum size of the file without its summary, in bytes.
    limit: u64,
}

impl RecordingWriter {
    /// Creates the file of a recording. `info` describes the simulation, and `maze` is its true
    /// maze, if known.
    ///
    /// # Errors
    /// The file already exists, or it cannot be created or written.
    pub fn create(path: &Path, info: &Info, maze: Option<&Maze>) -> Result<Self, RecordError> {
        let failed = |error| RecordError::new(path, error);
        let file = RecordingFile::create(path).map_err(failed)?;
        let (identity, clock) = (file.identity, Clock::start());
        // A chunk of compressed records would stay in memory until it is full.
        let started = RecordWriter::new(Sink::new(file), false, info, maze, clock.now(), None);
        let flushed = started.and_then(|mut records| {
            // If a later write failed, a channel that it had added would be lost.
            records.add_channels()?;
            records.flush()?;
            Ok(records)
        });
        let records = flushed.map_err(|error| {
            let _ = fs::remove_file(path);
            failed(error)
        })?;
        let limit = default_limit(fs4::available_space(folder(path)).ok());
        let (path, records) = (path.into(), Some(records));
        Ok(Self { path, identity, clock, records, has_failed: false, messages: None, limit })
    }

    /// Sets the messages for other tools that the recording gets when it is compressed. By default, it
    /// contains only the states.
    #[must_use]
    pub fn with_messages(mut self, messages: Option<NewMessages>) -> Self {
        self.messages = messages;
        self
    }

    /// Limits the size of the file to this number of bytes, without its summary. By default, or for
    /// `None`, the limit is a tenth of the disk space that was free when the file was created, at most
    /// 4 GiB.
    #[must_use]
    pub fn with_limit(mut self, bytes: Option<u64>) -> Self {
        self.limit = bytes.unwrap_or(self.limit);
        self
    }

    /// Appends the bytes of a state with an empty update.
    ///
    /// # Errors
    /// See [`write_with_update`](Self::write_with_update).
    pub fn write(&mut self, state: &[u8]) -> Result<(), RecordError> {
        self.write_with_update(&[], state)
    }

    /// Appends the bytes of an update (see [`History::newest_update`](crate::History)) and of the
    /// state that follows, with the current time.
    ///
    /// # Errors
    /// The file has reached its limit, it cannot be written, or another program has removed or changed it. A state that could
    /// not be written leaves no trace in the file. Later writes may succeed.
    pub fn write_with_update(&mut self, update: &[u8], state: &[u8]) -> Result<(), RecordError> {
        let Some(records) = &mut self.records else { return Ok(()) };
        let sequence = records.states;
        if !records.fits(update, state, self.limit) {
            let limit = ByteSize(self.limit);
            let error = io::Error::new(
                io::ErrorKind::FileTooLarge,
                format!(
                    "limit of {limit} reached after {sequence} states (reset starts a new recording; \
                     --record-limit changes the limit)"
                ),
            );
            return Err(RecordError::new(&self.path, error));
        }
        let written = records.write(self.clock.now(), update, state).and_then(|()| records.flush());
        written.map_err(|error| {
            (self.has_failed, records.states) = (true, sequence);
            RecordError::new(&self.path, error)
        })
    }

    /// Appends an accepted request `A` with the current time, so that its annotations are in the file
    /// even if no state follows.
    ///
    /// # Errors
    /// See [`write_with_update`](Self::write_with_update).
    pub fn write_annotations(&mut self, request: &[u8]) -> Result<(), RecordError> {
        let Some(records) = &mut self.records else { return Ok(()) };
        let written = records.write_annotations(self.clock.now(), request);
        written.and_then(|()| records.flush()).map_err(|error| {
            self.has_failed = true;
            RecordError::new(&self.path, error)
        })
    }

    /// Closes the recording with a summary and compresses it. Compression takes about 4 µs for each
    /// state, and more with messages for other tools. If compression fails, the file stays uncompressed.
    /// Also removes the temporary files that killed processes left in the folder.
    ///
    /// # Errors
    /// The summary at the end of the file cannot be written. All states remain readable.
    pub fn close(self) -> Result<(), RecordError> {
        let (unpacked, closed) = self.close_unpacked();
        if let Err(error) = remove_unfinished(folder(&unpacked.path)) {
            debug!("cannot remove temporary files: {error}");
        }
        if let Err(error) = unpacked.pack(&Packing::default()) {
            debug!("cannot compress a recording: {error}");
        }
        closed
    }

    /// Closes the recording without compressing it.
    pub(crate) fn close_unpacked(mut self) -> (Unpacked, Result<(), RecordError>) {
        let states = self.records.as_ref().map_or(0, |records| records.states);
        let closed = self.finish().map_err(|error| RecordError::new(&self.path, error));
        let (path, identity, messages) = (self.path.clone(), self.identity, self.messages);
        (Unpacked { path, identity, states, messages }, closed)
    }

    fn finish(&mut self) -> io::Result<()> {
        let Some(records) = self.records.take() else { return Ok(()) };
        if self.has_failed {
            return Ok(());
        }
        records.finish()
    }
}

impl Drop for RecordingWriter {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}

#[cfg(test)]
mod tests {
    use mcap::records::Record;

    use super::*;
    use crate::recording::Recording;
    use crate::recording::reader::Integrity;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn state(number: u8) -> Vec<u8> {
        [b"S\x00\x00NC\x01".to_vec(), vec![number], b"C\x0d\x00".to_vec()].concat()
    }

    #[test]
    fn a_full_recording_refuses_states_and_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let (path, maze) = (folder.path().join("a.mcap"), MAZE.parse::<Maze>().unwrap());
        let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
        let writer = RecordingWriter::create(&path, &info, Some(&maze)).unwrap();
        let mut writer = writer.with_limit(Some(2000));
        let written: usize =
            (0..100).filter(|&number| writer.write(&state(number)).is_ok()).count();
        assert!((10..50).contains(&written), "{written} states");
        let length = fs::metadata(&path).unwrap().len();
        assert!((1900..=2000).contains(&length), "{length} bytes");
        let error = writer.write(&state(0)).unwrap_err().to_string();
        let reason = format!(
            ": limit of 2.0 KiB reached after {written} states (reset starts a new recording; \
             --record-limit changes the limit)"
        );
        assert!(error.ends_with(&reason), "{error}");
        writer.close().unwrap();
        let recording = Recording::open(&path).unwrap();
        assert_eq!(*recording.integrity(), Integrity::Closed);
        assert_eq!(recording.history().len(), written);
    }

    #[test]
    fn the_default_limit_is_a_tenth_of_the_free_space() {
        let limits = [Some(0), Some(1000), Some(u64::MAX), None].map(default_limit);
        assert_eq!(limits, [0, 100, MAX_DEFAULT_LIMIT, MAX_DEFAULT_LIMIT]);
        let (folder, maze) = (tempfile::tempdir().unwrap(), MAZE.parse::<Maze>().unwrap());
        let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
        let path = folder.path().join("a.mcap");
        let writer = RecordingWriter::create(&path, &info, Some(&maze)).unwrap();
        let free = fs4::available_space(folder.path()).unwrap();
        assert!(writer.limit <= default_limit(Some(free.saturating_add(1 << 30))));
    }

    #[test]
    fn the_names_in_the_first_update_are_metadata() {
        let folder = tempfile::tempdir().unwrap();
        let (path, maze) = (folder.path().join("a.mcap"), MAZE.parse::<Maze>().unwrap());
        let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
        let mut writer = RecordingWriter::create(&path, &info, Some(&maze)).unwrap();
        writer.write_with_update(b"NM\x07TheseusS\x05swing", &state(0)).unwrap();
        for number in 1..10 {
            writer.write_with_update(b"M\x05Other", &state(number)).unwrap();
        }
        let leftover = folder.path().join("old.mcapXyz123.packing");
        fs::write(&leftover, "").unwrap();
        writer.close().unwrap();
        assert!(!leftover.exists());
        let bytes = fs::read(&path).unwrap();
        let records = mcap::read::LinearReader::new(&bytes).unwrap().map(Result::unwrap);
        let names: Vec<_> = records
            .filter_map(|record| match record {
                Record::Metadata(metadata) if metadata.name == "mmsim-mouse" => {
                    Some(["mouse", "strategy"].map(|key| metadata.metadata[key].clone()))
                }
                _ => None,
            })
            .collect();
        assert_eq!(names, [["Theseus".to_string(), "swing".to_string()]]);
        let recording = Recording::read(&bytes[..]).unwrap();
        let names = [0, 9].map(|index| {
            let context = recording.history().context(index).unwrap();
            [context.notes().mouse(), context.notes().strategy()].map(|name| name.map(String::from))
        });
        let swing = || Some("swing".to_string());
        assert_eq!(names, [[Some("Theseus".into()), swing()], [Some("Other".into()), swing()]]);
        assert_eq!(*recording.integrity(), Integrity::Closed);
    }
}
