//! Writes a compressed recording of states that are stored elsewhere until it is complete.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions};
use mmsim_maze::Maze;
use mmsim_protocol::Info;

use crate::layout::{INFO, MAZES, METADATA, PROTOCOL, STATES};

/// Uncompressed size of a chunk in bytes.
const CHUNK_BYTES: u64 = 1 << 20;

/// zstd level. Higher levels take much longer for little gain; level 3 takes a tenth more bytes.
const LEVEL: u32 = 8;

/// A writer of compressed recordings. States may be missing from the file until it is finished.
pub(crate) struct PackedWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    /// Text of the true maze, until it is written before the first state.
    maze: Option<String>,
    channel_id: u16,
    states: u32,
}

impl<W: Write + Seek> PackedWriter<W> {
    pub(crate) fn new(to: W, info: &Info, maze: Option<&Maze>) -> Result<Self, McapError> {
        let options = options()
            .chunk_size(Some(CHUNK_BYTES))
            .compression(Some(Compression::Zstd))
            .compression_level(LEVEL)
            // Indexes would take as much space as the states. With neither of the two, readers read
            // the file from start to end.
            .emit_message_indexes(false)
            .emit_chunk_indexes(false);
        // Extra threads would slow down a search.
        let mut mcap = options.compression_threads(0).create(to)?;
        let channel_id = describe(&mut mcap, info)?;
        Ok(Self { mcap, maze: maze.map(Maze::to_string), channel_id, states: 0 })
    }

    /// Appends a state, received at `time` in nanoseconds since 1970 (UTC).
    pub(crate) fn write(&mut self, time: u64, state: &[u8]) -> Result<(), McapError> {
        self.write_maze(time)?;
        let Self { mcap, channel_id, states, .. } = self;
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *states,
            log_time: time,
            publish_time: time,
        };
        *states = states.wrapping_add(1);
        mcap.write_to_known_channel(&header, state)
    }

    fn write_maze(&mut self, time: u64) -> Result<(), McapError> {
        self.maze.take().map_or(Ok(()), |maze| write_maze(&mut self.mcap, &maze, time))
    }

    pub(crate) fn finish(mut self) -> Result<W, McapError> {
        self.write_maze(0)?;
        self.mcap.finish()?;
        let mut to = self.mcap.into_inner();
        to.flush()?;
        Ok(to)
    }
}

/// Writes a compressed recording, about 20 bytes per state.
///
/// `info` describes the simulation; `maze` is its true maze if known. Each state comes with its time
/// in nanoseconds since 1970 (UTC).
///
/// # Errors
/// Writing to `to` fails.
pub fn save<S: AsRef<[u8]>>(
    to: impl Write + Seek,
    info: &Info,
    maze: Option<&Maze>,
    states: impl IntoIterator<Item = (u64, S)>,
) -> io::Result<()> {
    let written = || {
        let mut writer = PackedWriter::new(to, info, maze)?;
        for (time, state) in states {
            writer.write(time, state.as_ref())?;
        }
        writer.finish()
    };
    written().map(|_| ()).map_err(io_error)
}

/// Returns the options shared by all recordings.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new().library(concat!("mmsim ", env!("CARGO_PKG_VERSION")))
}

/// Writes the description of the simulation; returns the ID of the channel of states.
pub(crate) fn describe(
    mcap: &mut mcap::Writer<impl Write + Seek>,
    info: &Info,
) -> Result<u16, McapError> {
    let mut described = info.clone();
    described.states = 0;
    let json = serde_json::to_string(&described);
    let metadata = BTreeMap::from([
        (INFO.into(), json.map_err(io::Error::other)?),
        (PROTOCOL.into(), info.protocol.to_string()),
    ]);
    mcap.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
    let [topic, encoding] = STATES;
    mcap.add_channel(0, topic, encoding, &BTreeMap::new())
}

/// Writes the true maze as text, with the time at which the recording starts.
pub(crate) fn write_maze(
    mcap: &mut mcap::Writer<impl Write + Seek>,
    maze: &str,
    time: u64,
) -> Result<(), McapError> {
    let [topic, encoding] = MAZES;
    let channel_id = mcap.add_channel(0, topic, encoding, &BTreeMap::new())?;
    let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
    mcap.write_to_known_channel(&header, maze.as_bytes())
}

/// Extracts the error of the operating system, if there is one.
pub(crate) fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reader::Integrity;
    use crate::recording::Recording;

    #[test]
    fn a_saved_recording_can_be_read() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let info = Info::new("small", maze.size(), maze.start(), maze.goals(), 0);
        let state = |number: u64| {
            let [low, high, ..] = number.to_le_bytes();
            (1_000 + number * 7, [b"S\x00\x00NC\x01\x00C".as_slice(), &[low, high]].concat())
        };
        for count in [0, 1, 200_000] {
            let mut file = io::Cursor::new(Vec::new());
            save(&mut file, &info, Some(&maze), (0..count).map(state)).unwrap();
            let bytes = file.into_inner();
            let recording = Recording::read(bytes.as_slice()).unwrap();
            assert_eq!(*recording.integrity(), Integrity::Closed);
            assert_eq!(recording.maze(), Some(&maze));
            assert_eq!(recording.history().len() as u64, count);
            let read = recording.times().iter().zip(recording.history().iter());
            assert!(read.eq((0..count).map(state)));
            assert!(bytes.len() < 2_000 + 30 * usize::try_from(count).unwrap());
        }
    }
}
