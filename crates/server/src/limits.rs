//! What a server grants its peers. No peer can make it hold more than this.

use std::time::Duration;

/// The largest frame that is received, in bytes; who announces a larger one is cut off. The
/// largest request, a state of a maze of 32×32 cells, has 2,054 bytes; the rest is room for wrong
/// requests to be told what is wrong with them.
pub const MAX_REQUEST_BYTES: usize = 64 * 1024;

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

/// How many connections there are at the same time, of whatever kind. Further ones wait in the
/// operating system's queue until one of these ends, or has been silent for [`SILENCE`]. A thousand
/// leave room for other files under the usual limit of 1,024 open files.
pub const MAX_CONNECTIONS: usize = 1000;

/// When there are as many connections as there may be and another one waits, it takes the place of
/// the one that has been silent for longest, if it has been so for this long. The sockets of
/// ZeroMQ connect again by themselves, so a client that only thinks for long does not notice.
pub const SILENCE: Duration = Duration::from_secs(10);

/// How long a connection may take until it has shown that it speaks `ZMTP`, from when it is
/// accepted. On a bad network a handshake takes some seconds.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(10);

/// Replies that wait for a peer that does not read them, in bytes, beyond what the operating
/// system holds. At this point no more of its requests are read until it reads. Nothing is lost.
pub const MAX_WAITING_REPLY_BYTES: usize = 64 * 1024;
