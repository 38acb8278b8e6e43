//! What a server grants its peers. No peer can make it hold more than this.

use std::time::Duration;

/// The largest frame of a request, in bytes. A longer one is answered with an error and skipped, and
/// its sender is disconnected unless a request follows within [`OVERSIZED_TIME`]; where no reply is
/// possible, at once. The largest request, a state of a maze of 32×32 cells, has 2,054 bytes.
pub const MAX_REQUEST_BYTES: usize = 64 * 1024;

/// How long a connection stays open after a frame over the limit without a request.
pub const OVERSIZED_TIME: Duration = Duration::from_secs(1);

/// The longest address envelope of a request, in bytes as received: what comes before the empty
/// frame, put there by proxies on the way, and goes back with the reply. A REQ socket sends none,
/// a proxy adds some 7 bytes, at most 264.
pub const MAX_ENVELOPE_BYTES: usize = 4 * 1024;

/// The longest command to the socket, in bytes. That of a handshake usually has about 40, with the
/// longest name some 300; a PING has 24 at most.
pub const MAX_COMMAND_BYTES: usize = 4 * 1024;

/// How much is kept of a frame, in bytes: more than the longest request. Of a longer one the
/// beginning and the length are enough to tell what is wrong with it.
pub const MAX_KEPT_BYTES: usize = 4 * 1024;

/// The maximum number of connections. At this number a newcomer takes the place of another or is
/// turned away; see [`SILENCE`]. A thousand leave room for other files under the usual limit of 1,024
/// open files.
pub const MAX_CONNECTIONS: usize = 1000;

/// How long a connection keeps its place without a request while others wait for one.
///
/// When every place is taken, a newcomer takes that of a connection that has never sent a request
/// (malformed ones and `ping` do not count), or of the one that has been silent for longest where all
/// have. If it has been silent for less than this time, the newcomer is turned away, unless more than
/// half of all places belong to one network (an IPv4 address, or a /64 of IPv6) and the newcomer to
/// another. Sockets of `ZeroMQ` connect again by themselves.
pub const SILENCE: Duration = Duration::from_secs(10);

/// How long a connection may take until it has shown that it speaks `ZMTP`, from when it is
/// accepted. On a bad network a handshake takes some seconds.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(10);

/// Replies that wait for a peer that does not read them, in bytes, beyond what the operating
/// system holds. At this point no more of its requests are read until it reads. Nothing is lost.
pub const MAX_WAITING_REPLY_BYTES: usize = 64 * 1024;
