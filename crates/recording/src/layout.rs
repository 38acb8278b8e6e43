//! The names in the MCAP file of a recording, which docs/recordings.md describes.

/// The name of the metadata record that describes the simulation.
pub(crate) const METADATA: &str = "mmsim";

/// The metadata key of the reply to `info` as JSON.
pub(crate) const INFO: &str = "info";

/// The metadata key of the protocol version, which only other tools read.
pub(crate) const PROTOCOL: &str = "protocol";

/// The metadata key of the true maze as text in recordings of earlier versions.
pub(crate) const MAZE: &str = "maze";

/// The topic and message encoding of the channel for states. Each message holds one state.
pub(crate) const STATES: [&str; 2] = ["/state", "mmsim-state"];

/// The topic and message encoding of the channel whose only message is the true maze as text.
///
/// Clients do not know the true maze, so their recordings lack this channel. The maze is not stored
/// as metadata because metadata is never compressed.
pub(crate) const MAZES: [&str; 2] = ["/maze", "mmsim-maze"];
