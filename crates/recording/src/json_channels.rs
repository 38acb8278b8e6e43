//! Writes channels of JSON messages, which other tools can show; see docs/recordings.md.

use std::io::{self, Write};

use mmsim_maze::Maze;
use mmsim_protocol::Info;
use serde::Serialize;
use serde_json::Value;

use crate::layout::{JSON, JSON_SCHEMA, MOUSE_SCHEMA, MOUSE_TOPIC, POSE_TOPIC, SCENE_TOPIC};
use crate::mcap_writer::{McapWriter, MessageHeader};
use crate::mouse_message::{self, MouseMessage};
use crate::mouse_tracker::MouseTracker;
use crate::scene::{POSE_SCHEMA, PoseMessage, SCENE_SCHEMA, maze_message};

/// The channels of JSON messages of a recording.
pub(crate) struct JsonChannels {
    tracker: MouseTracker,
    mouse: u16,
    pose: u16,
    /// The message that is being written.
    message: Vec<u8>,
}

impl JsonChannels {
    /// Adds the channels, and writes the picture of the maze, if it is known. Returns `None` if the
    /// description is invalid.
    pub(crate) fn add<W: Write>(
        mcap: &mut McapWriter<W>,
        info: &Info,
        maze: Option<&Maze>,
        start: u64,
    ) -> io::Result<Option<Self>> {
        let Some(tracker) = MouseTracker::new(info, maze) else { return Ok(None) };
        let mouse = add_channel(mcap, MOUSE_TOPIC, [MOUSE_SCHEMA, mouse_message::SCHEMA])?;
        let pose = add_channel(mcap, POSE_TOPIC, POSE_SCHEMA)?;
        let mut channels = Self { tracker, mouse, pose, message: Vec::new() };
        if let Some(maze) = maze {
            let scene = add_channel(mcap, SCENE_TOPIC, SCENE_SCHEMA)?;
            let header = MessageHeader { channel: scene, sequence: 0, time: start };
            channels.put(mcap, header, &maze_message(maze, start))?;
        }
        Ok(Some(channels))
    }

    /// Writes the messages about a state and the update that precedes it.
    pub(crate) fn write<W: Write>(
        &mut self,
        mcap: &mut McapWriter<W>,
        (sequence, time): (u32, u64),
        update: &[u8],
        state: &[u8],
    ) -> io::Result<()> {
        let Some(figures) = self.tracker.add(update, state) else { return Ok(()) };
        let pose = PoseMessage::new(figures.pose, time);
        let header = |channel| MessageHeader { channel, sequence, time };
        self.put(mcap, header(self.mouse), &MouseMessage::from(figures))?;
        self.put(mcap, header(self.pose), &pose)
    }

    fn put<W: Write>(
        &mut self,
        mcap: &mut McapWriter<W>,
        header: MessageHeader,
        message: &impl Serialize,
    ) -> io::Result<()> {
        self.message.clear();
        serde_json::to_writer(&mut self.message, message)?;
        mcap.write(header, &self.message)
    }
}

/// Adds a channel of JSON messages with a schema, which is stored without whitespace.
fn add_channel<W: Write>(
    mcap: &mut McapWriter<W>,
    topic: &str,
    [name, schema]: [&str; 2],
) -> io::Result<u16> {
    let schema: Value = serde_json::from_str(schema)?;
    let schema = mcap.add_schema(name, JSON_SCHEMA, &schema.to_string())?;
    mcap.add_channel(schema, [topic, JSON])
}
