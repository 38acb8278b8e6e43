//! Writes a recording of states that are there already, packed.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions};
use mmsim_maze::Maze;
use mmsim_protocol::Info;

use super::{ENCODING, INFO, MAZE, METADATA, PROTOCOL, TOPIC};

/// Bytes of states that are packed together.
const CHUNK_BYTES: u64 = 1 << 20;

/// Writes a recording of these states, each with the nanoseconds since the beginning of 1970 (UTC)
/// at which it came. `info` tells of what simulation, and the true maze belongs into it where it is
/// known.
///
/// Unlike what [`RecordingWriter`](super::RecordingWriter) writes state by state, the states are
/// packed, and take some thirty bytes each, half of them for other tools to find them by their time.
///
/// # Errors
/// What is written to fails.
pub fn save<S: AsRef<[u8]>>(
    to: impl Write + Seek,
    info: &Info,
    maze: Option<&Maze>,
    states: impl IntoIterator<Item = (u64, S)>,
) -> io::Result<()> {
    let options = options().chunk_size(Some(CHUNK_BYTES)).compression(Some(Compression::Zstd));
    let written = || -> Result<(), McapError> {
        let mut mcap = options.create(to)?;
        let channel_id = describe(&mut mcap, info, maze)?;
        for (sequence, (time, state)) in (0..).zip(states) {
            let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
            mcap.write_to_known_channel(&header, state.as_ref())?;
        }
        mcap.finish()?;
        Ok(mcap.into_inner().flush()?)
    };
    written().map_err(cause)
}

/// How all recordings are written.
pub(super) fn options() -> WriteOptions {
    WriteOptions::new().library(concat!("mmsim ", env!("CARGO_PKG_VERSION")))
}

/// Says of what it is a recording; gives the channel of its states.
pub(super) fn describe(
    mcap: &mut mcap::Writer<impl Write + Seek>,
    info: &Info,
    maze: Option<&Maze>,
) -> Result<u16, McapError> {
    let json = serde_json::to_string(&Info { states: 0, ..info.clone() });
    let mut description = BTreeMap::from([
        (INFO.into(), json.map_err(io::Error::other)?),
        (PROTOCOL.into(), info.protocol.to_string()),
    ]);
    description.extend(maze.map(|maze| (MAZE.into(), maze.to_string())));
    mcap.write_metadata(&Metadata { name: METADATA.into(), metadata: description })?;
    mcap.add_channel(0, TOPIC, ENCODING, &BTreeMap::new())
}

/// What the operating system says.
pub(super) fn cause(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ending, Recording, Simulation};

    #[test]
    fn what_is_saved_is_read() {
        let simulation =
            Simulation::new("small", "o---o---o\n| S   G |\no---o---o\n".parse().unwrap());
        let state = |number: u64| {
            let [low, high, ..] = number.to_le_bytes();
            (1_000 + number * 7, [b"S\x00\x00NC\x01\x00C".as_slice(), &[low, high]].concat())
        };
        for count in [0, 1, 200_000] {
            let mut file = io::Cursor::new(Vec::new());
            let maze = simulation.maze();
            save(&mut file, &simulation.info(), Some(maze), (0..count).map(state)).unwrap();
            let bytes = file.into_inner();
            let recording = Recording::read(bytes.as_slice()).unwrap();
            assert_eq!(*recording.ending(), Ending::Closed);
            assert_eq!(recording.maze(), Some(maze));
            assert_eq!(recording.history().len() as u64, count);
            let read = recording.times().iter().copied().zip(recording.history().iter());
            assert!(read.eq((0..count).map(state)));
            assert!(bytes.len() < 2_000 + 30 * usize::try_from(count).unwrap());
        }
    }
}
