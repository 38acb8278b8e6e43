//! A recording in memory.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use mmsim_maze::Maze;
use mmsim_protocol::{Info, MazeSize};

use crate::budget::{MemoryBudget, Share};
use crate::error::{OpenError, ReadError};
use crate::history::{History, PushError};
use crate::reader::{Description, Integrity, STEP_BYTES, read_states};
use crate::times::Times;

/// A recording, read into memory.
///
/// ```
/// use mmsim_maze::Maze;
/// use mmsim_protocol::Info;
/// use mmsim_recording::{Integrity, Recording, RecordingWriter};
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("small.mcap");
///
/// let mut writer = RecordingWriter::create(&path, &info, Some(&maze))?;
/// writer.write(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// writer.close()?;
///
/// let recording = Recording::open(&path)?;
/// assert_eq!(recording.maze(), Some(&maze));
/// assert_eq!(recording.history().len(), 1);
/// assert_eq!(*recording.integrity(), Integrity::Closed);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recording {
    info: Info,
    size: MazeSize,
    maze: Option<Maze>,
    states: RecordedStates,
    integrity: Integrity,
}

/// The states of a recording, their times, and the memory that both use.
#[derive(Debug)]
struct RecordedStates {
    history: History,
    times: Times,
    share: Share,
}

impl Recording {
    /// Reads a recording from a file, without a memory limit.
    ///
    /// # Errors
    /// The file cannot be read or is not a recording. A file that is truncated or damaged after its
    /// description is no error: see [`integrity`](Self::integrity).
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        Self::open_within(path, &Arc::default())
    }

    /// Reads a recording from a file, within the memory that the budget has left.
    ///
    /// # Errors
    /// As for [`open`](Self::open), or the states do not fit into the budget. A recording is never
    /// opened in part.
    pub fn open_within(path: &Path, budget: &Arc<MemoryBudget>) -> Result<Self, OpenError> {
        let file =
            File::open(path).map_err(|source| OpenError::Io { path: path.into(), source })?;
        let read = Self::read_within(BufReader::with_capacity(STEP_BYTES, file), budget);
        read.map_err(|error| match error {
            ReadError::Io(source) => OpenError::Io { path: path.into(), source },
            source => OpenError::Content { path: path.into(), source },
        })
    }

    /// Reads a recording from bytes, without a memory limit. Makes many small reads, so a file should
    /// be buffered.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn read(source: impl Read) -> Result<Self, ReadError> {
        Self::read_within(source, &Arc::default())
    }

    /// Reads a recording from bytes, within the memory that the budget has left. Makes many small
    /// reads, so a file should be buffered.
    ///
    /// # Errors
    /// As for [`open_within`](Self::open_within).
    pub fn read_within(source: impl Read, budget: &Arc<MemoryBudget>) -> Result<Self, ReadError> {
        let mut states = None;
        let (description, integrity) = read_states(source, |description, message, time| {
            states
                .get_or_insert_with(|| RecordedStates::new(description.size, budget))
                .push(message, time)
        })?;
        let Description { mut info, size, maze } = description;
        let states = states.unwrap_or_else(|| RecordedStates::new(size, budget));
        info.states = states.history.len();
        Ok(Self { info, size, maze, states, integrity })
    }

    /// Returns the simulation's reply to `info`, with the number of recorded states.
    pub const fn info(&self) -> &Info {
        &self.info
    }

    /// Returns the size of the maze.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// Returns the true maze, if the recorder knew it: a server does, a client does not.
    pub const fn maze(&self) -> Option<&Maze> {
        self.maze.as_ref()
    }

    /// Returns the states.
    pub const fn history(&self) -> &History {
        &self.states.history
    }

    /// Returns the time of each state.
    pub const fn times(&self) -> &Times {
        &self.states.times
    }

    /// Returns whether the file is complete.
    pub const fn integrity(&self) -> &Integrity {
        &self.integrity
    }
}

impl RecordedStates {
    fn new(size: MazeSize, budget: &Arc<MemoryBudget>) -> Self {
        let (history, times) = (History::new(size), Times::new(1));
        Self { history, times, share: Share::new(budget) }
    }

    /// Appends a state, recorded at `time` in nanoseconds since 1970 (UTC).
    fn push(&mut self, state: &[u8], time: u64) -> Result<(), ReadError> {
        let Self { history, times, share } = self;
        let states = history.len();
        history.push(state).map_err(|error| match error {
            PushError::OutOfMemory { .. } => ReadError::OutOfMemory,
            // Cannot happen: the reader checked the length, and this history has no limit.
            error => ReadError::InvalidDescription(error.to_string()),
        })?;
        times.push(time).map_err(|_| ReadError::OutOfMemory)?;
        if !share.grow_to(history.bytes() + times.bytes()) {
            let (limit, others) = (share.budget().limit(), share.others());
            return Err(ReadError::TooLarge { states, limit, others });
        }
        Ok(())
    }
}
