//! The fuzz target for the bytes that a ZMTP connection of the server receives.
//!
//! The maximum number of bytes per read is 1 plus the lower seven bits of the input's first byte.
//! If the highest bit of the first byte is set, the target prepends a valid handshake to the rest
//! of the input.
//!
//! The target checks that the output does not depend on how many bytes are read at a time. The
//! output must consist of the greeting and complete frames, with exactly one reply for each
//! request.

use std::io::{self, ErrorKind, Read, Write};

use mmsim_zmtp::codec::{GREETING, ProtocolError, READY, REQ_READY};
use mmsim_zmtp::connection::Connection;
use mmsim_zmtp::{Answer, ClientId, ServerConfig, Service};

/// Limits that inputs of the fuzzer can exceed.
const CONFIG: ServerConfig = ServerConfig {
    max_request_bytes: 512,
    max_envelope_bytes: 64,
    max_command_bytes: 320,
    max_kept_bytes: 128,
    max_waiting_reply_bytes: 256,
    ..ServerConfig::DEFAULT
};

/// If this bit of the first byte is set, the target prepends a valid handshake to the rest of the
/// input.
pub const WITH_HANDSHAKE: u8 = 0x80;

/// The maximum number of calls to [`Connection::turn`] for one input. A connection that exceeds
/// this limit is assumed to be in an endless loop.
const MAX_TURNS: usize = 1 << 20;

/// Feeds this input to one connection with long reads and to another with short reads. Checks that
/// both connections give the same valid output.
pub fn run(input: &[u8]) {
    let Some((&choice, bytes)) = input.split_first() else { return };
    let handshake: &[&[u8]] =
        if choice & WITH_HANDSHAKE == 0 { &[] } else { &[&GREETING, REQ_READY] };
    let incoming = [&handshake.concat(), bytes].concat();
    let max_read = usize::from(choice & !WITH_HANDSHAKE) + 1;
    let whole = serve(&incoming, usize::MAX);
    let cut = serve(&incoming, max_read);
    assert!(whole == cut, "the output depends on the lengths of the reads");
    check_output(&whole);
}

#[derive(PartialEq, Eq)]
struct Outcome {
    output: Vec<u8>,
    /// The number of replies that the service has written.
    replies: usize,
    error: Option<String>,
}

fn serve(incoming: &[u8], max_read: usize) -> Outcome {
    let mut counter = Counter { replies: 0 };
    let mut connection =
        Connection::new(Wire { incoming, outgoing: Vec::new(), max_read }, &CONFIG);
    let mut error = None;
    for turn in 0.. {
        assert!(turn < MAX_TURNS, "the connection never waits for more input");
        match connection.turn(8, &mut counter) {
            Ok(turn) if turn.has_more => {}
            Ok(_) if connection.is_waiting() => {
                connection.reply(b"later");
                counter.replies += 1;
            }
            Ok(_) => break,
            Err(reason) => {
                error = Some(reason.to_string());
                break;
            }
        }
    }
    Outcome { output: connection.into_stream().outgoing, replies: counter.replies, error }
}

/// Checks that the output consists of a greeting and complete frames, with one reply for each
/// request.
fn check_output(Outcome { output, replies, .. }: &Outcome) {
    let common = output.len().min(GREETING.len());
    let (greeting, mut rest) = output.split_at(common);
    let frames = if greeting == GREETING {
        rest.strip_prefix(READY).unwrap_or(rest)
    } else {
        // The peer uses ZMTP 2.0, or the greeting is incomplete.
        rest = output.get(10..).unwrap_or_default();
        rest.strip_prefix(b"\x03\x04\0\0").or(rest.strip_prefix(b"\x03")).unwrap_or_default()
    };
    let mut last_frames = 0;
    let mut frames = frames;
    while let Some((&flags, rest)) = frames.split_first() {
        assert!(flags < 8, "flags {flags:#x}");
        let (length, body) = if flags & 2 == 0 {
            (usize::from(rest[0]), &rest[1..])
        } else {
            let (length, body) = rest.split_first_chunk().expect("a length field of 8 bytes");
            (usize::try_from(u64::from_be_bytes(*length)).expect("the length fits in memory"), body)
        };
        assert!(length <= CONFIG.max_waiting_reply_bytes, "a frame has {length} bytes");
        frames = body.get(length..).expect("the frame is complete");
        last_frames += usize::from(flags & 5 == 0);
    }
    assert_eq!(last_frames, *replies, "the numbers of replies and requests differ");
}

/// A service that replies with the length of each request and counts the replies. The reply to a
/// request that begins with `S` is due when all input has been read.
struct Counter {
    replies: usize,
}

impl Service for Counter {
    fn answer(
        &mut self,
        _: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer {
        assert!(frames > 0);
        if request.first() == Some(&b'S') {
            return Answer::Later;
        }
        self.replies += 1;
        *reply = format!("{} bytes", request.len()).into();
        Answer::Reply { is_activity: true }
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        self.replies += 1;
        *reply = reason.to_string().into();
    }
}

/// A non-blocking stream that accepts all output.
struct Wire<'a> {
    incoming: &'a [u8],
    outgoing: Vec<u8>,
    max_read: usize,
}

impl Read for Wire<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.incoming.is_empty() {
            return Err(ErrorKind::WouldBlock.into());
        }
        let length = buffer.len().min(self.max_read);
        self.incoming.read(&mut buffer[..length])
    }
}

impl Write for Wire<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.outgoing.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
