//! The limits for every client. No client can make the server use more memory than these limits
//! allow.

use std::time::Duration;

/// The maximum length of a request frame, in bytes. The server skips a longer frame and sends one
/// error reply. The server disconnects the client unless a request follows within
/// [`OVERSIZED_TIME`]. If the long frame arrives before an empty delimiter frame, no reply is
/// possible, and the client is disconnected immediately.
pub const MAX_REQUEST_BYTES: usize = 64 * 1024;

/// The time after which a client is disconnected if no request follows an oversized frame.
pub const OVERSIZED_TIME: Duration = Duration::from_secs(1);

/// The maximum length of the address envelope of a request, in bytes as received. The envelope
/// contains the frames up to the empty delimiter frame. Proxies add address frames, which the reply
/// repeats. A REQ socket sends no address frames; a proxy usually adds 7 bytes, and at most 264.
pub const MAX_ENVELOPE_BYTES: usize = 4 * 1024;

/// The maximum length of a ZMTP command, in bytes. A READY command usually has about 40 bytes, and
/// 300 with the longest identity. A PING command has at most 24 bytes.
pub const MAX_COMMAND_BYTES: usize = 4 * 1024;

/// The maximum number of bytes that the server keeps of a frame. A [`Service`](crate::Service) gets
/// a longer frame with zeros in place of the bytes beyond this limit.
pub const MAX_KEPT_BYTES: usize = 4 * 1024;

/// The maximum number of connections. When this limit is reached, a new client replaces another
/// connection or is turned away; see [`SILENCE`]. A process can usually open 1,024 files, so 1,000
/// connections leave room for other files.
pub const MAX_CONNECTIONS: usize = 1000;

/// The time of silence after which a connection may be closed to make room for a new client.
///
/// When the server has reached [`MAX_CONNECTIONS`], a new client replaces a connection without any
/// request that counts as activity. If there is no such connection, the new client replaces the
/// connection that has been silent for longest. If the connection to replace has been silent for
/// less than this time, the new client is turned away. There is one exception: if one network (an
/// IPv4 address, or a /64 of IPv6) has more than half of all connections, a new client from another
/// network replaces one of them. `ZeroMQ` sockets reconnect automatically.
pub const SILENCE: Duration = Duration::from_secs(10);

/// The maximum duration of a handshake, measured from the acceptance of the connection. On a bad
/// network, a handshake can take several seconds.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(10);

/// The maximum size of the replies that wait for one client, in bytes, not counting the buffers of
/// the operating system. When this limit is reached, the server reads no further requests from the
/// client until the client reads replies. No reply is lost.
pub const MAX_WAITING_REPLY_BYTES: usize = 64 * 1024;
