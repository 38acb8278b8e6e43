//! Reads a recording as far as it is whole.

use std::collections::BTreeSet;
use std::io::Read;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mmsim_maze::{Escaped, Maze, MazeSize};
use mmsim_protocol::{Info, Request};

use super::{Ending, INFO, MAZE, MAZES, METADATA, NoRecording, STATES, chunk};
use crate::memory;

/// The longest record that is read, in bytes, and the most that is unpacked from one. A state takes
/// 2,085 at most and a maze less than 10,000, but other tools pack records into chunks of some MiB.
const MAX_CHUNK_BYTES: usize = 16 << 20;

/// The most that is unpacked from the chunks of a file, in bytes, and how much more for each byte of
/// the file: a small file could hold states without end otherwise. What we pack ourselves gets at most
/// some 400 times smaller.
const MAX_UNPACKED_BYTES: u64 = 2 << 30;
pub(super) const MAX_UNPACKED_FOR_EACH: u64 = 1000;

/// The longest description that is read, in bytes. With the largest maze it takes less than 12,000,
/// and all of it is kept.
const MAX_DESCRIPTION_BYTES: usize = 64 << 10;

/// The most that is read at once: as much as is asked for at a time is not promised to be there.
pub(super) const STEP_BYTES: usize = 64 * 1024;

/// What a recording says of its simulation.
#[derive(Clone, Debug)]
pub(super) struct Description {
    /// Without states.
    pub(super) info: Info,
    pub(super) size: MazeSize,
    pub(super) maze: Option<Maze>,
}

/// Reads a recording as far as it is whole. `take` is given each state with the nanoseconds since
/// 1970 at which it was recorded; its error ends the reading.
pub(super) fn read_states(
    mut source: impl Read,
    take: impl FnMut(&Description, &[u8], u64) -> Result<(), NoRecording>,
) -> Result<(Description, Ending), NoRecording> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_CHUNK_BYTES)
        // A chunk that contradicts itself makes mcap 0.26 panic, so they are unpacked here.
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut assembly = Assembly {
        description: None,
        states: BTreeSet::new(),
        mazes: BTreeSet::new(),
        unpacked: 0,
        read: 0,
        take,
    };
    // Bytes read, and how many of them are records that make sense. No more is ever read than
    // what the next record needs.
    let (mut length, mut whole) = (0, 0);
    let ending = loop {
        match reader.next_event() {
            None => break Ending::Closed,
            Some(Ok(LinearReadEvent::ReadRequest(need))) => {
                // The buffer grows with what has come, up to twice what is needed.
                if need > STEP_BYTES && !memory::is_available(2 * need) {
                    return Err(NoRecording::OutOfMemory);
                }
                let count = source.read(reader.insert(need.min(STEP_BYTES)))?;
                reader.notify_read(count);
                length += count as u64;
                assembly.read = length;
            }
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                if let Err(reason) = assembly.take(opcode, data)? {
                    break Ending::Damaged { whole, reason };
                }
                whole = length;
            }
            Some(Err(McapError::UnexpectedEof)) => break Ending::Cut { whole, length },
            Some(Err(McapError::BadMagic)) if whole == 0 => return Err(NoRecording::NoMcap),
            Some(Err(error)) => {
                break Ending::Damaged { whole, reason: Escaped(error).to_string() };
            }
        }
    };
    let Some(description) = assembly.description else {
        let (at, found) = match ending {
            Ending::Closed | Ending::Cut { .. } => (length, "the end of the file".into()),
            Ending::Damaged { whole, reason } => (whole, reason),
        };
        return Err(NoRecording::NoDescription { at, found });
    };
    Ok((description, ending))
}

/// A recording that is read record by record.
struct Assembly<T> {
    description: Option<Description>,
    /// The channels that carry states, and those that carry the maze.
    states: BTreeSet<u16>,
    mazes: BTreeSet<u16>,
    /// How many bytes were unpacked from chunks.
    unpacked: u64,
    /// How many bytes of the file were read.
    read: u64,
    take: T,
}

impl<T: FnMut(&Description, &[u8], u64) -> Result<(), NoRecording>> Assembly<T> {
    /// Takes a record of any kind; the inner error says what is wrong with it.
    fn take(&mut self, opcode: u8, body: &[u8]) -> Result<Result<(), String>, NoRecording> {
        if opcode != op::CHUNK {
            return self.take_plain(opcode, body);
        }
        if !memory::is_available(MAX_CHUNK_BYTES) {
            return Err(NoRecording::OutOfMemory);
        }
        let records = match chunk::unpack(body, MAX_CHUNK_BYTES) {
            Ok(records) => records,
            Err(reason) => return Ok(Err(reason)),
        };
        self.unpacked += records.len() as u64;
        let most = MAX_UNPACKED_BYTES + MAX_UNPACKED_FOR_EACH * self.read;
        if self.unpacked > most {
            return Ok(Err(format!("chunks of more than {most} bytes")));
        }
        for record in chunk::records(&records) {
            match record.map(|(opcode, body)| self.take_plain(opcode, body)) {
                Ok(Ok(Ok(()))) => {}
                Ok(result) => return result,
                Err(reason) => return Ok(Err(reason)),
            }
        }
        Ok(Ok(()))
    }

    /// Takes a record that is no chunk.
    fn take_plain(&mut self, opcode: u8, body: &[u8]) -> Result<Result<(), String>, NoRecording> {
        // Of the other kinds nothing is needed.
        let most = match opcode {
            op::METADATA | op::CHANNEL => MAX_DESCRIPTION_BYTES,
            op::MESSAGE => MAX_CHUNK_BYTES,
            _ => return Ok(Ok(())),
        };
        if body.len() > most {
            return Ok(Ok(()));
        }
        if !strings_fit(opcode, body) {
            return Ok(Err("a length goes beyond the end of its record".into()));
        }
        match (mcap::parse_record(opcode, body), &mut self.description) {
            (Ok(Record::Metadata(record)), None) if record.name == METADATA => {
                let get = |key| record.metadata.get(key).map(String::as_str);
                self.description = Some(describe(get(INFO), get(MAZE))?);
            }
            (Ok(Record::Channel(channel)), _) => {
                match [&*channel.topic, &*channel.message_encoding] {
                    STATES => self.states.insert(channel.id),
                    MAZES => self.mazes.insert(channel.id),
                    _ => false,
                };
            }
            (Ok(Record::Message { header, data }), Some(description))
                if self.mazes.contains(&header.channel_id)
                    && description.maze.is_none()
                    && data.len() <= MAX_DESCRIPTION_BYTES =>
            {
                description.maze = Some(read_maze(&data, description.size)?);
            }
            (Ok(Record::Message { header, data }), Some(description))
                if self.states.contains(&header.channel_id) =>
            {
                match Request::decode(&data, description.size) {
                    Ok(Request::State(_)) => {
                        (self.take)(description, &data, header.log_time)?;
                    }
                    Ok(_) => return Ok(Err("expected a state, found another request".into())),
                    Err(error) => return Ok(Err(error.to_string())),
                }
            }
            (Ok(_), _) => {}
            (Err(error), _) => return Ok(Err(Escaped(error).to_string())),
        }
        Ok(Ok(()))
    }
}

/// Whether each string in a record of metadata or a channel ends inside of the record. For one
/// that does not, mcap reserves as many bytes as its length says, up to 4 GiB, before it finds out.
fn strings_fit(opcode: u8, body: &[u8]) -> bool {
    let fit = || {
        let rest = match opcode {
            op::METADATA => after_string(body)?,
            // Behind two numbers of two bytes each.
            op::CHANNEL => after_string(after_string(body.get(4..)?)?)?,
            _ => return Some(()),
        };
        let (length, map) = rest.split_first_chunk()?;
        let mut map = map.get(..usize::try_from(u32::from_le_bytes(*length)).ok()?)?;
        while !map.is_empty() {
            map = after_string(after_string(map)?)?;
        }
        Some(())
    };
    fit().is_some()
}

/// What follows the string at the beginning, which stands behind its length in bytes.
fn after_string(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
}

/// Reads what a recording says of its simulation.
fn describe(info: Option<&str>, maze: Option<&str>) -> Result<Description, NoRecording> {
    let wrong = |what: String| NoRecording::Description(what);
    let info = info.ok_or_else(|| wrong("info is missing".into()))?;
    let info: Info =
        serde_json::from_str(info).map_err(|error| wrong(format!("info is no JSON: {error}")))?;
    let sides = (info.width, info.height);
    let size = info.size().ok_or_else(|| {
        wrong(format!("the maze has {}x{} cells, not 1x1 to 32x32", sides.0, sides.1))
    })?;
    if info.start_pose().is_none_or(|start| !size.contains(start.cell)) {
        return Err(wrong(format!("the start is none in a maze of {size} cells")));
    }
    let maze = maze.map(|text| read_maze(text.as_bytes(), size)).transpose()?;
    let info = Info { name: Escaped(&info.name).to_string(), ..info };
    Ok(Description { info, size, maze })
}

/// Reads a maze, drawn, of which the states have this size.
fn read_maze(text: &[u8], size: MazeSize) -> Result<Maze, NoRecording> {
    let wrong = |what: String| NoRecording::Description(what);
    let maze = String::from_utf8_lossy(text).parse();
    let maze: Maze = maze.map_err(|error| wrong(format!("the maze is none: {error}")))?;
    if maze.size() != size {
        let other = maze.size();
        return Err(wrong(format!("the maze has {other} cells, but the states have {size}")));
    }
    Ok(maze)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use mcap::records::MessageHeader;
    use mmsim_protocol::MazeSize;

    use super::*;
    use crate::{Recording, RecordingWriter, Simulation};

    const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

    fn state(number: u8) -> Vec<u8> {
        [b"S\x00\x00NC\x01".to_vec(), vec![number], b"C\x0d\x00".to_vec()].concat()
    }

    /// The bytes of a recording of so many states.
    fn recorded(states: u8) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let simulation = Simulation::new("small", MAZE.parse().unwrap());
        let mut writer =
            RecordingWriter::create(&path, &simulation.info(), Some(simulation.maze())).unwrap();
        for number in 0..states {
            writer.write(&state(number)).unwrap();
        }
        writer.close().unwrap();
        fs::read(&path).unwrap()
    }

    #[test]
    fn a_recording_is_read_as_it_was_written() {
        let recording = Recording::read(&recorded(200)[..]).unwrap();
        assert_eq!(recording.maze().unwrap().to_string(), MAZE);
        let size = MazeSize::new(2, 1).unwrap();
        assert_eq!((recording.info().states, recording.size()), (200, size));
        assert_eq!(recording.info().name, "small");
        assert!(recording.history().iter().eq((0..200).map(state)));
        assert!(recording.times().iter().is_sorted() && recording.times().len() == 200);
        assert_eq!(*recording.ending(), Ending::Closed);
    }

    #[test]
    fn cut_at_any_byte_it_shows_the_whole_states_or_says_what_is_missing() {
        let bytes = recorded(5);
        // Where each state ends: its bytes are at the end of its record.
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
                    let Ending::Cut { whole, length: found } = *recording.ending() else {
                        panic!("{length} bytes: {:?}", recording.ending())
                    };
                    assert_eq!(found, length as u64);
                    assert!(
                        whole <= found
                            && ends.iter().all(|&end| end > length || end as u64 <= whole)
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
        assert_eq!(*Recording::read(&bytes[..]).unwrap().ending(), Ending::Closed);
    }

    #[test]
    fn any_changed_byte_gives_states_or_an_error() {
        let bytes = recorded(3);
        let mut noticed = 0;
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x55;
            match Recording::read(&changed[..]) {
                Ok(recording) => noticed += usize::from(*recording.ending() != Ending::Closed),
                Err(_) => noticed += 1,
            }
        }
        assert!(noticed > bytes.len() / 2, "{noticed} of {}", bytes.len());
    }

    /// Found by fuzzing: memory was reserved for as much as a length promised.
    #[test]
    fn a_length_beyond_its_record_is_told_before_it_is_believed() {
        for (string, described) in [(&b"\x05\0\0\0mmsim"[..], false), (b"\x06\0\0\0/state", true)] {
            let mut bytes = recorded(1);
            let at = bytes.windows(string.len()).position(|bytes| bytes == string).unwrap();
            bytes[at + 3] = 0xff;
            let wrong = "a length goes beyond the end of its record";
            match Recording::read(&bytes[..]) {
                Ok(recording) => {
                    assert!(described);
                    assert!(recording.history().is_empty());
                    assert!(
                        matches!(recording.ending(), Ending::Damaged { reason, .. } if reason == wrong)
                    );
                }
                Err(error) => assert!(!described && error.to_string().contains(wrong), "{error}"),
            }
        }
    }

    /// Found by fuzzing: the name of a compression went to the terminal as it stood in the file.
    #[test]
    fn what_a_damaged_file_says_is_escaped() {
        let mut bytes = recorded(0);
        let data_end =
            bytes.windows(9).position(|bytes| bytes == b"\x0f\x04\0\0\0\0\0\0\0").unwrap();
        bytes.truncate(data_end);
        // A chunk: its length, 28 bytes of times, length and checksum, and the compression's name.
        bytes.extend([6, 44, 0, 0, 0, 0, 0, 0, 0]);
        bytes.extend([[0; 28].as_slice(), &[4, 0, 0, 0], b"\x1b[2J", &[0; 8]].concat());
        let recording = Recording::read(&bytes[..]).unwrap();
        let Ending::Damaged { reason, .. } = recording.ending() else { panic!("{recording:?}") };
        insta::assert_snapshot!(reason, @r#"a chunk packed with "\x1b[2J""#);
    }

    #[test]
    fn what_is_no_recording_is_told() {
        let error = |bytes: &[u8]| Recording::read(bytes).unwrap_err().to_string();
        insta::assert_snapshot!(error(b""), @"expected a recording's description of its maze, found the end of the file at byte 0");
        insta::assert_snapshot!(error(b"o---o---o\n"), @"expected a recording, which is an MCAP file, found something else at byte 0");
        let other = |description: &[(&str, &str)]| {
            let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
            let metadata = description.iter().map(|&(key, text)| (key.into(), text.into()));
            let name = METADATA.into();
            let metadata = mcap::records::Metadata { name, metadata: metadata.collect() };
            mcap.write_metadata(&metadata).unwrap();
            mcap.finish().unwrap();
            error(&mcap.into_inner().into_inner())
        };
        let info = |width: u8, start: u8| {
            format!(
                r#"{{"name":"","width":{width},"height":1,"start":[{start},0],"heading":"N","goals":[],"states":0,"protocol":1}}"#
            )
        };
        insta::assert_snapshot!(other(&[]), @"expected a recording's description of its maze, found one in which info is missing");
        insta::assert_snapshot!(other(&[("info", "{}")]), @"expected a recording's description of its maze, found one in which info is no JSON: missing field `name` at line 1 column 2");
        insta::assert_snapshot!(other(&[("info", &info(40, 0))]), @"expected a recording's description of its maze, found one in which the maze has 40x1 cells, not 1x1 to 32x32");
        insta::assert_snapshot!(other(&[("info", &info(2, 2))]), @"expected a recording's description of its maze, found one in which the start is none in a maze of 2x1 cells");
        insta::assert_snapshot!(other(&[("info", &info(2, 0)), ("maze", "rubbish")]), @r#"expected a recording's description of its maze, found one in which the maze is none: line 1, column 1: expected a row of posts and walls such as "o---o---o", found "rubbish""#);
        insta::assert_snapshot!(other(&[("info", &info(3, 0)), ("maze", MAZE)]), @"expected a recording's description of its maze, found one in which the maze has 2x1 cells, but the states have 3x1");
    }

    #[test]
    fn a_file_that_another_tool_packed_is_read_as_well() {
        let mut mcap = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let simulation = Simulation::new("small", MAZE.parse().unwrap());
        let info = serde_json::to_string(&simulation.info()).unwrap();
        let metadata = [(INFO.into(), info)].into();
        mcap.write_metadata(&mcap::records::Metadata { name: METADATA.into(), metadata }).unwrap();
        let [topic, encoding] = STATES;
        let channel_id = mcap.add_channel(0, topic, encoding, &[].into()).unwrap();
        let other = mcap.add_channel(0, "/other", encoding, &[].into()).unwrap();
        for number in 0..100 {
            let time = 7 + u64::from(number);
            let sequence = number.into();
            let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
            mcap.write_to_known_channel(&header, &state(number)).unwrap();
            mcap.write_to_known_channel(&MessageHeader { channel_id: other, ..header }, b"?")
                .unwrap();
        }
        mcap.finish().unwrap();
        let recording = Recording::read(&mcap.into_inner().into_inner()[..]).unwrap();
        assert!(recording.history().iter().eq((0..100).map(state)));
        assert_eq!((recording.times().last(), recording.maze()), (Some(106), None));
        assert_eq!(*recording.ending(), Ending::Closed);
    }
}
