//! A recording: the states of one simulation, from reset to reset, in a file.
//!
//! The file is an [MCAP](https://mcap.dev) container, so that it survives a crash up to its last
//! state and opens in other tools. docs/recordings.md says what is in it.

mod chunk;
mod pack;
mod reader;
mod recorder;
mod save;
mod writer;

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mmsim_maze::Maze;
use mmsim_protocol::{Info, MazeSize};

use crate::budget::Share;
use crate::{History, MemoryBudget, PushError, Times};
use reader::{Description, STEP_BYTES, read_states};

pub use recorder::Recorder;
pub use save::save;
pub use writer::RecordingWriter;

/// The name of the metadata record that says what is recorded.
const METADATA: &str = "mmsim";

/// Its key under which the reply to `info` stands, as JSON.
const INFO: &str = "info";

/// Its key under which the version of the protocol stands by itself, for other tools.
const PROTOCOL: &str = "protocol";

/// Its key under which the true maze stands as text in recordings of earlier versions.
const MAZE: &str = "maze";

/// The topic of the channel of states, and the encoding of its messages: the protocol's own, as `S`
/// is sent.
const STATES: [&str; 2] = ["/state", "mmsim-state"];

/// The topic of the channel that has the true maze as its only message, and the encoding of that: a
/// drawing. A client does not know it. Metadata would not be packed.
const MAZES: [&str; 2] = ["/maze", "mmsim-maze"];

/// A recording, read from a file into memory.
///
/// ```
/// use mmsim_server::{Ending, Recording, RecordingWriter, Simulation};
/// let simulation = Simulation::new("small", "o---o---o\n| S   G |\no---o---o\n".parse()?);
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("small.mcap");
///
/// let mut writer = RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze()))?;
/// writer.write(b"S\x00\x00NC\x01\x00C\x0d\x00")?;
/// writer.close()?;
///
/// let recording = Recording::open(&path)?;
/// assert_eq!(recording.maze(), Some(simulation.maze()));
/// assert_eq!(recording.history().len(), 1);
/// assert_eq!(*recording.ending(), Ending::Closed);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recording {
    info: Info,
    size: MazeSize,
    maze: Option<Maze>,
    kept: Kept,
    ending: Ending,
}

/// What is kept of the states of a recording.
#[derive(Debug)]
struct Kept {
    history: History,
    times: Times,
    share: Share,
}

/// How the file of a recording ends. In any case all states before the end are whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Properly: the recording was closed.
    Closed,
    /// The file just stops: whoever wrote it was killed, or is still writing.
    Cut {
        /// How many bytes belong to whole records.
        whole: u64,
        /// How many bytes the file has.
        length: u64,
    },
    /// What follows makes no sense.
    Damaged {
        /// How many bytes belong to whole records before that.
        whole: u64,
        /// What is wrong with what follows.
        reason: String,
    },
}

/// A file from which no recording could be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The content is no recording, or is cut off before it says of what.
    #[error("{}: {source}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What was expected and found.
        source: NoRecording,
    },
}

/// Bytes of which no recording can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoRecording {
    /// They cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// They do not begin as an MCAP file does.
    #[error("expected a recording, which is an MCAP file, found something else at byte 0")]
    NoMcap,
    /// They end, or stop to make sense, before they say of what they are a recording.
    #[error("expected a recording's description of its maze, found {found} at byte {at}")]
    NoDescription {
        /// After how many whole bytes.
        at: u64,
        /// What stands there.
        found: String,
    },
    /// They say so in a way that makes no sense.
    #[error("expected a recording's description of its maze, found one in which {0}")]
    Description(String),
    /// Its states take more memory than the budget has left.
    #[error(
        "cannot be opened: its first {states} states take all that is left of {} MiB for open \
         recordings ({}--history-limit allows more)",
        limit >> 20,
        if *others > 0 { "close another one first; " } else { "" }
    )]
    TooLarge {
        /// How many states there was room for.
        states: usize,
        /// How many bytes all open recordings may take.
        limit: usize,
        /// How many of them other recordings take.
        others: usize,
    },
    /// The system has no memory left for it.
    #[error("cannot be opened: out of memory")]
    OutOfMemory,
}

/// Why a state was not recorded, or a recording not closed. What was written before stays readable.
#[derive(Debug, thiserror::Error)]
#[error("cannot record in {}: {source}", path.display())]
pub struct RecordError {
    /// The file or folder.
    pub path: PathBuf,
    /// What the operating system says, or what has happened to the file.
    pub source: io::Error,
}

impl RecordError {
    fn new(path: &Path, error: impl Into<io::Error>) -> Self {
        Self { path: path.into(), source: error.into() }
    }
}

impl Recording {
    /// Reads a recording from a file, however much memory that takes.
    ///
    /// # Errors
    /// The file cannot be read or holds no recording. One that is cut off or damaged somewhere
    /// behind its description is no error: [`ending`](Self::ending) tells of it.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_within(path, &Arc::default())
    }

    /// Reads a recording from a file, if its states fit into what the budget has left.
    ///
    /// # Errors
    /// As for [`open`](Self::open), or there is not enough memory. So what is open is always whole:
    /// the last state that is shown is the last of the file.
    pub fn open_within(path: &Path, budget: &Arc<MemoryBudget>) -> Result<Self, RecordingError> {
        let file =
            File::open(path).map_err(|source| RecordingError::Io { path: path.into(), source })?;
        let read = Self::read_within(BufReader::with_capacity(STEP_BYTES, file), budget);
        read.map_err(|error| match error {
            NoRecording::Io(source) => RecordingError::Io { path: path.into(), source },
            source => RecordingError::Content { path: path.into(), source },
        })
    }

    /// Reads a recording from its bytes, however much memory that takes. Many small pieces are asked
    /// for.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn read(source: impl Read) -> Result<Self, NoRecording> {
        Self::read_within(source, &Arc::default())
    }

    /// Reads a recording from its bytes, if its states fit into what the budget has left. Many small
    /// pieces are asked for.
    ///
    /// # Errors
    /// As for [`open_within`](Self::open_within).
    pub fn read_within(source: impl Read, budget: &Arc<MemoryBudget>) -> Result<Self, NoRecording> {
        let mut kept = None;
        let (description, ending) = read_states(source, |description, message, time| {
            kept.get_or_insert_with(|| Kept::new(description.size, budget)).add(message, time)
        })?;
        let Description { info, size, maze } = description;
        let kept = kept.unwrap_or_else(|| Kept::new(size, budget));
        let info = Info { states: kept.history.len(), ..info };
        Ok(Self { info, size, maze, kept, ending })
    }

    /// What `info` would tell of the simulation, with as many states as were recorded.
    pub const fn info(&self) -> &Info {
        &self.info
    }

    /// How many cells the maze has each way.
    pub const fn size(&self) -> MazeSize {
        self.size
    }

    /// The true maze, if whoever recorded knew it: a server does, a client does not.
    pub const fn maze(&self) -> Option<&Maze> {
        self.maze.as_ref()
    }

    /// The states.
    pub const fn history(&self) -> &History {
        &self.kept.history
    }

    /// When each state was recorded.
    pub const fn times(&self) -> &Times {
        &self.kept.times
    }

    /// How the file ends.
    pub const fn ending(&self) -> &Ending {
        &self.ending
    }
}

impl Kept {
    fn new(size: MazeSize, budget: &Arc<MemoryBudget>) -> Self {
        let (history, times) = (History::new(size), Times::new(1));
        Self { history, times, share: Share::new(budget) }
    }

    /// Adds a state and the nanoseconds since 1970 at which it was recorded.
    fn add(&mut self, state: &[u8], time: u64) -> Result<(), NoRecording> {
        let Self { history, times, share } = self;
        let states = history.len();
        history.push(state).map_err(|error| match error {
            PushError::OutOfMemory { .. } => NoRecording::OutOfMemory,
            // It has the length of a state, and there is no other limit.
            error => NoRecording::Description(error.to_string()),
        })?;
        times.push(time).map_err(|_| NoRecording::OutOfMemory)?;
        if !share.grow_to(history.bytes() + times.bytes()) {
            let (limit, others) = (share.budget().limit(), share.others());
            return Err(NoRecording::TooLarge { states, limit, others });
        }
        Ok(())
    }
}
