//! Messages about the states of a recording for other tools; see docs/recordings.md.

use std::io::{self, Write};

use mmsim_maze::{Maze, MazeSize};
use mmsim_protocol::Info;
use serde_json::Value;

use crate::history::scan::{ScannedState, StateCursor};
use crate::mcap::writer::{McapWriter, MessageHeader};
use crate::recording::layout::{JSON, JSON_SCHEMA};

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
