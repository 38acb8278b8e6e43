//! Names in the MCAP file of a recording. docs/recordings.md describes the file.

/// Name of the metadata record that describes the simulation.
pub(crate) const METADATA: &str = "mmsim";

/// Metadata key of the reply to `info`, as JSON.
pub(crate) const INFO: &str = "info";

/// Metadata key of the protocol version, for other tools.
pub(crate) const PROTOCOL: &str = "protocol";

/// Metadata key of the true maze as text, in recordings of earlier versions.
pub(crate) const MAZE: &str = "maze";

/// Topic and message encoding of the channel of states. A message is the bytes of `S`.
pub(crate) const STATES: [&str; 2] = ["/state", "mmsim-state"];

/// Topic and message encoding of the channel whose only message is the true maze as text.
///
/// A client does not know the maze, so its recordings lack this channel. The maze is not metadata
/// because metadata is never compressed.
pub(crate) const MAZES: [&str; 2] = ["/maze", "mmsim-maze"];
