//! The limits for every client. No client can make the server hold more than they allow.

use std::time::Duration;

/// The maximum length of a frame of a request, in bytes. A longer frame is skipped and refused with
/// one reply; its sender is disconnected unless a request follows within [`OVERSIZED_TIME`]. Without an
/// empty delimiter frame no reply is possible: the sender is disconnected at once.
pub const MAX_REQUEST_BYTES: usize = 64 * 1024;

/// How long a connection stays open after a frame over the limit unless a request follows.
pub const OVERSIZED_TIME: Duration = Duration::from_secs(1);

/// The maximum length of the address envelope of a request, in bytes as received: the frames before
/// the empty delimiter frame. Proxies add them, and they return with the reply. A REQ socket sends no
/// address; a proxy usually adds 7 bytes and at most 264.
pub const MAX_ENVELOPE_BYTES: usize = 4 * 1024;

/// The maximum length of a ZMTP command, in bytes. READY usually has about 40 bytes, and 300 with the
/// longest identity; PING has at most 24.
pub const MAX_COMMAND_BYTES: usize = 4 * 1024;

/// The number of bytes kept of a frame. Of a longer frame only the beginning and the length are kept:
/// a [`Service`](crate::Service) sees zeros in place of the other bytes.
pub const MAX_KEPT_BYTES: usize = 4 * 1024;

/// The maximum number of connections. At this limit a newcomer replaces another connection or is
/// turned away; see [`SILENCE`]. A thousand leave room for other files under the usual limit of 1,024
/// open files.
pub const MAX_CONNECTIONS: usize = 1000;

/// How long a silent connection keeps its place while newcomers wait.
///
/// At [`MAX_CONNECTIONS`] a newcomer replaces a connection that has never sent a request (requests
/// that do not count as activity excluded) or, if all have, the one that has been silent for longest.
/// If that connection has been silent for less than this time, the newcomer is turned away. The
/// exception: if one network (an IPv4 address, or a /64 of IPv6) has more than half of all
/// connections, one of them makes room for a newcomer from another network. `ZeroMQ` sockets reconnect
/// by themselves.
pub const SILENCE: Duration = Duration::from_secs(10);

/// The maximum duration of a handshake, from when the connection is accepted. On a bad network a
/// handshake takes some seconds.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(10);

/// The maximum size of the replies that wait for a client that does not read them, in bytes, beyond
/// the buffers of the operating system. At this limit the server stops reading requests from the client
/// until it reads its replies. No reply is lost.
pub const MAX_WAITING_REPLY_BYTES: usize = 64 * 1024;
