//! The names used in the MCAP file of a recording, the description of its simulation, and errors.
//! See docs/recordings.md.

use std::io;
use std::path::{Path, PathBuf};

use mmsim_formats::parse_maze;
use mmsim_maze::{Escaped, Maze, MazeSize};
use mmsim_protocol::Info;

/// A recording's description of its simulation.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    /// `states` is 0.
    pub(crate) info: Info,
    pub(crate) size: MazeSize,
    /// `None` until the message with the maze is read.
    pub(crate) maze: Option<Maze>,
}

/// Parses the description of the simulation.
pub(crate) fn describe(info: Option<&str>) -> Result<Description, ReadError> {
    let invalid = ReadError::InvalidDescription;
    let info = info.ok_or_else(|| invalid("info is missing".into()))?;
    let mut info: Info = serde_json::from_str(info)
        .map_err(|error| invalid(format!("info is not valid JSON: {error}")))?;
    let Info { width, height, .. } = info;
    let size = info.size().ok_or_else(|| {
        invalid(format!("the maze has {width}x{height} cells, but only 1x1 to 32x32 are supported"))
    })?;
    if info.start_pose().is_none_or(|start| !size.contains(start.cell)) {
        return Err(invalid(format!("the start is outside the maze of {size} cells")));
    }
    info.maze = Escaped(&info.maze).to_string();
    Ok(Description { info, size, maze: None })
}

/// Parses the text of a maze. Fails if the maze does not have this size.
pub(crate) fn read_maze(text: &[u8], size: MazeSize) -> Result<Maze, ReadError> {
    let invalid = ReadError::InvalidDescription;
    let maze =
        parse_maze(text).map_err(|error| invalid(format!("the maze is invalid: {error}")))?;
    match maze.size() {
        found if found == size => Ok(maze),
        found => {
            Err(invalid(format!("the maze has {found} cells, but the states are for {size} cells")))
        }
    }
}

/// The name of the metadata record that describes the simulation.
pub(crate) const METADATA: &str = "mmsim";

/// The metadata key whose value is the reply to `info` as JSON.
pub(crate) const INFO: &str = "info";

/// The metadata key whose value is the protocol version. The value is for other tools; mmsim does
/// not read it.
pub(crate) const PROTOCOL: &str = "protocol";

/// The name of the metadata record with the names of the mouse and its strategy, and its keys. The
/// record is for other tools; mmsim reads the names from the updates.
pub(crate) const MOUSE: &str = "mmsim-mouse";
pub(crate) const MOUSE_KEYS: [&str; 2] = ["mouse", "strategy"];

/// The topic and message encoding of the channel for states. Each message holds one state.
pub(crate) const STATES: [&str; 2] = ["/state", "mmsim-state"];

/// The topic and message encoding of the channel for updates. Each message holds the update of the
/// next state. States whose update is empty have no message in this channel.
pub(crate) const UPDATES: [&str; 2] = ["/update", "mmsim-update"];

/// The topic and message encoding of the channel for annotations that may not be followed by a
/// state. Each message holds a request `A`. The annotations before a state are also in its update.
pub(crate) const ANNOTATIONS: [&str; 2] = ["/annotation", "mmsim-annotation"];

/// The topic and message encoding of the channel whose only message is the true maze as text.
///
/// Recordings made by clients lack this channel, because clients do not know the true maze. The
/// maze is not stored as metadata because metadata is never compressed.
pub(crate) const MAZES: [&str; 2] = ["/maze", "mmsim-maze"];

/// The topics of the channels for other tools. Their messages repeat what the states contain.
pub const MESSAGE_TOPICS: [&str; 3] = ["/mouse", "/pose", "/scene"];

/// The message encoding of the channels for other tools, and the encoding of their schemas. mmsim
/// does not read these channels.
pub(crate) const JSON: &str = "json";
pub(crate) const JSON_SCHEMA: &str = "jsonschema";

/// The error when a file cannot be opened as a recording.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// The reason why the file could not be read.
    pub source: ReadError,
}

/// The reason why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Reading the data failed.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The data does not begin with the signature of an MCAP file.
    #[error("expected a recording (an MCAP file), found other data at byte 0")]
    NotMcap,
    /// The file ends or is damaged before its description of the maze.
    #[error("expected a description of the maze, found {found} at byte {at}")]
    MissingDescription {
        /// The number of intact bytes at the beginning of the file.
        at: u64,
        /// The reason why the next record is invalid, or `the end of the file`.
        found: String,
    },
    /// The description of the maze is invalid.
    #[error("the description of the maze is invalid: {0}")]
    InvalidDescription(String),
    /// The file contains more states than a real recording of its size.
    #[error("cannot be opened: more than {states} states in {bytes} bytes")]
    TooManyStates {
        /// The maximum number of states in these bytes.
        states: u64,
        /// The number of bytes in the file.
        bytes: u64,
    },
    /// The states need more memory than the budget has left.
    #[error(
        "cannot be opened: only its first {states} states fit into the {} MiB that open recordings \
         share ({}raise --history-limit)",
        limit >> 20,
        if *others > 0 { "close another recording, or " } else { "" }
    )]
    TooLarge {
        /// The number of states of the recording that fit into the remaining memory.
        states: usize,
        /// The memory limit for all open recordings together, in bytes.
        limit: usize,
        /// The memory that other open recordings use, in bytes.
        others: usize,
    },
    /// The system is out of memory.
    #[error("cannot be opened: out of memory")]
    OutOfMemory,
}

/// The error when a state cannot be recorded or a recording cannot be closed.
///
/// States that were written before the error remain readable.
#[derive(Debug, thiserror::Error)]
#[error("cannot record in {}: {source}", path.display())]
pub struct RecordError {
    /// The path of the recording or of its folder.
    pub path: PathBuf,
    /// The operating system's error, or an error that describes how another program changed the
    /// file.
    pub source: io::Error,
}

impl RecordError {
    pub(crate) fn new(path: &Path, error: impl Into<io::Error>) -> Self {
        Self { path: path.into(), source: error.into() }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use mcap::records::MessageHeader;

    use super::*;
    use crate::recording::Recording;
    use crate::recording::reader::Integrity;
    use crate::recording::writer::RecordingWriter;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    #[test]
    fn invalid_descriptions_are_errors() {
        let other = |info: Option<&str>, maze: &str| {
            let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
            let metadata = info.map(|info| ("info".into(), info.into())).into_iter().collect();
            let name = METADATA.into();
            mcap.write_metadata(&mcap::records::Metadata { name, metadata }).unwrap();
            let [topic, encoding] = MAZES;
            let channel_id = mcap.add_channel(0, topic, encoding, &[].into()).unwrap();
            let header = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
            mcap.write_to_known_channel(&header, maze.as_bytes()).unwrap();
            mcap.finish().unwrap();
            Recording::read(&mcap.into_inner().into_inner()[..]).unwrap_err().to_string()
        };
        let info = |width: u8, start: u8| {
            format!(
                r#"{{"maze":"","width":{width},"height":1,"start":[{start},0],"heading":"N","goals":[],"states":0,"protocol":1}}"#
            )
        };
        insta::assert_snapshot!(other(None, MAZE), @"the description of the maze is invalid: info is missing");
        insta::assert_snapshot!(other(Some("{}"), MAZE), @"the description of the maze is invalid: info is not valid JSON: missing field `maze` at line 1 column 2");
        insta::assert_snapshot!(other(Some(&info(40, 0)), MAZE), @"the description of the maze is invalid: the maze has 40x1 cells, but only 1x1 to 32x32 are supported");
        insta::assert_snapshot!(other(Some(&info(2, 2)), MAZE), @"the description of the maze is invalid: the start is outside the maze of 2x1 cells");
        insta::assert_snapshot!(other(Some(&info(2, 0)), "rubbish"), @r#"the description of the maze is invalid: the maze is invalid: line 1, column 1: expected a maze: a drawing, a number for each cell, or a line for each cell, found "rubbish""#);
        insta::assert_snapshot!(other(Some(&info(3, 0)), MAZE), @"the description of the maze is invalid: the maze has 2x1 cells, but the states are for 3x1 cells");
    }

    /// Fuzzing found that the reader reserved as much memory as a length field claimed.
    #[test]
    fn a_length_that_exceeds_its_record_reserves_no_memory() {
        let folder = tempfile::tempdir().unwrap();
        let (path, maze) = (folder.path().join("a.mcap"), MAZE.parse::<Maze>().unwrap());
        let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
        RecordingWriter::create(&path, &info, Some(&maze)).unwrap().close().unwrap();
        let recorded = fs::read(&path).unwrap();
        for (string, described) in [(&b"\x05\0\0\0mmsim"[..], false), (b"\x06\0\0\0/state", true)] {
            let mut bytes = recorded.clone();
            let at = bytes.windows(string.len()).position(|bytes| bytes == string).unwrap();
            bytes[at + 3] = 0xff;
            let wrong = "a field that extends past the end of its record";
            match Recording::read(&bytes[..]) {
                Ok(recording) => {
                    assert!(described);
                    assert!(recording.history().is_empty());
                    assert!(
                        matches!(recording.integrity(), Integrity::Damaged { reason, .. } if reason == wrong)
                    );
                }
                Err(error) => assert!(!described && error.to_string().contains(wrong), "{error}"),
            }
        }
    }
}
