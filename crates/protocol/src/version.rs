//! Constants of the protocol.

/// Version of the protocol, as in the reply to `info`.
pub const PROTOCOL_VERSION: u32 = 1;

/// Default TCP port of simulators.
pub const DEFAULT_PORT: u16 = 6574;
