//! The limits of the server and the client. No peer can make them use more memory than these limits
//! allow.

use std::time::Duration;

/// The maximum length of a request frame, in bytes. The server skips a frame that exceeds this
/// limit, and sends one error reply. The server disconnects the client unless the client sends
/// another request within [`OVERSIZED_TIME`]. If an oversized frame arrives before the empty
/// delimiter frame, no reply is possible, and the server disconnects the client immediately.
pub const MAX_REQUEST_BYTES: usize = 64 * 1024;

/// The maximum time between an oversized frame and the client's next request.
pub const OVERSIZED_TIME: Duration = Duration::from_secs(1);

/// The maximum length of a request's address envelope, in bytes. The envelope consists of all
/// frames up to and including the empty delimiter frame, with their headers. A REQ socket sends no
/// address frames, but a proxy adds one. Including its header, an address frame is usually 7 and
/// at most 264 bytes long. The reply repeats the envelope.
pub const MAX_ENVELOPE_BYTES: usize = 4 * 1024;

/// The maximum length of a ZMTP command, in bytes. A READY command is usually about 40 bytes long,
/// or about 300 bytes with the longest identity. A PING command is at most 24 bytes long.
pub const MAX_COMMAND_BYTES: usize = 4 * 1024;

/// The maximum number of bytes of a frame that the server stores. In a longer frame, the server
/// replaces the bytes beyond this limit with zeros before it passes the frame to the
/// [`Service`](crate::Service).
pub const MAX_KEPT_BYTES: usize = 4 * 1024;

/// The maximum number of connections. If another client connects when this limit is reached, the
/// server either closes an existing connection or turns the new client away; see [`SILENCE`]. A
/// process can usually have 1,024 files open, so 1,000 connections leave room for other files.
pub const MAX_CONNECTIONS: usize = 1000;

/// How long a connection must be silent before the server may close it to make room for a new
/// client.
///
/// When a client connects to a server that already has [`MAX_CONNECTIONS`] connections, the server
/// chooses a connection to close: the one that has been silent the longest among those without
/// activity (see [`Service::answer`](crate::Service::answer)) or, if there are none, among all
/// connections. If the chosen connection has been silent for less than this time, the new client is
/// turned away instead. However, if more than half of all connections belong to one network (an
/// IPv4 address or an IPv6 /64 prefix) and the new client does not, the server closes a connection
/// from that network. A client that loses its connection can reconnect; `ZeroMQ` sockets do so
/// automatically.
pub const SILENCE: Duration = Duration::from_secs(10);

/// The maximum time from accepting a connection to the end of its handshake, and from the client's
/// attempt to connect to the end of the handshake. On a bad network, a handshake can take several
/// seconds.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(10);

/// The maximum size of the pending replies to one client, in bytes, not counting the buffers of the
/// operating system. When this limit is reached, the server discards no replies, but handles no
/// further requests until the client has read some of the replies.
pub const MAX_WAITING_REPLY_BYTES: usize = 64 * 1024;

/// The maximum length of a reply that the client accepts, in bytes. The length includes the headers
/// of all frames. A longer reply is an error.
pub const MAX_REPLY_BYTES: usize = 1024 * 1024;

/// The time between two attempts of the client to connect to a server that is not running.
pub const RETRY_INTERVAL: Duration = Duration::from_millis(100);

/// The operating system sends TCP keepalive probes on connections that have been idle this long.
pub const KEEPALIVE: Duration = Duration::from_secs(60);
