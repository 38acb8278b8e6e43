//! A recording: the states of one simulation, from reset to reset, in a file.
//!
//! The file is an [MCAP](https://mcap.dev) container, so that it survives a crash up to its last
//! state and opens in other tools. docs/recordings.md says what is in it.

mod chunk;
mod reader;
mod recorder;
mod save;
mod writer;

use std::io;
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;
use mmsim_protocol::{Info, MazeSize, Request, State};

use crate::History;

pub use recorder::Recorder;
pub use save::save;
pub use writer::RecordingWriter;

/// The name of the metadata record that says what is recorded.
const METADATA: &str = "mmsim";

/// Its key under which the reply to `info` stands, as JSON.
const INFO: &str = "info";

/// Its key under which the version of the protocol stands by itself, for other tools.
const PROTOCOL: &str = "protocol";

/// Its key under which the true maze stands as text. A client does not know it.
const MAZE: &str = "maze";

/// The topic of the channel of states.
const TOPIC: &str = "/state";

/// The encoding of the messages in it: the protocol's own, as `S` is sent.
const ENCODING: &str = "mmsim-state";

/// A recording, read from a file.
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
    history: History,
    times: Vec<u64>,
    ending: Ending,
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

/// Bytes that are no recording.
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
}

/// Why a state was not recorded. What was written before stays readable.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file cannot be created or written.
    #[error("expected to record in {}, found: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file has gone.
    #[error(
        "expected to record in {}, found the file has gone; reset begins a new one", path.display()
    )]
    Gone {
        /// The file.
        path: PathBuf,
    },
}

impl RecordError {
    fn io(path: &Path, error: impl Into<io::Error>) -> Self {
        Self::Io { path: path.into(), source: error.into() }
    }
}

impl Recording {
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
        &self.history
    }

    /// When each state was recorded, in nanoseconds since the beginning of 1970 (UTC).
    pub fn times(&self) -> &[u64] {
        &self.times
    }

    /// How the file ends.
    pub const fn ending(&self) -> &Ending {
        &self.ending
    }
}

/// The state in a message, if it is one of a maze of this size.
fn state(message: &[u8], size: MazeSize) -> Result<State<'_>, String> {
    match Request::decode(message, size) {
        Ok(Request::State(state)) => Ok(state),
        Ok(_) => Err("expected a state, found another request".into()),
        Err(error) => Err(error.to_string()),
    }
}
