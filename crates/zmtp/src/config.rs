//! The limits of servers and clients, which their users can set. No peer can make them use more
//! memory than these limits allow.

use std::time::Duration;

/// The upper limit for the limits in bytes.
const MAX_BYTES: u128 = 1 << 30;
/// The upper limit for times, in milliseconds: a day.
const MAX_MS: u128 = 24 * 60 * 60 * 1000;
/// A READY command is usually about 40 bytes long, or about 300 bytes with the longest identity.
const MIN_COMMAND_BYTES: u128 = 320;
/// The range of keepalive times that all operating systems accept, in milliseconds.
const KEEPALIVE_MS: [u128; 2] = [1000, 32_767_000];

/// The limits of a server.
///
/// ```
/// use std::time::Duration;
///
/// use mmsim_zmtp::{RepServer, ServerConfig, listen};
///
/// let config = ServerConfig {
///     max_connections: 20,
///     handshake_time: Duration::from_secs(2),
///     ..ServerConfig::DEFAULT
/// };
/// let server = RepServer::with_config(listen("127.0.0.1", 0)?, config)?;
///
/// let impossible = ServerConfig { max_connections: 0, ..ServerConfig::DEFAULT };
/// let error = impossible.check().unwrap_err().to_string();
/// assert_eq!(error, "expected max_connections from 1 to 1000000, found 0");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServerConfig {
    /// The maximum length of a request frame, in bytes; 64 KiB by default. The server skips a frame
    /// that exceeds this limit, and sends one error reply. The server disconnects the client unless
    /// the client sends another request within [`oversized_time`](Self::oversized_time). If an
    /// oversized frame arrives before the empty delimiter frame, no reply is possible, and the
    /// server disconnects the client immediately.
    pub max_request_bytes: usize,
    /// The maximum time between an oversized frame and the client's next request; 1 s by default.
    pub oversized_time: Duration,
    /// The maximum length of a request's address envelope, in bytes; 4 KiB by default. The envelope
    /// consists of all frames up to and including the empty delimiter frame, with their headers. A
    /// REQ socket sends no address frames, but a proxy adds one. Including its header, an address
    /// frame is usually 7 and at most 264 bytes long. The reply repeats the envelope.
    pub max_envelope_bytes: usize,
    /// The maximum length of a ZMTP command, in bytes; 4 KiB by default. A READY command is at most
    /// about 300 bytes long, and a PING command 24 bytes.
    pub max_command_bytes: usize,
    /// The maximum number of bytes of a frame that the server stores while the frame arrives; 4 KiB
    /// by default. In a longer frame, the server replaces the bytes beyond this limit with zeros
    /// before it passes the frame to the [`Service`](crate::Service).
    pub max_kept_bytes: usize,
    /// The maximum number of connections; 1,000 by default. If another client connects when this
    /// limit is reached, the server either closes an existing connection or turns the new client
    /// away; see [`silence`](Self::silence). A process can usually have 1,024 files open, so 1,000
    /// connections leave room for other files.
    pub max_connections: usize,
    /// How long a connection must be silent before the server may close it to make room for a new
    /// client; 10 s by default.
    ///
    /// When a client connects to a server that already has
    /// [`max_connections`](Self::max_connections) connections, the server chooses a connection to
    /// close: the one that has been silent the longest among those without activity (see
    /// [`Service::answer`](crate::Service::answer)) or, if there are none, among all connections. If
    /// the chosen connection has been silent for less than this time, the new client is turned away
    /// instead. However, if more than half of all connections belong to one network (an IPv4 address
    /// or an IPv6 /64 prefix) and the new client does not, the server closes a connection from that
    /// network. A client that loses its connection can reconnect; `ZeroMQ` sockets do so
    /// automatically.
    pub silence: Duration,
    /// The maximum time from accepting a connection to the end of its handshake; 10 s by default. On
    /// a bad network, a handshake can take several seconds.
    pub handshake_time: Duration,
    /// The maximum size of the pending replies to one client, in bytes, not counting the buffers of
    /// the operating system; 64 KiB by default. When this limit is reached, the server discards no
    /// replies, but handles no further requests until the client has read some of the replies.
    pub max_waiting_reply_bytes: usize,
    /// The operating system sends TCP keepalive probes on connections that have been idle this long;
    /// 60 s by default. The operating system counts in whole seconds.
    pub keepalive: Duration,
}

impl ServerConfig {
    /// The default limits.
    pub const DEFAULT: Self = Self {
        max_request_bytes: 64 * 1024,
        oversized_time: Duration::from_secs(1),
        max_envelope_bytes: 4 * 1024,
        max_command_bytes: 4 * 1024,
        max_kept_bytes: 4 * 1024,
        max_connections: 1000,
        silence: Duration::from_secs(10),
        handshake_time: Duration::from_secs(10),
        max_waiting_reply_bytes: 64 * 1024,
        keepalive: Duration::from_secs(60),
    };

    /// Checks that a server with these limits can work.
    ///
    /// # Errors
    /// Returns the first limit that is outside its range.
    pub const fn check(&self) -> Result<(), ConfigError> {
        check_ranges(&[
            ("max_request_bytes", self.max_request_bytes as u128, [1, MAX_BYTES]),
            ("oversized_time in ms", self.oversized_time.as_millis(), [0, MAX_MS]),
            // The empty delimiter frame.
            ("max_envelope_bytes", self.max_envelope_bytes as u128, [2, MAX_BYTES]),
            ("max_command_bytes", self.max_command_bytes as u128, [MIN_COMMAND_BYTES, MAX_BYTES]),
            ("max_kept_bytes", self.max_kept_bytes as u128, [1, MAX_BYTES]),
            ("max_connections", self.max_connections as u128, [1, 1_000_000]),
            ("silence in ms", self.silence.as_millis(), [0, MAX_MS]),
            ("handshake_time in ms", self.handshake_time.as_millis(), [1, MAX_MS]),
            ("max_waiting_reply_bytes", self.max_waiting_reply_bytes as u128, [1, MAX_BYTES]),
            ("keepalive in ms", self.keepalive.as_millis(), KEEPALIVE_MS),
        ])
    }
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The limits of a client.
///
/// ```
/// use mmsim_zmtp::{ClientConfig, ReqClient};
///
/// let config = ClientConfig { max_reply_bytes: 4096, ..ClientConfig::DEFAULT };
/// let client = ReqClient::with_config("tcp://127.0.0.1:6574".parse()?, config)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientConfig {
    /// The maximum length of a reply that the client accepts, in bytes; 1 MiB by default. The length
    /// includes the headers of all frames. A longer reply is an error.
    pub max_reply_bytes: usize,
    /// The maximum length of a ZMTP command, in bytes; 4 KiB by default.
    pub max_command_bytes: usize,
    /// The time between two attempts to connect to a server that is not running; 100 ms by default.
    pub retry_interval: Duration,
    /// The maximum time from an attempt to connect to the end of the handshake; 10 s by default. The
    /// client then connects again.
    pub handshake_time: Duration,
    /// The operating system sends TCP keepalive probes on connections that have been idle this long;
    /// 60 s by default. The operating system counts in whole seconds.
    pub keepalive: Duration,
}

impl ClientConfig {
    /// The default limits.
    pub const DEFAULT: Self = Self {
        max_reply_bytes: 1024 * 1024,
        max_command_bytes: 4 * 1024,
        retry_interval: Duration::from_millis(100),
        handshake_time: Duration::from_secs(10),
        keepalive: Duration::from_secs(60),
    };

    /// Checks that a client with these limits can work.
    ///
    /// # Errors
    /// Returns the first limit that is outside its range.
    pub const fn check(&self) -> Result<(), ConfigError> {
        check_ranges(&[
            // An empty reply, which has two frames.
            ("max_reply_bytes", self.max_reply_bytes as u128, [4, MAX_BYTES]),
            ("max_command_bytes", self.max_command_bytes as u128, [MIN_COMMAND_BYTES, MAX_BYTES]),
            ("retry_interval in ms", self.retry_interval.as_millis(), [1, MAX_MS]),
            ("handshake_time in ms", self.handshake_time.as_millis(), [1, MAX_MS]),
            ("keepalive in ms", self.keepalive.as_millis(), KEEPALIVE_MS),
        ])
    }
}

impl Default for ClientConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A limit with which a server or a client could not work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {limit} from {min} to {max}, found {found}")]
#[non_exhaustive]
pub struct ConfigError {
    /// The name of the limit, and its unit if it is a time.
    pub limit: &'static str,
    /// The smallest possible value.
    pub min: u128,
    /// The largest possible value.
    pub max: u128,
    /// The value of the limit.
    pub found: u128,
}

impl From<ConfigError> for std::io::Error {
    fn from(error: ConfigError) -> Self {
        Self::new(std::io::ErrorKind::InvalidInput, error)
    }
}

/// Checks limits, each with its name, value and range.
const fn check_ranges(limits: &[(&'static str, u128, [u128; 2])]) -> Result<(), ConfigError> {
    let mut rest = limits;
    while let [(limit, found, [min, max]), others @ ..] = rest {
        if *found < *min || *found > *max {
            return Err(ConfigError { limit, min: *min, max: *max, found: *found });
        }
        rest = others;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_ranges() {
        let default = ServerConfig::default();
        assert_eq!(default.check(), Ok(()));
        for (config, error) in [
            (
                ServerConfig { max_command_bytes: 319, ..default },
                "expected max_command_bytes from 320 to 1073741824, found 319",
            ),
            (
                ServerConfig { max_request_bytes: 2 << 30, ..default },
                "expected max_request_bytes from 1 to 1073741824, found 2147483648",
            ),
            (
                ServerConfig { handshake_time: Duration::ZERO, ..default },
                "expected handshake_time in ms from 1 to 86400000, found 0",
            ),
            (
                ServerConfig { keepalive: Duration::from_millis(999), ..default },
                "expected keepalive in ms from 1000 to 32767000, found 999",
            ),
        ] {
            assert_eq!(config.check().unwrap_err().to_string(), error);
        }
        let default = ClientConfig::default();
        assert_eq!(default.check(), Ok(()));
        let config = ClientConfig { retry_interval: Duration::ZERO, ..default };
        let error = "expected retry_interval in ms from 1 to 86400000, found 0";
        assert_eq!(config.check().unwrap_err().to_string(), error);
    }
}
