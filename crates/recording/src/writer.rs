//! Writes a recording, one state at a time.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::MessageHeader;
use mmsim_maze::Maze;
use mmsim_protocol::Info;
use tracing::debug;

use crate::clock::Clock;
use crate::error::RecordError;
use crate::pack::{Packing, Unpacked};
use crate::save::{describe, io_error, options, write_maze};
use crate::sink::{Identity, RecordingFile, Sink};

/// Writes a recording.
///
/// The operating system has each state before [`write`](Self::write) returns, so a state survives
/// the end of the process, even `kill -9`, but not a power failure.
///
/// Dropping the writer closes the recording; [`close`](Self::close) also compresses it and reports
/// errors. A recording that was never closed is readable too.
pub struct RecordingWriter {
    path: PathBuf,
    identity: Identity,
    /// `None` once closed.
    mcap: Option<mcap::Writer<Sink<RecordingFile>>>,
    channel_id: u16,
    clock: Clock,
    states: u32,
    /// Whether a state could not be written. The summary's counts would then be wrong, so none is
    /// written.
    has_failed: bool,
}

impl RecordingWriter {
    /// Creates a file for a recording of the simulation that `info` describes, with its true maze if
    /// known.
    ///
    /// # Errors
    /// The file exists, or cannot be created or written.
    pub fn create(path: &Path, info: &Info, maze: Option<&Maze>) -> Result<Self, RecordError> {
        let file = RecordingFile::create(path).map_err(|error| RecordError::new(path, error))?;
        Self::start(file, path, info, maze).map_err(|error| {
            let _ = fs::remove_file(path);
            RecordError::new(path, io_error(error))
        })
    }

    fn start(
        file: RecordingFile,
        path: &Path,
        info: &Info,
        maze: Option<&Maze>,
    ) -> Result<Self, McapError> {
        // A chunk would stay in memory until it is full.
        let options = options().use_chunks(false).compression(None);
        let identity = file.identity();
        let mut mcap = options.create(Sink::new(file))?;
        let (channel_id, clock) = (describe(&mut mcap, info)?, Clock::start());
        if let Some(maze) = maze {
            write_maze(&mut mcap, &maze.to_string(), clock.now())?;
        }
        mcap.flush()?;
        let (path, mcap) = (path.into(), Some(mcap));
        Ok(Self { path, identity, mcap, channel_id, clock, states: 0, has_failed: false })
    }

    /// Appends a state, the bytes of its message, with the current time.
    ///
    /// # Errors
    /// The file cannot be written, or another program removed or changed it. The file does not
    /// contain the state then. Later states may succeed again.
    pub fn write(&mut self, state: &[u8]) -> Result<(), RecordError> {
        let time = self.clock.now();
        let header = MessageHeader {
            channel_id: self.channel_id,
            sequence: self.states,
            log_time: time,
            publish_time: time,
        };
        let Some(mcap) = &mut self.mcap else { return Ok(()) };
        let written = mcap.write_to_known_channel(&header, state).and_then(|()| mcap.flush());
        self.has_failed |= written.is_err();
        written.map_err(|error| RecordError::new(&self.path, io_error(error)))?;
        self.states = self.states.wrapping_add(1);
        Ok(())
    }

    /// Closes the recording with a summary and compresses it, which takes about a second for a
    /// million states. If compression fails, the file stays uncompressed.
    ///
    /// # Errors
    /// The summary cannot be written. All states are readable nevertheless.
    pub fn close(self) -> Result<(), RecordError> {
        let (unpacked, closed) = self.close_unpacked();
        if let Err(error) = unpacked.pack(&Packing::default()) {
            debug!("a recording stays uncompressed: {error}");
        }
        closed
    }

    /// Closes the recording without compressing it.
    pub(crate) fn close_unpacked(mut self) -> (Unpacked, Result<(), RecordError>) {
        let closed = self.finish().map_err(|error| RecordError::new(&self.path, io_error(error)));
        let (path, identity) = (self.path.clone(), self.identity);
        (Unpacked { path, identity, states: self.states }, closed)
    }

    fn finish(&mut self) -> Result<(), McapError> {
        match self.mcap.take() {
            Some(mut mcap) if !self.has_failed => {
                mcap.finish()?;
                Ok(mcap.into_inner().flush()?)
            }
            // Dropping the MCAP writer would write the summary.
            Some(mcap) => {
                mcap.into_inner();
                Ok(())
            }
            None => Ok(()),
        }
    }
}

impl Drop for RecordingWriter {
    fn drop(&mut self) {
        let _ = self.finish();
    }
}
