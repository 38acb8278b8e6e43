//! Reads a recording up to its last intact record.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use mmsim_protocol::{Annotations, Request};
use serde::Serialize;

use crate::context::update::{MAX_UPDATE_BYTES, StoredUpdate, TrailingAnnotations};
use crate::mcap::reader::{End, MAX_BODY_BYTES, RecordReader};
use crate::mcap::{Channel, Message, Metadata, kind};
use crate::recording::format::{
    ANNOTATIONS, Description, INFO, JSON, MAZES, MESSAGE_TOPICS, METADATA, ReadError, STATES,
    UPDATES, describe, read_maze,
};
use crate::recording::save::MESSAGE_BYTES;

/// The maximum number of states in a short file. Each byte of a file raises the limit by
/// `MAX_STATES_PER_BYTE`, which bounds the time that reading takes.
const MAX_STATES: u64 = 100_000;

/// States of a real search take about 30 bytes in a compressed file. Identical states in a row take 6
/// bytes if they are at the times of a real clock, and one byte at regular times.
const MAX_STATES_PER_BYTE: u64 = 4;

/// The maximum length of a record that describes the simulation, in bytes. The length is limited
/// because descriptions stay in memory. The description of the largest maze takes less than 12,000
/// bytes.
const MAX_DESCRIPTION_BYTES: u64 = 64 << 10;

// Longer records are cut.
const _: () = assert!(MAX_UPDATE_BYTES + MESSAGE_BYTES <= MAX_BODY_BYTES);

/// The integrity of a recording file: whether it is complete and, if not, how many bytes are
/// intact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Integrity {
    /// The recording was closed, so the file is complete.
    Closed,
    /// The file ends early: its writer was killed or is still writing.
    Truncated {
        /// The length of the intact records in bytes.
        intact: u64,
        /// The length of the file in bytes.
        length: u64,
    },
    /// The file contains an invalid record.
    Damaged {
        /// The length in bytes of the intact records before the invalid record.
        intact: u64,
        /// The reason why the record is invalid.
        reason: String,
    },
}

/// A state in a recording.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordedState<'a> {
    /// The time in nanoseconds since 1970 (UTC).
    pub(crate) time: u64,
    /// The valid bytes of the update before the state.
    pub(crate) update: &'a [u8],
    /// The valid bytes of the state.
    pub(crate) state: &'a [u8],
}

/// The records of a file that do not belong to a recording, such as those of other programs. The
/// field names are JSON keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct IgnoredRecords {
    /// The number of messages in other channels.
    pub messages: u64,
    /// The number of attachments.
    pub attachments: u64,
}

/// What a recording contains besides its states.
#[derive(Debug)]
pub(crate) struct Contents {
    pub(crate) description: Description,
    pub(crate) trailing: TrailingAnnotations,
    pub(crate) integrity: Integrity,
    pub(crate) ignored: IgnoredRecords,
}

/// Reads a recording up to its last intact record.
///
/// Calls `on_state` with each state. Stops at the first error from `on_state` and returns it.
pub(crate) fn read_states(
    source: impl Read + Seek,
    on_state: impl FnMut(&Description, RecordedState<'_>) -> Result<(), ReadError>,
) -> Result<Contents, ReadError> {
    let mut reader = RecordReader::new(source)?;
    // Other tools may write the metadata after the states.
    let is_description = |body: &[u8]| Metadata::decode(body).is_ok_and(|it| it.name == METADATA);
    let metadata = reader.find_metadata(MAX_DESCRIPTION_BYTES, is_description)?;
    let info = metadata.as_deref().and_then(|body| Metadata::decode(body).ok());
    let description = info.map(|metadata| describe(metadata.get(INFO))).transpose()?;
    let mut records = Records {
        description,
        channels: BTreeMap::new(),
        update: Vec::new(),
        trailing: TrailingAnnotations::default(),
        ignored: IgnoredRecords::default(),
        length: reader.length,
        states: 0,
        on_state,
    };
    // The number of bytes in intact records.
    let mut intact = 0;
    let integrity = loop {
        match reader.read_next(|kind, body| records.add(kind, body)) {
            Ok(()) => intact = reader.position(),
            Err(End::Closed) => break Integrity::Closed,
            Err(End::Truncated) => break Integrity::Truncated { intact, length: reader.length },
            Err(End::Damaged(reason)) => break Integrity::Damaged { intact, reason },
            Err(End::NotMcap) => return Err(ReadError::NotMcap),
            Err(End::OutOfMemory) => return Err(ReadError::OutOfMemory),
            Err(End::Io(error)) => return Err(error.into()),
            Err(End::Failed(error)) => return Err(error),
        }
    };
    let Records { description, trailing, ignored, .. } = records;
    let Some(description) = description else {
        let (at, found) = match integrity {
            Integrity::Damaged { intact, reason } => (intact, reason),
            _ => (reader.length, "the end of the file".into()),
        };
        return Err(ReadError::MissingDescription { at, found });
    };
    Ok(Contents { description, trailing, integrity, ignored })
}

/// The data from the records that have been read so far.
struct Records<F> {
    description: Option<Description>,
    /// The channels that mmsim writes, by their numbers: the topic and the encoding.
    channels: BTreeMap<u16, [&'static str; 2]>,
    /// The update of the next state.
    update: Vec<u8>,
    /// The annotations since the newest state.
    trailing: TrailingAnnotations,
    ignored: IgnoredRecords,
    /// The number of bytes in the file.
    length: u64,
    /// The number of states so far.
    states: u64,
    on_state: F,
}

impl From<ReadError> for End<ReadError> {
    fn from(error: ReadError) -> Self {
        Self::Failed(error)
    }
}

impl<F: FnMut(&Description, RecordedState<'_>) -> Result<(), ReadError>> Records<F> {
    /// Processes a record that is not a chunk.
    fn add(&mut self, kind: u8, body: &[u8]) -> Result<(), End<ReadError>> {
        let is_short = body.len() as u64 <= MAX_DESCRIPTION_BYTES;
        match kind {
            kind::MESSAGE => return self.add_message(&Message::decode(body)?),
            // Reports damage of the missing description.
            kind::METADATA if is_short && self.description.is_none() => {
                Metadata::decode(body)?;
            }
            kind::CHANNEL if is_short => {
                let channel = Channel::decode(body)?;
                let is_this = |names: &[&str; 2]| *names == [channel.topic, channel.encoding];
                let for_others = MESSAGE_TOPICS.map(|topic| [topic, JSON]);
                let mut all = [STATES, UPDATES, ANNOTATIONS, MAZES].into_iter().chain(for_others);
                if let Some(names) = all.find(is_this) {
                    self.channels.insert(channel.number, names);
                }
            }
            kind::ATTACHMENT => self.ignored.attachments += 1,
            _ => {}
        }
        Ok(())
    }

    fn add_message(&mut self, message: &Message<'_>) -> Result<(), End<ReadError>> {
        let &Message { channel, time, data } = message;
        let Some(description) = &mut self.description else { return Ok(()) };
        match self.channels.get(&channel) {
            Some(&MAZES) => {
                let is_new = description.maze.is_none();
                if is_new && data.len() as u64 <= MAX_DESCRIPTION_BYTES {
                    description.maze = Some(read_maze(data, description.size)?);
                }
            }
            Some(&UPDATES) => {
                StoredUpdate::decode(data, description.size)?;
                self.update.clear();
                self.update.extend_from_slice(data);
            }
            Some(&ANNOTATIONS) => {
                let annotations = Annotations::decode(data, description.size);
                let added = self.trailing.add(annotations.map_err(|error| error.to_string())?);
                added.map_err(|error| error.to_string())?;
            }
            Some(&STATES) => {
                let request = Request::decode(data, description.size);
                let Request::State(_) = request.map_err(|error| error.to_string())? else {
                    return Err("expected a state, found another request".into());
                };
                self.states += 1;
                let (bytes, states) = (self.length, MAX_STATES + MAX_STATES_PER_BYTE * self.length);
                if self.states > states {
                    return Err(ReadError::TooManyStates { states, bytes }.into());
                }
                let update = &self.update;
                (self.on_state)(description, RecordedState { time, update, state: data })?;
                self.update.clear();
                self.trailing.clear();
            }
            Some(_) => {}
            None => self.ignored.messages += 1,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::{fs, io};

    use mcap::WriteOptions;
    use mcap::records::MessageHeader;
    use mmsim_maze::{Cell, Heading, Maze};
    use mmsim_protocol::{Info, MazeSize};

    use super::*;
    use crate::recording::Recording;
    use crate::recording::writer::RecordingWriter;

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn state(number: u8) -> Vec<u8> {
        [b"S\x00\x00NC\x01".to_vec(), vec![number], b"C\x0d\x00".to_vec()].concat()
    }

    /// Returns the update before the state with this number.
    fn update(number: u8) -> &'static [u8] {
        match number {
            0 => b"U",
            2 => b"NR\x01\0E",
            _ => b"",
        }
    }

    /// Returns true if the client has read the wall in the middle of the maze before the state with
    /// this index, or `None` if it has not read any walls.
    fn has_read_wall(recording: &Recording, index: usize) -> Option<bool> {
        let context = recording.history().context(index).unwrap();
        context.walls_read().map(|read| read.has(Cell::new(0, 0), Heading::East))
    }

    fn info(maze: &Maze) -> Info {
        Info::new("small", maze.size(), maze.start(), maze.goals(), 0)
    }

    /// Returns the bytes of a recording with this many states.
    fn recorded(states: u8) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let maze = MAZE.parse().unwrap();
        let mut writer = RecordingWriter::create(&path, &info(&maze), Some(&maze)).unwrap();
        for number in 0..states {
            writer.write_with_update(update(number), &state(number)).unwrap();
        }
        writer.close().unwrap();
        fs::read(&path).unwrap()
    }

    #[test]
    fn a_recording_survives_a_round_trip() {
        let recording = Recording::read(&recorded(200)[..]).unwrap();
        assert_eq!(recording.maze().unwrap().to_string(), MAZE);
        let size = MazeSize::new(2, 1).unwrap();
        assert_eq!((recording.info().states, recording.size()), (200, size));
        assert_eq!(recording.info().maze, "small");
        assert!(recording.history().iter().eq((0..200).map(state)));
        assert!(recording.times().iter().is_sorted() && recording.times().len() == 200);
        assert_eq!(*recording.integrity(), Integrity::Closed);
        let read = [0, 1, 2, 3, 199].map(|index| has_read_wall(&recording, index));
        assert_eq!(read, [None, None, Some(false), Some(true), Some(true)]);
    }

    #[test]
    fn an_invalid_update_is_damage() {
        let mut bytes = recorded(5);
        let at = bytes.windows(5).position(|bytes| bytes == b"NR\x01\0E").unwrap();
        bytes[at + 2] = 9;
        let recording = Recording::read(&bytes[..]).unwrap();
        assert!(recording.history().iter().eq((0..2).map(state)));
        let Integrity::Damaged { reason, .. } = recording.integrity() else {
            panic!("{recording:?}")
        };
        insta::assert_snapshot!(reason, @r#"expected R, x, y and heading, found "R\t\x00E""#);
    }

    #[test]
    fn states_without_updates_have_readings_at_their_poses() {
        let mut file = std::io::Cursor::new(Vec::new());
        let states = (0..3).map(|number| (u64::from(number), [], state(number)));
        crate::recording::save::save(
            &mut file,
            &info(&MAZE.parse().unwrap()),
            None,
            states,
            &TrailingAnnotations::default(),
        )
        .unwrap();
        let bytes = file.into_inner();
        assert!(!bytes.windows(7).any(|bytes| bytes == b"/update"));
        let recording = Recording::read(&bytes[..]).unwrap();
        assert_eq!([0, 2].map(|index| has_read_wall(&recording, index)), [Some(true); 2]);
    }

    #[test]
    fn a_file_truncated_anywhere_gives_its_intact_states_or_an_error() {
        let bytes = recorded(5);
        // Offset of the end of each state, which is the end of its record.
        let ends: Vec<usize> = (0..5)
            .map(|number| {
                let state = state(number);
                bytes.windows(state.len()).position(|bytes| bytes == state).unwrap() + state.len()
            })
            .collect();
        let mut described = false;
        for length in 0..bytes.len() {
            match Recording::read(&bytes[..length]) {
                Ok(recording) => {
                    let states = ends.iter().filter(|&&end| end <= length).count();
                    let expected = (0..5).map(state).take(states);
                    assert!(recording.history().iter().eq(expected), "{length} bytes");
                    if let Some(newest) = states.checked_sub(1) {
                        let read = has_read_wall(&recording, newest);
                        assert_eq!(read, [None, None, Some(false), Some(true), Some(true)][newest]);
                    }
                    let Integrity::Truncated { intact, length: found } = *recording.integrity()
                    else {
                        panic!("{length} bytes: {:?}", recording.integrity())
                    };
                    assert_eq!(found, length as u64);
                    assert!(
                        intact <= found
                            && ends.iter().all(|&end| end > length || end as u64 <= intact)
                    );
                    described = true;
                }
                Err(error) => {
                    assert!(!described, "{length} bytes: {error}");
                    let expected = format!("found the end of the file at byte {length}");
                    assert!(error.to_string().ends_with(&expected), "{error}");
                }
            }
        }
        assert!(described);
        let whole = Recording::read(&bytes[..]).unwrap();
        assert_eq!(*whole.integrity(), Integrity::Closed);
        assert_eq!(whole.ignored(), IgnoredRecords::default());
    }

    #[test]
    fn any_changed_byte_gives_states_or_an_error() {
        let bytes = recorded(3);
        let mut noticed = 0;
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x55;
            match Recording::read(&changed[..]) {
                Ok(recording) => {
                    noticed += usize::from(*recording.integrity() != Integrity::Closed);
                }
                Err(_) => noticed += 1,
            }
        }
        assert!(noticed > bytes.len() / 2, "{noticed} of {}", bytes.len());
    }

    /// Fuzzing found that an error message contained the unescaped name of a compression method.
    #[test]
    fn text_of_a_damaged_file_is_escaped() {
        let mut bytes = recorded(0);
        let data_end =
            bytes.windows(9).position(|bytes| bytes == b"\x0f\x04\0\0\0\0\0\0\0").unwrap();
        bytes.truncate(data_end);
        // A chunk: its length; 28 bytes of times, length and checksum; the name of the compression.
        bytes.extend([6, 44, 0, 0, 0, 0, 0, 0, 0]);
        bytes.extend([[0; 28].as_slice(), &[4, 0, 0, 0], b"\x1b[2J", &[0; 8]].concat());
        let recording = Recording::read(&bytes[..]).unwrap();
        let Integrity::Damaged { reason, .. } = recording.integrity() else {
            panic!("{recording:?}")
        };
        insta::assert_snapshot!(reason, @r#"a chunk with the unknown compression method "\x1b[2J""#);
    }

    #[test]
    fn other_files_are_errors() {
        let error = |bytes: &[u8]| Recording::read(bytes).unwrap_err().to_string();
        insta::assert_snapshot!(error(b""), @"expected a description of the maze, found the end of the file at byte 0");
        insta::assert_snapshot!(error(b"o---o---o\n"), @"expected a recording (an MCAP file), found other data at byte 0");
    }

    /// Writes the states of a recording and messages of another channel with another implementation,
    /// then the description and the maze.
    fn written_by_another_tool(options: WriteOptions, other: &[u8]) -> Vec<u8> {
        let mut mcap = options.create(io::Cursor::new(Vec::new())).unwrap();
        let mut add = |[topic, encoding]: [&str; 2]| {
            let schema = mcap.add_schema(topic, "", &[]).unwrap();
            mcap.add_channel(schema, topic, encoding, &[].into()).unwrap()
        };
        let [states, others, mazes] = [STATES, ["/other", "bytes"], MAZES].map(&mut add);
        let header = |channel_id, number: u8| {
            let time = 7 + u64::from(number);
            let sequence = number.into();
            MessageHeader { channel_id, sequence, log_time: time, publish_time: time }
        };
        for number in 0..100 {
            mcap.write_to_known_channel(&header(states, number), &state(number)).unwrap();
            mcap.write_to_known_channel(&header(others, number), other).unwrap();
        }
        let maze: Maze = MAZE.parse().unwrap();
        let info = serde_json::to_string(&info(&maze)).unwrap();
        for (name, key) in [("other", "key"), (METADATA, INFO)] {
            let metadata = [(key.into(), info.clone())].into();
            let name = name.into();
            mcap.write_metadata(&mcap::records::Metadata { name, metadata }).unwrap();
        }
        mcap.write_to_known_channel(&header(mazes, 0), MAZE.as_bytes()).unwrap();
        let attachment = mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: "video".into(),
            media_type: "video/mp4".into(),
            data: vec![7; 20 << 20].into(),
        };
        mcap.attach(&attachment).unwrap();
        mcap.finish().unwrap();
        mcap.into_inner().into_inner()
    }

    /// Such files were shown as empty or refused.
    #[test]
    fn files_of_other_tools_are_read() {
        let zstd = Some(mcap::Compression::Zstd);
        let options = || WriteOptions::new().disable_seeking(false);
        for (options, other) in [
            (options().use_chunks(false), vec![]),
            (options().compression(None), vec![7; 100]),
            (options().compression(zstd).chunk_size(Some(100)), vec![7; 100]),
            (options().compression(zstd).chunk_size(None), vec![7; 180 << 10]),
            (options().compression(None).chunk_size(None), vec![7; 400 << 10]),
            (options().use_chunks(false), vec![7; 400 << 10]),
        ] {
            let recording = Recording::read(&written_by_another_tool(options, &other)).unwrap();
            assert!(recording.history().iter().eq((0..100).map(state)));
            assert_eq!(recording.times().last(), Some(106));
            assert_eq!(recording.maze().unwrap().to_string(), MAZE);
            assert_eq!(*recording.integrity(), Integrity::Closed);
            assert_eq!(recording.ignored(), IgnoredRecords { messages: 100, attachments: 1 });
        }
    }
}
