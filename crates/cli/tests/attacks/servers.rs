//! Servers that break the protocol, are slow, or vanish, and the clients that meet them.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;
use std::{io, iter};

use Act::{Answer, Custom, Hello};
use End::{Close, GiveUp, Reset, Serve, Wait};
use mmsim_maze::WyRand;
use mmsim_tests::{TIMEOUT, within};
use mmsim_zmtp::connection::DisconnectReason;
use mmsim_zmtp::{ClientConfig, ReqClient};

use crate::*;

/// The time limit for a reply that never arrives.
const SHORT: Duration = Duration::from_millis(50);
/// More than a client and the buffers of the system keep of a reply.
const MAX_TAKEN_BYTES: usize = 48 << 20;

const FIRST: &[u8] = b"first";

/// What a server does with its first connection.
#[derive(Clone)]
enum Act {
    /// Sends these bytes instead of its greeting and READY command.
    Hello(Vec<u8>),
    /// Sends these bytes instead of the reply to the first request.
    Answer(Vec<u8>),
    /// Does something else with the stream and the signal that the client has given up.
    Custom(fn(&mut TcpStream, &Receiver<()>)),
}

/// What a server does with its first connection afterwards.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// Answers further requests.
    Serve,
    /// Waits until the client closes the connection.
    Wait,
    /// Closes the connection when the client has given up.
    GiveUp,
    Close,
    /// Closes the connection with a TCP reset.
    Reset,
}

type Case = (&'static str, Act, End, &'static str);

const REPLY: &str = "reply: first";
const NO_REPLY: &str = "no reply";
const CLOSED: &str = "closed by the peer";
const RESET: &str = "connection reset";
const GREETING: &str = "expected a ZMTP greeting, found other bytes";
const MECHANISM: &str = "expected the security mechanism NULL, found another mechanism";
const READY: &str = "expected a READY command, found other bytes";
const VERSION: &str = "expected ZMTP 3 (ZeroMQ 4), found ZMTP 2 (ZeroMQ 3)";
const SOCKET_TYPE: &str = "expected a REP or ROUTER socket, found another socket type";
const DELIMITER: &str = "expected a reply after an empty frame, found another message";
const TOO_LONG: &str = "expected a reply of at most 1048576 bytes, found more";
const COMMAND: &str = "expected a well-formed command, found a malformed one";
const ERROR: &str = "the peer has sent an ERROR command";

/// Returns a greeting with changed bytes, and the READY command of a REP socket.
fn changed(at: usize, bytes: &[u8]) -> Act {
    let mut greeting = raw::greeting();
    greeting[at..at + bytes.len()].copy_from_slice(bytes);
    Hello([greeting, raw::ready("REP", 0)].concat())
}

/// Returns a greeting that other bytes follow.
fn greeted(rest: &[u8]) -> Act {
    Hello([&raw::greeting(), rest].concat())
}

fn property(name: &str, length: u32, value: &[u8]) -> Vec<u8> {
    let name_length = u8::try_from(name.len()).unwrap();
    [&[name_length], name.as_bytes(), &length.to_be_bytes(), value].concat()
}

fn socket_type(name: &str) -> Vec<u8> {
    property("Socket-Type", u32::try_from(name.len()).unwrap(), name.as_bytes())
}

/// Returns commands that precede the right reply.
fn before_reply(commands: &[u8]) -> Act {
    Answer([commands, &raw::request(FIRST)].concat())
}

/// Returns the header of a frame of `length` bytes.
fn header(flags: u8, length: u64) -> Vec<u8> {
    [&[flags][..], &length.to_be_bytes()].concat()
}

fn cases() -> impl Iterator<Item = Case> {
    handshakes().into_iter().chain(replies())
}

fn handshakes() -> Vec<Case> {
    let hello = |rest: &[u8]| greeted(&[&raw::ready("REP", 0), rest].concat());
    let ready = |properties: &[u8]| greeted(&raw::command("READY", properties));
    vec![
        ("closes at once", Hello(vec![]), Close, REPLY),
        ("resets at once", Hello(vec![]), Reset, REPLY),
        ("accepts and is silent", Hello(vec![]), GiveUp, NO_REPLY),
        ("half a greeting and silence", Hello(raw::greeting()[..30].into()), GiveUp, NO_REPLY),
        ("half a greeting and a reset", Hello(raw::greeting()[..30].into()), Reset, REPLY),
        ("a greeting and silence", greeted(b""), GiveUp, NO_REPLY),
        ("half a READY and silence", greeted(&raw::ready("REP", 0)[..9]), GiveUp, NO_REPLY),
        ("HTTP", Hello(b"HTTP/1.1 400 Bad Request\r\n\r\n".into()), Wait, GREETING),
        ("HTTP and a close", Hello(b"HTTP/1.1 400 Bad Request\r\n\r\n".into()), Close, GREETING),
        ("TLS alert", Hello(b"\x15\x03\x03\0\x02\x02\x28".into()), Wait, GREETING),
        ("SSH", Hello(b"SSH-2.0-OpenSSH_9.9\r\n".into()), Wait, GREETING),
        ("SMTP", Hello(b"220 mail.example ESMTP\r\n".into()), Wait, GREETING),
        ("zeros", Hello(vec![0; 4096]), Wait, GREETING),
        ("ones", Hello(vec![0xff; 4096]), Wait, MECHANISM),
        ("echo of all bytes", Custom(echo_all), Close, SOCKET_TYPE),
        ("ZMTP 1.0", Hello(b"\x01\0".into()), Wait, GREETING),
        ("ZMTP 1.0, long identity", Hello(b"\xff\0\0\0\0\0\0\0\x06\0mouse".into()), Wait, GREETING),
        ("ZMTP 2.0", Hello(b"\xff\0\0\0\0\0\0\0\x01\x7f\x01\x04\0\0".into()), Wait, VERSION),
        ("version 0", changed(10, &[0]), Wait, GREETING),
        ("version 2", changed(10, &[2]), Wait, GREETING),
        ("ZMTP 3.0", changed(10, &[3, 0]), Serve, REPLY),
        ("ZMTP 3.255", changed(10, &[3, 255]), Serve, REPLY),
        ("version 4", changed(10, &[4, 0]), Serve, REPLY),
        ("PLAIN", changed(12, b"PLAIN"), Wait, MECHANISM),
        (
            "CURVE as a server",
            changed(12, b"CURVE\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01"),
            Wait,
            MECHANISM,
        ),
        ("null", changed(12, b"null"), Wait, MECHANISM),
        ("no mechanism", changed(12, &[0; 20]), Wait, MECHANISM),
        ("NULL as a server", changed(32, &[1]), Serve, REPLY),
        ("reserved bytes of the greeting", changed(33, &[0xff; 31]), Serve, REPLY),
        ("a ROUTER socket", greeted(&raw::ready("ROUTER", 0)), Serve, REPLY),
        ("a REQ socket", greeted(&raw::ready("REQ", 0)), Wait, SOCKET_TYPE),
        ("a DEALER socket", greeted(&raw::ready("DEALER", 0)), Wait, SOCKET_TYPE),
        ("a PUB socket", greeted(&raw::ready("PUB", 0)), Wait, SOCKET_TYPE),
        ("a PAIR socket", greeted(&raw::ready("PAIR", 0)), Wait, SOCKET_TYPE),
        ("a socket without a name", greeted(&raw::ready("", 0)), Wait, SOCKET_TYPE),
        ("a long name of a socket", greeted(&raw::ready(&"REP".repeat(900), 0)), Wait, SOCKET_TYPE),
        ("READY without a socket type", ready(b""), Wait, READY),
        ("READY with other properties", ready(&property("Identity", 2, b"me")), Wait, READY),
        (
            "REP, then REQ",
            ready(&[socket_type("REP"), socket_type("REQ")].concat()),
            Wait,
            SOCKET_TYPE,
        ),
        ("REQ, then REP", ready(&[socket_type("REQ"), socket_type("REP")].concat()), Serve, REPLY),
        ("a property past the end", ready(&property("Socket-Type", 4, b"REP")), Wait, READY),
        ("a property of 4 GiB", ready(&property("Socket-Type", u32::MAX, b"REP")), Wait, READY),
        ("a property name past the end", ready(b"\xffSocket-Type"), Wait, READY),
        ("a property without a value", ready(b"\x0bSocket-Type\0\0"), Wait, READY),
        ("READY of 3 KB", greeted(&raw::ready("REP", 3000)), Serve, REPLY),
        (
            "READY of 60 KB",
            greeted(&raw::ready("REP", 60_000)),
            Wait,
            "expected a frame of at most 4096 bytes, found 60036",
        ),
        ("an ERROR command for READY", greeted(&raw::command("ERROR", b"\x02no")), Wait, READY),
        ("a message for READY", greeted(&raw::request(FIRST)), Wait, READY),
        ("READY in a message", greeted(&[0, 6, 5, b'R', b'E', b'A', b'D', b'Y']), Wait, READY),
        ("a message of 8 EiB for READY", greeted(&header(2, 1 << 63)), Wait, TOO_LONG_READY),
        ("a second READY", hello(&raw::ready("REP", 0)), Serve, REPLY),
        ("SUBSCRIBE", hello(&raw::command("SUBSCRIBE", b"W")), Serve, REPLY),
        ("a PONG", hello(&raw::command("PONG", b"\0\0")), Serve, REPLY),
    ]
}

fn replies() -> Vec<Case> {
    let reply = || raw::request(FIRST);
    let delimited = |rest: &[u8]| Answer([&raw::frame(1, b""), rest].concat());
    vec![
        ("a reply before the request", Custom(reply_early), Wait, REPLY),
        ("two replies", Custom(reply_twice), Serve, REPLY),
        ("half a further reply", Custom(reply_and_half), Serve, REPLY),
        ("a PING", Custom(|stream, _| ping_with(stream, b"")), Serve, REPLY),
        ("a PING with a context", Custom(|stream, _| ping_with(stream, b"context")), Serve, REPLY),
        (
            "an unknown command",
            before_reply(&raw::command("NO-SUCH", &SEVENS[..3000])),
            Serve,
            REPLY,
        ),
        ("a PING in the reply", Answer(ping_inside()), Serve, REPLY),
        ("a flood of PINGs", before_reply(&ping().repeat(20_000)), Serve, REPLY),
        (
            "endless PINGs",
            Custom(|stream, _| flood(stream, [b"", &ping()], usize::MAX)),
            Wait,
            NO_REPLY,
        ),
        ("a PING without a time to live", Answer(raw::command("PING", b"\0")), Wait, COMMAND),
        ("a command without a name", Answer(vec![4, 0]), Wait, COMMAND),
        ("a command name past the end", Answer(raw::frame(4, b"\xffPING")), Wait, COMMAND),
        ("an ERROR command", Answer(raw::command("ERROR", b"\x02no")), Wait, ERROR),
        ("an ERROR command and a close", Answer(raw::command("ERROR", b"")), Close, ERROR),
        (
            "a command of 60 KB",
            Answer(raw::command("NO-SUCH", &SEVENS[..60_000])),
            Wait,
            "expected a frame of at most 4096 bytes, found 60008",
        ),
        ("a command with more frames", Answer(vec![5, 0]), Wait, FLAGS[0]),
        ("a long command with more frames", Answer(vec![7, 0]), Wait, FLAGS[1]),
        ("a reserved flag", delimited(&[8, 0]), Wait, FLAGS[2]),
        ("all flags", Answer(vec![0xff; 100]), Wait, FLAGS[3]),
        ("no delimiter", Answer(raw::frame(0, b"ok")), Wait, DELIMITER),
        ("a delimiter with a body", Answer(raw::frame(1, b"x")), Wait, DELIMITER),
        ("a last delimiter", Answer(raw::frame(0, b"")), Wait, DELIMITER),
        ("a delimiter and silence", delimited(b""), GiveUp, NO_REPLY),
        ("an empty reply", delimited(&raw::frame(0, b"")), Serve, "reply: "),
        ("two frames", delimited(&[raw::frame(1, b"a"), raw::frame(0, b"b")].concat()), Serve, TWO),
        ("500,000 frames", delimited(&frames(500_000)), Serve, "500000 frames: "),
        ("1,000,000 frames", delimited(&frames(1_000_000)), Wait, TOO_LONG),
        (
            "endless frames",
            Custom(|stream, _| flood(stream, [&MORE, &MORE], MAX_TAKEN_BYTES)),
            Wait,
            TOO_LONG,
        ),
        ("endless long frames", Custom(endless_long), Wait, TOO_LONG),
        (
            "endless zeros",
            Custom(|stream, _| flood(stream, [b"", &[0]], MAX_TAKEN_BYTES)),
            Wait,
            DELIMITER,
        ),
        ("a frame of 2^63 - 1 bytes", delimited(&header(2, u64::MAX >> 1)), Wait, LENGTHS[0]),
        ("a frame of 2^64 - 1 bytes", delimited(&header(2, u64::MAX)), Wait, LENGTHS[1]),
        ("a delimiter of 2^63 - 1 bytes", Answer(header(3, u64::MAX >> 1)), Wait, LENGTHS[0]),
        ("a reply of 64 MiB", Custom(long_reply), Wait, LENGTHS[2]),
        ("the longest reply", delimited(&raw::frame(0, &SEVENS[11..])), Serve, LONGEST),
        ("a reply over the limit", delimited(&raw::frame(0, &SEVENS[10..])), Wait, TOO_LONG),
        ("half a reply and silence", Answer(reply()[..6].into()), GiveUp, NO_REPLY),
        ("half a reply and a close", Answer(reply()[..6].into()), Close, CLOSED),
        ("half a reply and a reset", Answer(reply()[..6].into()), Reset, RESET),
        (
            "half of a long reply",
            delimited(&raw::frame(0, &SEVENS[100_000..])[..500_000]),
            Close,
            CLOSED,
        ),
        ("silence", Answer(vec![]), GiveUp, NO_REPLY),
        ("a close after the request", Answer(vec![]), Close, CLOSED),
        ("a reset after the request", Answer(vec![]), Reset, RESET),
        ("a reply and a close", Answer(reply()), Close, REPLY),
        ("a late reply", Custom(reply_late), Serve, NO_REPLY),
    ]
}

static SEVENS: [u8; 1 << 20] = [7; 1 << 20];

const MORE: [u8; 2] = [1, 0];
const TWO: &str = "2 frames: b";
const LONGEST: &str = "reply: 1048565 bytes";
const TOO_LONG_READY: &str = "expected a frame of at most 4096 bytes, found 9223372036854775808";
const FLAGS: [&str; 4] = [
    "expected frame flags 0, 1, 2, 3, 4 or 6, found 0x05",
    "expected frame flags 0, 1, 2, 3, 4 or 6, found 0x07",
    "expected frame flags 0, 1, 2, 3, 4 or 6, found 0x08",
    "expected frame flags 0, 1, 2, 3, 4 or 6, found 0xff",
];
const LENGTHS: [&str; 3] = [
    "expected a frame of at most 1048576 bytes, found 9223372036854775807",
    "expected a frame of at most 1048576 bytes, found 18446744073709551615",
    "expected a frame of at most 1048576 bytes, found 67108864",
];

fn frames(count: usize) -> Vec<u8> {
    [raw::frame(1, b"").repeat(count - 1), raw::frame(0, b"")].concat()
}

fn ping() -> Vec<u8> {
    raw::command("PING", b"\0\x01context")
}

/// Returns the right reply with a PING between its frames.
fn ping_inside() -> Vec<u8> {
    [raw::frame(1, b""), ping(), raw::frame(0, FIRST)].concat()
}

fn endless_long(stream: &mut TcpStream, _: &Receiver<()>) {
    flood(stream, [&MORE, &raw::frame(1, &SEVENS[..60_000])], MAX_TAKEN_BYTES);
}

fn long_reply(stream: &mut TcpStream, _: &Receiver<()>) {
    flood(stream, [&[&MORE[..], &header(2, 64 << 20)].concat(), &[7]], MAX_TAKEN_BYTES);
}

fn echo_all(stream: &mut TcpStream, _: &Receiver<()>) {
    let mut bytes = [0; 64];
    while let Ok(length @ 1..) = stream.read(&mut bytes) {
        raw::send(stream, &bytes[..length]);
    }
}

fn reply_early(stream: &mut TcpStream, _: &Receiver<()>) {
    // In one write, so that it arrives before the client can send the request.
    raw::send(stream, &[raw::greeting(), raw::ready("REP", 0), raw::request(b"early")].concat());
}

fn reply_twice(stream: &mut TcpStream, _: &Receiver<()>) {
    accept_request(stream);
    raw::send(stream, &raw::request(FIRST).repeat(2));
}

fn reply_and_half(stream: &mut TcpStream, _: &Receiver<()>) {
    accept_request(stream);
    raw::send(stream, &[&raw::request(FIRST), &raw::request(b"second")[..7]].concat());
}

fn reply_late(stream: &mut TcpStream, given_up: &Receiver<()>) {
    accept_request(stream);
    given_up.recv_timeout(TIMEOUT).unwrap();
    raw::send(stream, &raw::request(b"late"));
}

fn ping_with(stream: &mut TcpStream, context: &[u8]) {
    accept_request(stream);
    raw::send(stream, &raw::command("PING", &[b"\0\x01", context].concat()));
    let (flags, pong) = read_frame(stream).unwrap();
    assert_eq!((flags, pong), (4, [b"\x04PONG", context].concat()));
    raw::send(stream, &raw::request(FIRST));
}

/// Answers the request with `start`, and then with the same bytes again and again, until the client
/// closes the connection.
fn flood(stream: &mut TcpStream, [start, bytes]: [&[u8]; 2], max_bytes: usize) {
    accept_request(stream);
    raw::send(stream, start);
    let (bytes, mut taken) = (bytes.repeat(65_536_usize.div_ceil(bytes.len())), 0);
    while stream.write_all(&bytes).is_ok() {
        taken += bytes.len();
        assert!(taken <= max_bytes, "the client has taken {taken} bytes");
    }
}

/// Performs the handshake and reads the first request.
fn accept_request(stream: &mut TcpStream) {
    raw::send(stream, &[raw::greeting(), raw::ready("REP", 0)].concat());
    read_greeting(stream).and_then(|()| read_request(stream)).expect("a request");
}

fn read_greeting(stream: &mut TcpStream) -> io::Result<()> {
    stream.read_exact(&mut [0; 64])
}

/// Reads a frame, and returns its flags and body.
fn read_frame(stream: &mut TcpStream) -> io::Result<(u8, Vec<u8>)> {
    let (mut head, mut long) = ([0; 2], [0; 8]);
    stream.read_exact(&mut head)?;
    let mut length = head[1].into();
    if head[0] & 2 != 0 {
        long[0] = head[1];
        stream.read_exact(&mut long[1..])?;
        length = usize::try_from(u64::from_be_bytes(long)).unwrap();
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body)?;
    Ok((head[0] & !2, body))
}

/// Reads up to the last frame of a message, which no command is, and returns the frame.
fn read_request(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    loop {
        if let (0, body) = read_frame(stream)? {
            return Ok(body);
        }
    }
}

/// Replies to each request with the request, until the client closes the connection.
fn serve(stream: &mut TcpStream) {
    while let Ok(request) = read_request(stream) {
        raw::send(stream, &raw::request(&request));
    }
}

/// Sends bytes, in chunks of random lengths if there is a generator.
fn send(stream: &mut TcpStream, mut bytes: &[u8], rng: Option<&mut WyRand>) {
    if let Some(rng) = rng {
        let max = bytes.len() / 8 + 4;
        while let Some((chunk, rest)) = bytes.split_at_checked(1 + rng.index(max)) {
            raw::send(stream, chunk);
            bytes = rest;
        }
    }
    raw::send(stream, bytes);
}

fn misbehave(
    mut stream: TcpStream,
    (act, end): (Act, End),
    (given_up, closed): (&Receiver<()>, &Sender<()>),
    rng: Option<&mut WyRand>,
) {
    match act {
        Hello(bytes) => {
            send(&mut stream, &bytes, rng);
            if end == Serve && read_greeting(&mut stream).is_err() {
                return;
            }
        }
        Answer(bytes) => {
            accept_request(&mut stream);
            send(&mut stream, &bytes, rng);
        }
        Custom(act) => act(&mut stream, given_up),
    }
    match end {
        Serve => serve(&mut stream),
        Wait => raw::wait_until_cut_off(stream),
        // Without a signal, the client has already ended.
        GiveUp => drop(given_up.recv_timeout(TIMEOUT)),
        Close => {
            // A close with unread bytes would be a reset.
            let _ = stream.shutdown(Shutdown::Write);
            let _ = closed.send(());
            raw::wait_until_cut_off(stream);
        }
        Reset => {
            raw::reset(stream);
            let _ = closed.send(());
        }
    }
}

/// A server that misbehaves on its first connection, and echoes the requests on later connections.
struct Rogue {
    endpoint: String,
    given_up: Sender<()>,
    /// Receives a signal when the server has closed the first connection, if it does.
    closed: Receiver<()>,
    has_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Rogue {
    fn start(act: Act, end: End, mut rng: Option<WyRand>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp://{}", listener.local_addr().unwrap());
        let ((given_up, signal), (close, closed)) = (mpsc::channel(), mpsc::channel());
        let has_ended = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&has_ended);
        let thread = thread::spawn(move || {
            let echo = (greeted(&raw::ready("REP", 0)), Serve);
            let behaviours = iter::once((act, end)).chain(iter::repeat(echo));
            for (stream, behaviour) in listener.incoming().zip(behaviours) {
                if ended.load(Ordering::Acquire) {
                    return;
                }
                let stream = raw::with_timeouts(stream.unwrap());
                misbehave(stream, behaviour, (&signal, &close), rng.as_mut());
            }
        });
        Self { endpoint, given_up, closed, has_ended, thread: Some(thread) }
    }

    fn client(&self) -> ReqClient {
        let retry_interval = Duration::from_millis(1);
        let config = ClientConfig { retry_interval, ..ClientConfig::DEFAULT };
        ReqClient::with_config(self.endpoint.parse().unwrap(), config).unwrap()
    }
}

impl Drop for Rogue {
    fn drop(&mut self) {
        self.has_ended.store(true, Ordering::Release);
        drop(raw::connect(&self.endpoint));
        let thread = self.thread.take().unwrap();
        if !thread::panicking() {
            within("the server to end", || thread.join()).unwrap();
        }
    }
}

/// Sends a request, and returns what the client receives within `wait`.
fn outcome(client: &mut ReqClient, request: &[u8], wait: Duration) -> String {
    let mut reply = Vec::new();
    client.send(&[request]);
    match client.receive(&mut reply, wait) {
        Ok(None) => NO_REPLY.into(),
        Ok(Some(1)) if reply.len() > 99 => format!("reply: {} bytes", reply.len()),
        Ok(Some(1)) => format!("reply: {}", reply.escape_ascii()),
        Ok(Some(frames)) => format!("{frames} frames: {}", reply.escape_ascii()),
        Err(DisconnectReason::Stream(error)) => error.kind().to_string(),
        Err(reason) => reason.to_string(),
    }
}

/// Checks what a client receives for its first request, and that it receives the replies to the
/// next requests.
fn check((name, act, end, expected): Case, request: &[u8], rng: Option<WyRand>) {
    let rogue = Rogue::start(act, end, rng);
    let mut client = rogue.client();
    let wait = if expected == NO_REPLY { SHORT } else { TIMEOUT };
    assert_eq!(outcome(&mut client, request, wait), expected, "{name}");
    let _ = rogue.given_up.send(());
    if matches!(end, Close | Reset) {
        rogue.closed.recv_timeout(TIMEOUT).unwrap();
    }
    for next in ["second", "third"] {
        let found = outcome(&mut client, next.as_bytes(), TIMEOUT);
        assert_eq!(found, format!("reply: {next}"), "after {name}");
    }
}

#[test]
fn hostile_servers() {
    println!("{} servers", cases().count());
    for case in cases() {
        check(case, FIRST, None);
    }
    let handshake = [raw::greeting(), raw::ready("REP", 0)].concat();
    for length in 0..handshake.len() {
        for end in [Close, Reset] {
            check(
                ("a part of a handshake", Hello(handshake[..length].into()), end, REPLY),
                FIRST,
                None,
            );
        }
    }
    let reply = raw::request(FIRST);
    for length in 0..reply.len() {
        for (end, expected) in [(Close, CLOSED), (Reset, RESET)] {
            check(
                ("a part of a reply", Answer(reply[..length].into()), end, expected),
                FIRST,
                None,
            );
        }
    }
    // The request exceeds the buffers of the system.
    let unread = ("a server that never reads", Hello(handshake), GiveUp, NO_REPLY);
    check(unread, &vec![7; 64 << 20], None);
}

#[test]
fn hostile_servers_that_send_in_chunks() {
    for seed in 0..2 * force() as u64 {
        println!("seed {seed}");
        for case in cases().filter(|case| !matches!(case.1, Custom(_))) {
            check(case, FIRST, Some(WyRand::new(seed)));
        }
    }
}

/// Each attempt to connect lasts until the client gives up, or until the server accepts others.
#[cfg(target_os = "linux")]
#[test]
fn server_that_never_accepts() {
    use std::net::SocketAddr;

    use socket2::{Domain, Socket, Type};

    let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    socket.bind(&"127.0.0.1:0".parse::<SocketAddr>().unwrap().into()).unwrap();
    socket.listen(0).unwrap();
    let listener = TcpListener::from(socket);
    let endpoint = format!("tcp://{}", listener.local_addr().unwrap());
    // Linux keeps one more connection than the length of the queue.
    let waiting = raw::connect(&endpoint);
    let mut client = ReqClient::new(endpoint.parse().unwrap()).unwrap();
    assert_eq!(outcome(&mut client, FIRST, SHORT), NO_REPLY);
    let server = thread::spawn(move || {
        drop((listener.accept().unwrap(), waiting));
        let mut stream = raw::with_timeouts(listener.accept().unwrap().0);
        accept_request(&mut stream);
        raw::send(&mut stream, &raw::request(b"ok"));
    });
    assert_eq!(outcome(&mut client, b"second", TIMEOUT), "reply: ok");
    server.join().unwrap();
}

/// The command fails with one short sentence, in little memory.
#[cfg(all(target_os = "linux", not(feature = "libzmq")))]
#[test]
fn command_with_hostile_servers() {
    use mmsim_tests::output;

    use crate::harness::limited;

    const REFUSED: &str = "the simulator refused reset: xxx";
    const UNEXPECTED: &str = "expected pong, ok, three bytes of walls, info or an error, found ";

    let home = Home::new();
    let reply = |body: &[u8]| Answer(raw::request(body));
    let error = [&b"error: "[..], &b"x".repeat(1_000_000)].concat();
    let more = [
        ("a long error", reply(&error), Serve, REFUSED),
        ("control characters", reply(&b"error: \x1b[2J\r\n\x07\xff".repeat(99)), Serve, "reply: "),
        ("a long reply", reply(&SEVENS[..1_000_000]), Serve, "reply: "),
    ];
    for (name, act, end, expected) in cases().chain(more) {
        let rogue = Rogue::start(act, end, None);
        let endpoint = &rogue.endpoint;
        let timeout = if expected == NO_REPLY { "0.05" } else { "300" };
        let solve = ["solve", "flood-fill", "--timeout", timeout, "--connect", endpoint];
        let output = output(&mut limited(&home.command(&solve), "-v 200000"));
        let _ = rogue.given_up.send(());
        let expected = match expected.split_once(" frames: ") {
            Some((count, _)) => {
                format!("expected a reply of one frame from {endpoint}, found {count}")
            }
            _ if expected == NO_REPLY => format!("no reply from {endpoint} within 0.05 s"),
            _ if expected == RESET => format!("no reply from {endpoint}: Connection reset by peer"),
            _ if expected == REFUSED => expected.into(),
            _ if expected.starts_with("reply: ") => UNEXPECTED.into(),
            _ => format!("no reply from {endpoint}: {expected}"),
        };
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{name}: {stderr}");
        let rest = stderr.strip_prefix(&format!("mmsim: {expected}"));
        let rest =
            rest.unwrap_or_else(|| panic!("{name}: expected {expected:?}, found {stderr:?}"));
        let rest = rest.strip_suffix('\n').unwrap();
        assert!(rest.len() < 1000 && !rest.contains(char::is_control), "{name}: {rest:?}");
    }
}
