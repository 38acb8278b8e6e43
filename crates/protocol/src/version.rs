//! The version and the default port of the protocol.

/// The version of the protocol, which is part of the reply to `info`.
pub const PROTOCOL_VERSION: u32 = 1;

/// The default TCP port of a simulator.
pub const DEFAULT_PORT: u16 = 6574;
