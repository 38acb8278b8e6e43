//! Reads a recording into memory.

pub(crate) mod format;
pub(crate) mod pack;
pub(crate) mod reader;
pub(crate) mod recorder;
pub(crate) mod save;
pub(crate) mod sink;
pub(crate) mod writer;

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, Write};
use std::path::Path;
use std::sync::Arc;

use mmsim_maze::Maze;
use mmsim_protocol::{Info, MazeSize};

use crate::context::Context;
use crate::context::update::TrailingAnnotations;
use crate::history::History;
use crate::history::block::{Block, States};
use crate::history::log::LogLine;
use crate::history::times::Times;
use crate::memory::{MemoryBudget, Share};
use crate::recording::format::{Description, OpenError, ReadError};
use crate::recording::reader::{Contents, IgnoredRecords, Integrity, RecordedState, read_states};
use crate::recording::save::{NewMessages, RecordWriter};

/// A recording that has been read into memory.
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
    history: History,
    times: Times,
    trailing: TrailingAnnotations,
    integrity: Integrity,
    ignored: IgnoredRecords,
    /// The part of the memory budget that the states and times use.
    _share: Share,
}

impl Recording {
    /// Reads a recording from a file, without a memory limit.
    ///
    /// # Errors
    /// The file cannot be read or is not a recording. A file that is truncated or damaged after its
    /// description is not an error; see [`integrity`](Self::integrity).
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        Self::open_within(path, &Arc::default())
    }

    /// Reads a recording from a file without exceeding the memory left in the budget.
    ///
    /// # Errors
    /// See [`open`](Self::open). Opening also fails if the states do not fit into the budget. A
    /// recording is never opened partially.
    pub fn open_within(path: &Path, budget: &Arc<MemoryBudget>) -> Result<Self, OpenError> {
        let file = File::open(path).and_then(|file| seekable(file, budget.limit() as u64));
        file.map_err(ReadError::Io)
            .and_then(|file| Self::read_within(file, budget))
            .map_err(|source| OpenError { path: path.into(), source })
    }

    /// Reads a recording from bytes, without a memory limit.
    ///
    /// # Errors
    /// See [`open`](Self::open).
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::read_within(Cursor::new(bytes), &Arc::default())
    }

    /// Reads a recording from the beginning of `source` without exceeding the memory left in the budget.
    ///
    /// # Errors
    /// See [`open_within`](Self::open_within).
    pub fn read_within(
        source: impl Read + Seek,
        budget: &Arc<MemoryBudget>,
    ) -> Result<Self, ReadError> {
        let (mut kept, mut share) = (None, Share::new(budget));
        let Contents { description, trailing, integrity, ignored } =
            read_states(source, |description, RecordedState { time, update, state }| {
                let (history, times) = kept.get_or_insert_with(|| empty(description));
                let states = history.len();
                // Nothing else can fail: the reader checked the length, and the history has no limit.
                history.push_recorded(update, state).map_err(|_| ReadError::OutOfMemory)?;
                times.push(time).map_err(|_| ReadError::OutOfMemory)?;
                if !share.grow_to(history.bytes() + times.bytes()) {
                    let (limit, others) = (budget.limit(), share.others());
                    return Err(ReadError::TooLarge { states, limit, others });
                }
                Ok(())
            })?;
        let (history, times) = kept.unwrap_or_else(|| empty(&description));
        let Description { mut info, size, maze } = description;
        info.states = history.len();
        Ok(Self { info, size, maze, history, times, trailing, integrity, ignored, _share: share })
    }

    /// Writes a compressed recording of the same states, with messages for other tools if `messages`
    /// is given.
    ///
    /// # Errors
    /// The recording cannot be written to `to`, or memory runs out.
    pub fn save(&self, to: impl Write, messages: Option<NewMessages>) -> io::Result<()> {
        let (info, maze, start) = (&self.info, self.maze(), self.times.get(0).unwrap_or(0));
        let mut writer = RecordWriter::new(to, true, info, maze, start, messages)?;
        let mut times = self.times.iter();
        for block in 0..self.history.len().div_ceil(Block::STATES) {
            let states = self.history.block(block).and_then(Block::unpack);
            let states = states.ok_or(io::ErrorKind::OutOfMemory)?;
            let first = block * Block::STATES;
            for (index, time) in (first..first + states.len()).zip(&mut times) {
                let message = states.update(index).zip(states.get(index));
                let (update, state) = message.ok_or(io::ErrorKind::InvalidData)?;
                writer.write(time, update, state)?;
            }
        }
        writer.write_trailing(&self.trailing)?;
        writer.finish()
    }

    /// Returns the simulation's reply to `info`. Its `states` field is the number of recorded
    /// states.
    pub const fn info(&self) -> &Info {
        &self.info
    }

    /// Returns the size of the maze.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// Returns the true maze, or `None` if the recording was made by a client.
    pub const fn maze(&self) -> Option<&Maze> {
        self.maze.as_ref()
    }

    /// Returns the states.
    pub const fn history(&self) -> &History {
        &self.history
    }

    /// Returns the time of each state.
    pub const fn times(&self) -> &Times {
        &self.times
    }

    /// Returns the annotations after the last state.
    pub const fn trailing(&self) -> &TrailingAnnotations {
        &self.trailing
    }

    /// Returns the context of a state in a block of this recording. That of the last state includes the
    /// annotations after it.
    pub fn context(&self, states: &States, index: usize) -> Option<Context> {
        let mut context = states.context(index)?;
        if index + 1 == self.history.len() {
            context.annotate(&self.trailing);
        }
        Some(context)
    }

    /// Returns the context at the end of the run, which includes the annotations after the last state.
    pub fn last_context(&self) -> Context {
        let mut context = self.history.newest_context();
        context.annotate(&self.trailing);
        context
    }

    /// Returns all log lines in order.
    pub fn log(&self) -> Vec<LogLine> {
        let mut lines = self.history.log(usize::MAX, usize::MAX, |_| true);
        lines.extend(self.trailing.log_lines(self.history.len()));
        lines
    }

    /// Returns the integrity of the file.
    pub const fn integrity(&self) -> &Integrity {
        &self.integrity
    }

    /// Returns the records of the file that do not belong to the recording.
    pub const fn ignored(&self) -> IgnoredRecords {
        self.ignored
    }
}

/// Returns the file itself, or a copy of up to `max` bytes if the file is a pipe.
fn seekable(mut file: File, max: u64) -> io::Result<File> {
    if file.stream_position().is_ok() {
        return Ok(file);
    }
    let mut copy = tempfile::tempfile()?;
    io::copy(&mut file.take(max), &mut copy)?;
    Ok(copy)
}

/// Returns the empty history and the times of a recording.
fn empty(description: &Description) -> (History, Times) {
    (History::new(description.size), Times::new(1))
}
