//! The names used in the MCAP file of a recording; see docs/recordings.md.

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

/// The topic and message encoding of the channel whose only message is the true maze as text.
///
/// Recordings made by clients lack this channel, because clients do not know the true maze. The
/// maze is not stored as metadata because metadata is never compressed.
pub(crate) const MAZES: [&str; 2] = ["/maze", "mmsim-maze"];

/// The message encoding of the channels for other tools, and the encoding of their schemas. mmsim
/// does not read these channels.
pub(crate) const JSON: &str = "json";
pub(crate) const JSON_SCHEMA: &str = "jsonschema";
