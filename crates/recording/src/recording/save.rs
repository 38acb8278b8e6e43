//! Writes the records of a recording, with messages for other tools; see docs/recordings.md.

use std::io::{self, Write};

use mmsim_maze::{Maze, MazeSize};
use mmsim_protocol::Info;
use serde_json::Value;

use crate::context::notes::Notes;
use crate::context::update::{StoredUpdate, TrailingAnnotations};
use crate::history::block::{ScannedState, StateCursor};
use crate::mcap::writer::{McapWriter, MessageHeader};
use crate::recording::format::{
    ANNOTATIONS, INFO, JSON, JSON_SCHEMA, MAZES, METADATA, MOUSE, MOUSE_KEYS, PROTOCOL, STATES,
    UPDATES,
};

/// The size of a message without its data, in bytes.
pub(crate) const MESSAGE_BYTES: usize = 31;

/// Writes the description, the maze and the states of a recording.
pub(crate) struct RecordWriter<W> {
    mcap: McapWriter<W>,
    states_channel: u16,
    /// The channels that are added when they are needed.
    channels: Vec<([&'static str; 2], u16)>,
    pub(crate) states: u32,
    /// The time of the newest state.
    newest: u64,
    size: Option<MazeSize>,
    /// The messages for other tools, if there are any.
    messages: Option<MessageWriter>,
}

impl<W: Write> RecordWriter<W> {
    /// Writes the description of the simulation, its true maze, if known, and the messages for other
    /// tools before the first state, if there are any. The recording begins at the time `start`, in
    /// nanoseconds since 1970 (UTC). Until a compressed recording is finished, the newest states may
    /// be missing from it.
    pub(crate) fn new(
        to: W,
        is_compressed: bool,
        info: &Info,
        maze: Option<&Maze>,
        start: u64,
        messages: Option<NewMessages>,
    ) -> io::Result<Self> {
        let messages = messages.and_then(|new| new(info, maze)).zip(info.size());
        let mut info = info.clone();
        info.states = 0;
        let json = serde_json::to_string(&info).map_err(io::Error::other)?;
        let library = concat!("mmsim ", env!("CARGO_PKG_VERSION"));
        let mut mcap = McapWriter::new(to, library, is_compressed)?;
        let protocol = info.protocol.to_string();
        mcap.write_metadata(METADATA, &[(INFO, &json), (PROTOCOL, &protocol)])?;
        let states_channel = mcap.add_channel(0, STATES)?;
        if let Some(maze) = maze {
            let channel = mcap.add_channel(0, MAZES)?;
            let header = MessageHeader { channel, sequence: 0, time: start };
            mcap.write(header, maze.to_string().as_bytes())?;
        }
        let add = |(messages, size)| MessageWriter::add(&mut mcap, messages, size, start);
        let messages = messages.map(add).transpose()?;
        let (size, channels) = (info.size(), Vec::new());
        Ok(Self { mcap, states_channel, channels, states: 0, newest: start, size, messages })
    }

    /// Appends a state that was received at `time`, in nanoseconds since 1970 (UTC), and the update
    /// that precedes it.
    pub(crate) fn write(&mut self, time: u64, update: &[u8], state: &[u8]) -> io::Result<()> {
        if !update.is_empty() {
            if self.states == 0 {
                self.write_names(update)?;
            }
            let channel = self.channel(UPDATES)?;
            self.mcap.write(MessageHeader { channel, sequence: self.states, time }, update)?;
        }
        let (channel, sequence) = (self.states_channel, self.states);
        self.mcap.write(MessageHeader { channel, sequence, time }, state)?;
        if let Some(messages) = &mut self.messages {
            messages.write(&mut self.mcap, (self.states, time), update, state)?;
        }
        self.states = self.states.wrapping_add(1);
        self.newest = time;
        Ok(())
    }

    /// Appends a request `A` that was received at `time`, like [`write`](Self::write).
    pub(crate) fn write_annotations(&mut self, time: u64, request: &[u8]) -> io::Result<()> {
        let (channel, sequence) = (self.channel(ANNOTATIONS)?, self.states);
        self.mcap.write(MessageHeader { channel, sequence, time }, request)
    }

    /// Appends the annotations after the last state, with the time of the last state.
    pub(crate) fn write_trailing(&mut self, trailing: &TrailingAnnotations) -> io::Result<()> {
        trailing.requests().try_for_each(|request| self.write_annotations(self.newest, &request))
    }

    /// Writes the names of the mouse and its strategy, if the update contains them.
    fn write_names(&mut self, update: &[u8]) -> io::Result<()> {
        let Some(size) = self.size else { return Ok(()) };
        let Ok(update) = StoredUpdate::decode(update, size) else { return Ok(()) };
        let mut notes = Notes::new(size);
        notes.apply_changes(update.changes);
        let names = MOUSE_KEYS.into_iter().zip([notes.mouse(), notes.strategy()]);
        let metadata: Vec<(&str, &str)> =
            names.filter_map(|(key, name)| Some((key, name?))).collect();
        if metadata.is_empty() {
            return Ok(());
        }
        self.mcap.write_metadata(MOUSE, &metadata)
    }

    /// Adds the channels for updates and annotations.
    pub(crate) fn add_channels(&mut self) -> io::Result<()> {
        self.channel(UPDATES)?;
        self.channel(ANNOTATIONS).map(drop)
    }

    /// Returns a channel. Adds it if it does not exist.
    fn channel(&mut self, names: [&'static str; 2]) -> io::Result<u16> {
        if let Some((_, channel)) = self.channels.iter().find(|(known, _)| *known == names) {
            return Ok(*channel);
        }
        let channel = self.mcap.add_channel(0, names)?;
        self.channels.push((names, channel));
        Ok(channel)
    }

    /// Returns true if an update and a state fit into an uncompressed recording of `limit` bytes.
    pub(crate) fn fits(&self, update: &[u8], state: &[u8], limit: u64) -> bool {
        let bytes = (2 * MESSAGE_BYTES + update.len() + state.len()) as u64;
        self.mcap.position().saturating_add(bytes) <= limit
    }

    /// Writes all records to the file, and ends the current chunk if chunks are enabled.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush()
    }

    /// Writes the summary.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.mcap.finish()
    }
}

/// Writes a compressed recording without messages for other tools, which takes about 20 bytes per state. See also
/// [`Recording::save`](crate::Recording::save).
///
/// `info` describes the simulation, and `maze` is its true maze, if known. Each item consists of the
/// time of a state in nanoseconds since 1970 (UTC), its update (see
/// [`States::update`](crate::States::update)) and its bytes. `trailing` follows the last state.
///
/// # Errors
/// The recording cannot be written to `to`.
pub fn save<U: AsRef<[u8]>, S: AsRef<[u8]>>(
    to: impl Write,
    info: &Info,
    maze: Option<&Maze>,
    states: impl IntoIterator<Item = (u64, U, S)>,
    trailing: &TrailingAnnotations,
) -> io::Result<()> {
    let mut states = states.into_iter().peekable();
    let start = states.peek().map_or(0, |&(time, ..)| time);
    let mut writer = RecordWriter::new(to, true, info, maze, start, None)?;
    for (time, update, state) in states {
        writer.write(time, update.as_ref(), state.as_ref())?;
    }
    writer.write_trailing(trailing)?;
    writer.finish()
}

/// Creates the messages about a recording from the description of the simulation and its true maze, if
/// known. Returns `None` if there is nothing to write.
pub type NewMessages = fn(&Info, Option<&Maze>) -> Option<Box<dyn StateMessages>>;

/// Messages in JSON about the states of a recording, which other tools can show. They are written when
/// a recording is compressed.
pub trait StateMessages: Send {
    /// Returns the channels of the messages.
    fn channels(&self) -> Vec<MessageChannel>;

    /// Writes the messages before the first state. `put` writes a message into the channel with an
    /// index, and `time` is in nanoseconds since 1970 (UTC).
    ///
    /// # Errors
    /// Returns the error of `put`.
    fn begin(&mut self, time: u64, put: PutMessage<'_>) -> io::Result<()>;

    /// Writes the messages about the next state, like [`begin`](Self::begin).
    ///
    /// # Errors
    /// Returns the error of `put`.
    fn add(&mut self, state: &ScannedState<'_>, time: u64, put: PutMessage<'_>) -> io::Result<()>;
}

/// Writes a message into the channel with an index.
pub type PutMessage<'p> = &'p mut dyn FnMut(usize, &[u8]) -> io::Result<()>;

/// A channel of messages.
#[derive(Clone, Copy, Debug)]
pub struct MessageChannel {
    /// The topic, such as `/mouse`.
    pub topic: &'static str,
    /// The name of the message type.
    pub name: &'static str,
    /// The JSON schema of the messages.
    pub schema: &'static str,
}

/// Writes the messages for other tools into a recording.
pub(crate) struct MessageWriter {
    messages: Box<dyn StateMessages>,
    channels: Vec<u16>,
    cursor: StateCursor,
}

impl MessageWriter {
    /// Adds the channels, and writes the messages before the first state. Schemas are stored without
    /// whitespace.
    pub(crate) fn add<W: Write>(
        mcap: &mut McapWriter<W>,
        mut messages: Box<dyn StateMessages>,
        size: MazeSize,
        time: u64,
    ) -> io::Result<Self> {
        let add = |MessageChannel { topic, name, schema }| -> io::Result<u16> {
            let schema: Value = serde_json::from_str(schema)?;
            let schema = mcap.add_schema(name, JSON_SCHEMA, &schema.to_string())?;
            mcap.add_channel(schema, [topic, JSON])
        };
        let channels: Vec<u16> =
            messages.channels().into_iter().map(add).collect::<Result<_, _>>()?;
        messages.begin(time, &mut |channel, message| {
            mcap.write(MessageHeader { channel: channels[channel], sequence: 0, time }, message)
        })?;
        Ok(Self { messages, channels, cursor: StateCursor::new(size) })
    }

    /// Writes the messages about a state and the update that precedes it.
    pub(crate) fn write<W: Write>(
        &mut self,
        mcap: &mut McapWriter<W>,
        (sequence, time): (u32, u64),
        update: &[u8],
        state: &[u8],
    ) -> io::Result<()> {
        let Self { messages, channels, cursor } = self;
        let Some(state) = cursor.advance(update, state) else { return Ok(()) };
        messages.add(&state, time, &mut |channel, message| {
            mcap.write(MessageHeader { channel: channels[channel], sequence, time }, message)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;
    use crate::recording::reader::Integrity;

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
            let states = (0..count).map(state).map(|(time, state)| (time, [], state));
            save(&mut file, &info, Some(&maze), states, &TrailingAnnotations::default()).unwrap();
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
